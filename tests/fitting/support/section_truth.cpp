// SPDX-License-Identifier: Apache-2.0
#include "support/section_truth.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace cmm::fitting::section_truth {
namespace {

constexpr int steps_in_part = 500;
constexpr int samples_in_block = 20;

double crossed(const Vec2& a, const Vec2& b) {
    return a.x() * b.y() - a.y() * b.x();
}

template <class F>
double bisect(const F& f, double low, double high) {
    const bool rising = f(low) < 0.0;
    for (int k = 0; k < 60; ++k) {
        const double middle = 0.5 * (low + high);
        ((f(middle) < 0.0) == rising ? low : high) = middle;
    }
    return 0.5 * (low + high);
}

template <class F>
double golden_minimum(const F& f, double low, double high, int rounds) {
    const double share = 0.5 * (std::sqrt(5.0) - 1.0);
    double a = high - share * (high - low), b = low + share * (high - low), at_a = f(a), at_b = f(b);
    for (int k = 0; k < rounds; ++k) {
        if (at_a < at_b) {
            high = b;
            b = a;
            at_b = at_a;
            a = high - share * (high - low);
            at_a = f(a);
        } else {
            low = a;
            a = b;
            at_a = at_b;
            b = low + share * (high - low);
            at_b = f(b);
        }
    }
    return 0.5 * (low + high);
}

}  // namespace

double SectionTruth::End::on_arc(double abscissa) const {
    const double along = abscissa - arc_centre.x();
    return arc_radius > 0.0 ? arc_centre.y() + arc_side * std::sqrt(arc_radius * arc_radius - along * along) : 0.0;
}

Vec2 SectionTruth::End::at(double abscissa) const {
    const double w = abscissa / unit;
    const double beside = cubic[0] + w * (cubic[1] + w * (cubic[2] + w * cubic[3]));
    return origin + abscissa * axis + (on_arc(abscissa) + beside) * left(axis);
}

SectionTruth::SectionTruth(ExactSection section) : section_(std::move(section)) {
    for (int k = 0; k < 4 * steps_in_part; ++k)
        samples_.push_back(jet(double(k) / steps_in_part).position);
    for (std::size_t first = 0; first < samples_.size(); first += samples_in_block) {
        Block block{samples_[first + samples_in_block / 2], 0.0};
        for (std::size_t k = first; k < first + samples_in_block; ++k)
            block.radius = std::max(block.radius, (samples_[k] - block.middle).norm());
        blocks_.push_back(block);
    }
    // Gauss-Legendre with five points on each step: the parts are smooth.
    constexpr std::array<double, 5> node{0.0, 0.5384693101056831, -0.5384693101056831, 0.9061798459386640,
                                         -0.9061798459386640};
    constexpr std::array<double, 5> weight{0.5688888888888889, 0.4786286704993665, 0.4786286704993665,
                                           0.2369268850561891, 0.2369268850561891};
    const Vec2 origin = samples_[0];
    for (int k = 0; k < 4 * steps_in_part; ++k)
        for (std::size_t g = 0; g < 5; ++g) {
            const OutlineJet at = jet((k + 0.5 + 0.5 * node[g]) / steps_in_part);
            const Vec2 p = at.position - origin;
            const double swept = 0.5 * weight[g] / steps_in_part * 0.5 * crossed(p, at.d1);
            area_ += swept;
            centroid_ += swept * (2.0 / 3.0) * p;
        }
    centroid_ = origin + centroid_ / area_;
    le_ = end_at(true);
    te_ = end_at(false);
}

OutlineJet SectionTruth::jet(double t) const {
    return section_.at(t - 4.0 * std::floor(t / 4.0));
}

/// Newton's method from the nearest sample; within [from, to].
double SectionTruth::nearest(const Vec2& p, double from, double to, double& t) const {
    const int n = static_cast<int>(samples_.size());
    const int first = static_cast<int>(std::ceil(from * steps_in_part)), last = static_cast<int>(to * steps_in_part);
    double best = std::numeric_limits<double>::infinity();
    const auto look = [&](int k) {
        const double d = (samples_[static_cast<std::size_t>((k % n + n) % n)] - p).squaredNorm();
        if (d >= best) return;
        best = d;
        t = double(k) / steps_in_part;
    };
    // Blocks whose middle is too far away to hold a nearer sample are left out.
    double reach = std::numeric_limits<double>::infinity();
    const auto block_of = [&](int k) -> const Block& {
        return blocks_[static_cast<std::size_t>(((k % n + n) % n) / samples_in_block)];
    };
    for (int k = first; k <= last; k += samples_in_block)
        reach = std::min(reach, (block_of(k).middle - p).norm() + block_of(k).radius);
    for (int k = first; k <= last;) {
        const int end =
            std::min(last, k - (k % samples_in_block + samples_in_block) % samples_in_block + samples_in_block - 1);
        if ((block_of(k).middle - p).norm() - block_of(k).radius <= reach)
            for (int i = k; i <= end; ++i)
                look(i);
        k = end + 1;
    }
    // Each part by itself, as the curvature jumps between them.
    double least = std::numeric_limits<double>::infinity(), found = t;
    for (const double part : {std::floor(t - 0.01), std::floor(t), std::floor(t + 0.01)}) {
        const double low = std::max(from, part), high = std::min(to, part + 1 - 1e-14);
        if (!(high > low)) continue;
        double s = std::clamp(t, low, high);
        for (int step = 0; step < 30; ++step) {
            const OutlineJet at = jet(s);
            const Vec2 off = at.position - p;
            const double newton = at.d1.squaredNorm() + off.dot(at.d2);
            const double move = -off.dot(at.d1) / (newton > 0 ? newton : at.d1.squaredNorm());
            const double to_s = std::clamp(s + std::clamp(move, -0.05, 0.05), low, high);
            const bool still = std::abs(to_s - s) < 1e-15;
            s = to_s;
            if (still) break;
        }
        const double d = (jet(s).position - p).norm();
        if (d < least) {
            least = d;
            found = s;
        }
    }
    t = found;
    return least;
}

double SectionTruth::distance(const Vec2& p) const {
    double t = 0.0;
    const double d = nearest(p, 0.0, 4.0, t);
    return std::copysign(d, (p - jet(t).position).dot(jet(t).normal()));
}

std::pair<double, Vec2> SectionTruth::farthest(const Vec2& direction, double from, double to) const {
    const int n = static_cast<int>(samples_.size());
    int best = 0;
    double most = -std::numeric_limits<double>::infinity();
    for (int k = static_cast<int>(std::ceil(from * steps_in_part)); k <= static_cast<int>(to * steps_in_part); ++k) {
        const double along = samples_[static_cast<std::size_t>((k % n + n) % n)].dot(direction);
        if (along > most) {
            most = along;
            best = k;
        }
    }
    const double t = golden_minimum([&](double s) { return -jet(s).position.dot(direction); },
                                    std::max(from, double(best - 1) / steps_in_part),
                                    std::min(to, double(best + 1) / steps_in_part), 60);
    const Vec2 at = jet(t).position;
    return {std::max(most, at.dot(direction)), at};
}

double SectionTruth::extent(const Vec2& direction) const {
    return farthest(direction).first + farthest(-direction).first;
}

SectionTruth::Caliper SectionTruth::caliper() const {
    Vec2 along = (jet(section_.te_nose).position - jet(section_.le_nose).position).normalized();
    for (int k = 0; k < 60; ++k) {
        const Vec2 outward(along.y(),
                           -along.x());  // the pressure side runs from LE to TE with the material on the left
        const Vec2 a = farthest(outward, section_.le_nose, 1.5).second;
        const Vec2 b = farthest(outward, 1.5, section_.te_nose).second;
        along = (b - a).normalized();
    }
    return {extent(along), std::atan2(along.y(), along.x())};
}

double SectionTruth::largest_distance() const {
    double best = 0.0;
    for (double angle = 0.0; angle < std::numbers::pi; angle += 0.02) {
        const double d = extent({std::cos(angle), std::sin(angle)});
        if (d > best) best = d;
    }
    // The width function's maximum is the diameter.
    const auto width = [&](double a) { return -extent({std::cos(a), std::sin(a)}); };
    double at = 0.0;
    for (double angle = 0.0; angle < std::numbers::pi; angle += 0.02)
        if (-width(angle) >= best) at = angle;
    return -width(golden_minimum(width, at - 0.02, at + 0.02, 50));
}

double SectionTruth::min_circle() const {
    const Vec2 middle = 0.5 * (jet(section_.le_nose).position + jet(section_.te_nose).position);
    double farthest = 0.0;
    for (const Vec2& p : samples_)
        farthest = std::max(farthest, (p - middle).norm());
    std::vector<Vec2> hull;  // what is nearer than that to the middle cannot touch
    for (const Vec2& p : samples_)
        if ((p - middle).norm() > 0.6 * farthest) hull.push_back(p);
    const auto radius = [&](const Vec2& c) {
        double most = 0.0;
        for (const Vec2& p : hull)
            most = std::max(most, (p - c).squaredNorm());
        return most;
    };
    const double reach = 0.3 * (jet(section_.le_nose).position - middle).norm();
    Vec2 best = middle;
    const auto at_x = [&](double x) {
        const double y = golden_minimum(
            [&](double v) {
                return radius({x, v});
            },
            middle.y() - reach, middle.y() + reach, 55);
        best = {x, y};
        return radius(best);
    };
    at_x(golden_minimum(at_x, middle.x() - reach, middle.x() + reach, 55));
    // Between the samples: the farthest place in each direction from this centre.
    double most = 0.0;
    for (int k = 0; k < 4 * steps_in_part; ++k) {
        const std::size_t i = static_cast<std::size_t>(k);
        if ((samples_[i] - best).squaredNorm() < radius(best) * (1 - 1e-4)) continue;
        const double t = golden_minimum([&](double s) { return -(jet(s).position - best).squaredNorm(); },
                                        double(k - 1) / steps_in_part, double(k + 1) / steps_in_part, 45);
        most = std::max(most, (jet(t).position - best).norm());
    }
    return 2.0 * most;
}

SectionTruth::Circle SectionTruth::circle_on(const Vec2& start, const Vec2& across) const {
    const auto off = [&](double x) {
        double t = 0.0;
        const Vec2 c = start + x * across;
        return nearest(c, section_.te_nose, section_.le_nose + 4.0, t) -
               nearest(c, section_.le_nose, section_.te_nose, t);
    };
    // Secant steps, held in a bracket.
    double low = -1.0, high = 1.0;
    double at_low = off(low), at_high = off(high);
    while (at_low * at_high > 0.0 && high < 40.0) {
        low *= 2.0;
        high *= 2.0;
        at_low = off(low);
        at_high = off(high);
    }
    double x = 0.0;
    for (int k = 0; k < 60; ++k) {
        x = k % 3 == 2 ? 0.5 * (low + high) : low + (high - low) * at_low / (at_low - at_high);
        const double value = off(x);
        if (std::abs(value) < 1e-13 || high - low < 1e-13) break;
        ((value > 0.0) == (at_low > 0.0) ? low : high) = x;
        ((value > 0.0) == (at_low > 0.0) ? at_low : at_high) = value;
    }
    double t = 0.0;
    const Vec2 c = start + x * across;
    return {c, nearest(c, section_.le_nose, section_.te_nose, t)};
}

SectionTruth::Circle SectionTruth::circle(double w) const {
    const Vec2 direction = (section_.camber(w + 1e-5) - section_.camber(w - 1e-5)).normalized();
    return circle_on(section_.camber(w), left(direction));
}

/// Length over turn of the shortest arc that turns by 120 degrees about a nose.
double SectionTruth::scale_about(double t_nose) const {
    std::vector<double> s(1, 0.0), angle(1, 0.0), t;
    const double from = t_nose - 0.9, step = 1.8 / 3000;
    OutlineJet last = jet(from);
    t.push_back(from);
    for (int k = 1; k <= 3000; ++k) {
        const OutlineJet at = jet(from + k * step);
        s.push_back(s.back() + (at.position - last.position).norm());
        angle.push_back(angle.back() + std::atan2(crossed(last.normal(), at.normal()), last.normal().dot(at.normal())));
        last = at;
    }
    const double turn = 2.0 * std::numbers::pi / 3.0;
    double best = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0, j = 0; i < s.size(); ++i) {
        while (j < s.size() && angle[j] - angle[i] < turn)
            ++j;
        if (j == s.size()) break;
        const double over = (angle[j] - angle[i] - turn) / (angle[j] - angle[j - 1]);
        best = std::min(best, s[j] - over * (s[j] - s[j - 1]) - s[i]);
    }
    return best / turn;
}

SectionTruth::End SectionTruth::end_at(bool le) const {
    End end;
    const double t_nose = le ? section_.le_nose : section_.te_nose;
    end.scale = scale_about(t_nose);
    end.point = jet(t_nose).position;
    double perimeter = 0.0;
    for (std::size_t k = 0; k < samples_.size(); ++k)
        perimeter += (samples_[(k + 1) % samples_.size()] - samples_[k]).norm();
    end.first = 2.0 * end.scale;
    end.unit = end.first + 0.12 * perimeter;
    for (int round = 0; round < 8; ++round)
        continue_line(le, end);
    return end;
}

/// Distances count from the point that the continuation gives.
void SectionTruth::continue_line(bool le, End& end) const {
    end.origin = end.point;
    const auto w_of = [&](double w) { return le ? w : 1.0 - w; };
    const auto reaches = [&](double w) { return (circle(w_of(w)).centre - end.origin).norm() - end.unit; };
    end.axis = (circle(w_of(bisect(reaches, 0.05, 0.7))).centre - end.origin).normalized();
    constexpr int count = 25;
    Eigen::Matrix<double, count, 4> design;
    Eigen::Matrix<double, count, 3> circles;
    Eigen::Matrix<double, count, 1> ordinate;
    for (int k = 0; k < count; ++k) {
        const double x = end.first + (end.unit - end.first) * k / (count - 1);
        const double w =
            bisect([&](double v) { return (section_.camber(w_of(v)) - end.origin).dot(end.axis) - x; }, 0.0, 0.8);
        const Circle c = circle_on(section_.camber(w_of(w)), left(end.axis));
        const double u = (c.centre - end.origin).dot(end.axis) / end.unit;
        design.row(k) << 1.0, u, u * u, u * u * u;
        ordinate[k] = (c.centre - end.origin).dot(left(end.axis));
        circles.row(k) << 1.0, u * end.unit, std::pow(u * end.unit, 2) + ordinate[k] * ordinate[k];
    }
    // The circle y = d + b x + a (x^2 + y^2) through the centres; none where they lie on a straight line.
    const Eigen::Vector3d arc = circles.colPivHouseholderQr().solve(ordinate);
    end.arc_centre = Vec2(-arc[1], 1.0) / (2.0 * arc[2]);
    end.arc_radius = std::sqrt(end.arc_centre.squaredNorm() - arc[0] / arc[2]);
    end.arc_side = arc[2] > 0.0 ? -1.0 : 1.0;
    if (!(end.arc_radius < 1000.0 * end.unit)) end.arc_radius = 0.0;
    Eigen::Matrix<double, count, 1> beside;
    for (int k = 0; k < count; ++k)
        beside[k] = ordinate[k] - end.on_arc(design(k, 1) * end.unit);
    end.cubic = design.householderQr().solve(beside);
    end.x = bisect([&](double x) { return distance(end.at(x)); }, -2.0 * end.scale, end.scale);
    end.point = end.at(end.x);
}

double SectionTruth::stagger() const {
    const Vec2 step = tail() - nose();
    return std::atan2(step.y(), step.x());
}

SectionTruth::Thickest SectionTruth::thickest() const {
    double best = 0.0, at = 0.5;
    for (double w = 0.08; w < 0.92; w += 0.02)
        if (const double r = circle(w).radius; r > best) {
            best = r;
            at = w;
        }
    const double w = golden_minimum([&](double v) { return -circle(v).radius; }, at - 0.02, at + 0.02, 36);
    const Circle c = circle(w);
    Thickest out{};
    out.diameter = 2.0 * c.radius;
    out.centre = c.centre;
    const Vec2 step = tail() - nose();
    out.on_chord = (c.centre - nose()).dot(step) / step.squaredNorm();
    // The line from nose to tail in small steps; near the ends on the cubics.
    std::vector<Vec2> line;
    for (int k = 0; k < 60; ++k)
        line.push_back(le_.at(le_.x + (le_.first - le_.x) * k / 60));
    double to_here = 0.0;
    for (int k = 0; k <= 300; ++k) {
        const Vec2 p = circle(0.001 + 0.998 * k / 300).centre;
        if ((p - le_.origin).dot(le_.axis) < le_.first || (p - te_.origin).dot(te_.axis) < te_.first) continue;
        line.push_back(p);
    }
    for (int k = 60; k >= 0; --k)
        line.push_back(te_.at(te_.x + (te_.first - te_.x) * k / 60));
    double length = 0.0, nearest_squared = std::numeric_limits<double>::infinity();
    for (std::size_t i = 1; i < line.size(); ++i) {
        const Vec2 d = line[i] - line[i - 1];
        const double share = std::clamp((c.centre - line[i - 1]).dot(d) / d.squaredNorm(), 0.0, 1.0);
        if (const double off = (line[i - 1] + share * d - c.centre).squaredNorm(); off < nearest_squared) {
            nearest_squared = off;
            to_here = length + share * d.norm();
        }
        length += d.norm();
    }
    out.on_camber = to_here / length;
    return out;
}

std::pair<Vec2, Vec2> SectionTruth::camber_at(bool le, double distance) const {
    const End& end = le ? le_ : te_;
    const auto w_of = [&](double w) { return le ? w : 1.0 - w; };
    if ((end.at(end.first) - end.point).norm() >= distance) {
        const double x = bisect([&](double v) { return (end.at(v) - end.point).norm() - distance; }, end.x, end.first);
        return {end.at(x), (end.at(x + 1e-5) - end.at(x - 1e-5)).normalized()};
    }
    const double w =
        bisect([&](double v) { return (circle(w_of(v)).centre - end.point).norm() - distance; }, 0.005, 0.8);
    const Vec2 direction = circle(w_of(w + 1e-4)).centre - circle(w_of(w - 1e-4)).centre;
    return {circle(w_of(w)).centre, direction.normalized()};
}

double SectionTruth::edge_thickness(bool le, double distance) const {
    const auto [q, direction] = camber_at(le, distance);
    double thickness = 0.0;
    for (const double sign : {1.0, -1.0}) {
        const Vec2 out = sign * left(direction);
        double high = 0.05;
        while (this->distance(q + high * out) < 0.0)
            high += 0.05;
        const Vec2 from = q;
        thickness += bisect([&](double x) { return this->distance(from + x * out); }, high - 0.05, high);
    }
    return thickness;
}

double SectionTruth::edge_angle(bool le, double near, double far) const {
    const Vec2 step = camber_at(le, far).first - camber_at(le, near).first;
    return le ? std::atan2(step.y(), step.x()) : std::atan2(-step.y(), -step.x());
}

}  // namespace cmm::fitting::section_truth
