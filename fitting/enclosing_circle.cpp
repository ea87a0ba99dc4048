// SPDX-License-Identifier: Apache-2.0
#include "fitting/enclosing_circle.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

namespace cmm::fitting {
namespace {

constexpr int most_circle_rounds = 100;
constexpr int circle_refinements = 4;
constexpr double inside_mm = 1e-9;

struct Disc {
    Vec2 centre = Vec2::Zero();
    double radius = 0.0;
    std::vector<std::size_t> support;
};

std::optional<Disc> through(const std::vector<Vec2>& p, const std::vector<std::size_t>& support) {
    Disc disc;
    disc.support = support;
    if (support.size() == 2) {
        disc.centre = 0.5 * (p[support[0]] + p[support[1]]);
    } else {
        const Vec2 a = p[support[1]] - p[support[0]], b = p[support[2]] - p[support[0]];
        const double d = 2.0 * cross(a, b);
        if (std::abs(d) < 1e-12 * a.norm() * b.norm()) return {};
        disc.centre = p[support[0]] + Vec2(b.y() * a.squaredNorm() - a.y() * b.squaredNorm(),
                                           a.x() * b.squaredNorm() - b.x() * a.squaredNorm()) /
                                          d;
    }
    disc.radius = (p[support[0]] - disc.centre).norm();
    return disc;
}

/// The smallest disc that holds up to four points: of all pairs and triples.
Disc smallest(const std::vector<Vec2>& p) {
    Disc best;
    best.radius = -1.0;
    const auto offer = [&](const std::vector<std::size_t>& support) {
        const auto disc = through(p, support);
        if (!disc || (best.radius >= 0.0 && disc->radius >= best.radius)) return;
        for (const Vec2& point : p)
            if ((point - disc->centre).norm() > disc->radius + inside_mm) return;
        best = *disc;
    };
    for (std::size_t i = 0; i < p.size(); ++i)
        for (std::size_t j = i + 1; j < p.size(); ++j) {
            offer({i, j});
            for (std::size_t k = j + 1; k < p.size(); ++k)
                offer({i, j, k});
        }
    return best;
}

/// Where the distance from c is largest near a place: the normal points away from c.
ContourPlace away_from(const ContourGeometry& contour, const Vec2& c, const ContourPlace& near) {
    const std::size_t n = contour.size();
    const Vec2 direction = (contour.position(near) - c).normalized();
    return contour.farthest(direction, {near.index + n - 3, 8});
}

std::size_t farthest_point(const ContourGeometry& contour, const Vec2& from) {
    const auto nearer = [&](const ContourPoint& a, const ContourPoint& b) {
        return (a.position_mm - from).squaredNorm() < (b.position_mm - from).squaredNorm();
    };
    const auto points = contour.points();
    return static_cast<std::size_t>(std::max_element(points.begin(), points.end(), nearer) - points.begin());
}

}  // namespace

std::array<ContourPlace, 2> farthest_places(const ContourGeometry& contour) {
    std::size_t a = 0, b = farthest_point(contour, contour.point(a).position_mm);
    for (int round = 0; round < most_circle_rounds; ++round) {
        const std::size_t next = farthest_point(contour, contour.point(b).position_mm);
        if (next == a) break;
        a = std::exchange(b, next);
    }
    std::array<ContourPlace, 2> places{ContourPlace{a, 0.0}, ContourPlace{b, 0.0}};
    for (int k = 0; k < circle_refinements; ++k) {
        places[0] = away_from(contour, contour.position(places[1]), places[0]);
        places[1] = away_from(contour, contour.position(places[0]), places[1]);
    }
    return places;
}

EnclosingCircle enclosing_circle(const ContourGeometry& contour) {
    const auto start = farthest_places(contour);
    std::vector<ContourPlace> places(start.begin(), start.end());
    std::vector<Vec2> p{contour.position(places[0]), contour.position(places[1])};
    Disc disc = smallest(p);
    for (int round = 0; round < most_circle_rounds; ++round) {
        const ContourPlace out = away_from(contour, disc.centre, {farthest_point(contour, disc.centre), 0.0});
        const Vec2 at = contour.position(out);
        if ((at - disc.centre).norm() <= disc.radius + inside_mm) break;
        std::vector<ContourPlace> kept;
        std::vector<Vec2> kept_p;
        for (const std::size_t i : disc.support) {
            kept.push_back(places[i]);
            kept_p.push_back(p[i]);
        }
        kept.push_back(out);
        kept_p.push_back(at);
        places = std::move(kept);
        p = std::move(kept_p);
        disc = smallest(p);
        if (disc.radius < 0.0) break;
    }
    EnclosingCircle circle;
    circle.centre = disc.centre;
    circle.radius = disc.radius;
    circle.count = disc.support.size();
    if (circle.count == 2) circle.shares = {0.5, 0.5, 0.0};
    Eigen::Matrix3d balance = Eigen::Matrix3d::Ones();
    for (std::size_t k = 0; k < circle.count; ++k) {
        circle.touches[k] = places[disc.support[k]];
        const Vec2 away = (p[disc.support[k]] - disc.centre) / disc.radius;
        balance(0, static_cast<int>(k)) = away.x();
        balance(1, static_cast<int>(k)) = away.y();
    }
    // The centre stays where it is to first order when the pulls of the touching places balance.
    if (circle.count == 3) {
        const Eigen::Vector3d shares = balance.partialPivLu().solve(Eigen::Vector3d::UnitZ());
        circle.shares = {shares[0], shares[1], shares[2]};
    }
    return circle;
}

}  // namespace cmm::fitting
