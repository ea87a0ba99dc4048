// SPDX-License-Identifier: Apache-2.0
#include "fitting/offset.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace cmm::fitting {
namespace {

std::vector<OffsetPoint> sample(const ClosedCurve& curve, double radius, std::size_t count) {
    const PiecewiseCubic& spline = curve.spline();
    const auto& breaks = spline.breaks();
    std::vector<double> turn(spline.spans());
    double total_turn = 0.0;
    for (std::size_t k = 0; k < spline.spans(); ++k) {
        turn[k] = std::abs(turn_angle(spline.pieces()[k][1], spline.pieces()[(k + 1) % spline.spans()][1]));
        total_turn += turn[k];
    }
    std::vector<OffsetPoint> points;
    points.reserve(count + spline.spans());
    for (std::size_t k = 0; k < spline.spans(); ++k) {
        const double h = breaks[k + 1] - breaks[k];
        const double share = 0.75 * h / spline.period() + 0.25 * turn[k] / total_turn;
        const auto parts =
            std::max<std::size_t>(1, static_cast<std::size_t>(std::ceil(share * static_cast<double>(count))));
        for (std::size_t j = 0; j < parts; ++j) {
            const double t = breaks[k] + h * static_cast<double>(j) / static_cast<double>(parts);
            const Jet jet = spline.jet_in(k, t);
            const Vec2 normal = jet.right_normal();
            points.push_back({jet.position - radius * normal, normal, t});
        }
    }
    return points;
}

/// Marks the points around `at` that are nearer than the radius to the source curve.
void mark_loop(const std::vector<OffsetPoint>& points, double radius, std::size_t at, std::vector<char>& cut) {
    const std::size_t n = points.size();
    const auto source = [&](std::size_t i) -> Vec2 { return points[i].position + radius * points[i].normal; };
    const double limit = radius * radius * (1.0 - 1e-9);
    const auto too_near = [&](std::size_t i) {
        for (const int direction : {1, -1}) {
            double walked = 0.0;
            std::size_t j = i;
            Vec2 last = source(i);
            for (std::size_t step = 0; step < n / 2 && walked < std::numbers::pi * radius; ++step) {
                j = direction > 0 ? (j + 1) % n : (j + n - 1) % n;
                const Vec2 here = source(j);
                if ((here - points[i].position).squaredNorm() < limit) return true;
                walked += (here - last).norm();
                last = here;
            }
        }
        return false;
    };
    cut[at] = 1;
    for (std::size_t i = (at + 1) % n; !cut[i] && too_near(i); i = (i + 1) % n)
        cut[i] = 1;
    for (std::size_t i = (at + n - 1) % n; !cut[i] && too_near(i); i = (i + n - 1) % n)
        cut[i] = 1;
}

bool runs_backwards(const OffsetPoint& from, const OffsetPoint& to) {
    const Vec2 normal = from.normal + to.normal;
    return (to.position - from.position).dot(Vec2(-normal.y(), normal.x())) <= 0.0;
}

void drop(std::vector<OffsetPoint>& points, const std::vector<char>& cut) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < points.size(); ++i)
        if (!cut[i]) points[kept++] = points[i];
    points.resize(kept);
}

}  // namespace

Offset offset_inwards(const ClosedCurve& curve, double radius_mm, std::size_t count) {
    Offset offset;
    offset.points = sample(curve, radius_mm, count);
    if (!(radius_mm > 0.0)) return offset;
    const std::size_t sampled = offset.points.size();
    // Twice: what is left after the cut may still step back by less than one sample.
    for (int pass = 0; pass < 3 && offset.points.size() > 8; ++pass) {
        std::vector<char> cut(offset.points.size(), 0);
        bool any = false;
        for (std::size_t i = 0; i < offset.points.size(); ++i) {
            const std::size_t next = (i + 1) % offset.points.size();
            if (cut[i] || cut[next] || !runs_backwards(offset.points[i], offset.points[next])) continue;
            any = true;
            mark_loop(offset.points, radius_mm, i, cut);
        }
        if (!any) break;
        drop(offset.points, cut);
    }
    offset.trimmed = sampled - offset.points.size();
    return offset;
}

}  // namespace cmm::fitting
