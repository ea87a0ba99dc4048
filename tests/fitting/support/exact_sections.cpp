// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "support/section_truth.hpp"

namespace cmm::fitting::section_truth {
namespace {

/// Position with derivatives by finite differences of fourth order, inside a part.
OutlineJet differences(const std::function<Vec2(double)>& place, double t) {
    const double part = std::floor(t), h = 2e-4;
    const double s = std::clamp(t, part + 2.001 * h, part + 1 - 2.001 * h), d = t - s;
    const Vec2 a = place(s - 2 * h), b = place(s - h), c = place(s), e = place(s + h), f = place(s + 2 * h);
    const Vec2 d1 = (a - 8 * b + 8 * e - f) / (12 * h), d2 = (-a + 16 * b - 30 * c + 16 * e - f) / (12 * h * h);
    return {place(t), d1 + d * d2, d2};
}

}  // namespace

ExactSection of_family(const families::Blade& blade) {
    const families::Shape s = blade.shape();
    const auto camber = [s](double w) -> Vec2 {
        const double k = 4 * s.camber, y = s.chord * (w - w * w) * (k - s.skew + 2 * s.skew * w), x = s.chord * w;
        return Vec2(std::cos(s.stagger) * x - std::sin(s.stagger) * y,
                    std::sin(s.stagger) * x + std::cos(s.stagger) * y) +
               s.shift;
    };
    return {blade.name(), [blade](double t) { return blade.at(t); }, camber};
}

ExactSection placed(const ExactSection& section, double angle, const Vec2& shift) {
    const Eigen::Rotation2Dd turn(angle);
    ExactSection out = section;
    out.at = [section, turn, shift](double t) {
        const OutlineJet jet = section.at(t);
        return OutlineJet{turn * jet.position + shift, turn * jet.d1, turn * jet.d2};
    };
    out.camber = [section, turn, shift](double w) -> Vec2 { return turn * section.camber(w) + shift; };
    return out;
}

ExactSection naca_4_digit(double chord, double thickness, double m, double p, double te_half) {
    const auto camber = [m, p](double x) {
        if (m == 0.0) return 0.0;
        return x < p ? m / (p * p) * (2 * p * x - x * x) : m / ((1 - p) * (1 - p)) * (1 - 2 * p + 2 * p * x - x * x);
    };
    const auto slope = [m, p](double x) {
        if (m == 0.0) return 0.0;
        return x < p ? 2 * m / (p * p) * (p - x) : 2 * m / ((1 - p) * (1 - p)) * (p - x);
    };
    const auto half = [thickness](double x) {
        return 5 * thickness *
               (0.2969 * std::sqrt(x) - 0.1260 * x - 0.3516 * x * x + 0.2843 * x * x * x - 0.1036 * x * x * x * x);
    };
    double end = 0.9;
    for (double step = 0.05; step > 1e-15; step *= 0.5)
        if (end + step < 1.0 && half(end + step) * chord > te_half) end += step;
    // In v = sqrt(x) the nose is smooth; sign +1 upper, -1 lower.
    const auto side = [=](double v, double sign) -> Vec2 {
        const double x = v * v, angle = std::atan(slope(x)), y = half(x);
        return chord * Vec2(x - sign * y * std::sin(angle), camber(x) + sign * y * std::cos(angle));
    };
    const double v_end = std::sqrt(end), v_nose = 0.1;
    const auto tangent = [=](double sign) -> Vec2 {
        const double h = 1e-4;
        return (3 * side(v_end, sign) - 4 * side(v_end - h, sign) + side(v_end - 2 * h, sign)).normalized();
    };
    // The arc that meets both ends with their tangents, as nearly as one arc can: centre where the normals meet.
    const Vec2 upper = side(v_end, 1), lower = side(v_end, -1), nu = left(tangent(1)), nl = -left(tangent(-1));
    const double across = nu.x() * nl.y() - nu.y() * nl.x();
    const Vec2 gap = lower - upper;
    const double reach = (gap.x() * nl.y() - gap.y() * nl.x()) / across;
    const Vec2 centre = upper + reach * nu;
    const double radius_upper = (upper - centre).norm(), radius_lower = (lower - centre).norm();
    const double from = std::atan2(lower.y() - centre.y(), lower.x() - centre.x());
    double to = std::atan2(upper.y() - centre.y(), upper.x() - centre.x());
    while (to < from)
        to += 2 * std::numbers::pi;
    const auto place = [=](double t) -> Vec2 {
        const double part = std::floor(t), w = t - part;
        if (part == 0) {
            const double v = v_nose * (1 - 2 * w);
            return side(std::abs(v), v >= 0 ? 1 : -1);
        }
        if (part == 1) return side(v_nose + (v_end - v_nose) * w, -1);
        if (part == 3) return side(v_end + (v_nose - v_end) * w, 1);
        const double a = from + (to - from) * w, r = radius_lower + (radius_upper - radius_lower) * w;
        return centre + r * Vec2(std::cos(a), std::sin(a));
    };
    ExactSection out;
    out.name = "naca";
    out.at = [place](double t) { return differences(place, t); };
    const double length = (centre.x() + radius_upper) / chord;
    out.camber = [=](double w) -> Vec2 {
        const double x = w * length;
        return chord * Vec2(x, camber(std::min(x, 1.0)));
    };
    return out;
}

ExactSection envelope(double chord, double thickness, double camber_rad, double r1, double r2) {
    const double k = chord - r1 - r2, th = camber_rad;
    const double big = th > 0 ? k / (2 * std::sin(th / 2)) : 0, length = th > 0 ? big * th : k;
    const double h = thickness / 2 - (r1 + r2) / 2;
    const auto rho = [=](double t) {
        return r1 * (1 - t) + r2 * t + h * 0.5 * (4 * t * (1 - t) + 6.75 * t * (1 - t) * (1 - t));
    };
    const auto slope = [=](double t) {
        return (r2 - r1 + h * 0.5 * (4 * (1 - 2 * t) + 6.75 * ((1 - t) * (1 - t) - 2 * t * (1 - t)))) / length;
    };
    const auto middle = [=](double t) -> Vec2 {
        if (th == 0) return {k * (t - 0.5), 0.0};
        const double a = (t - 0.5) * th;
        return {big * std::sin(a), big * (std::cos(a) - std::cos(th / 2))};
    };
    const auto along = [=](double t) -> Vec2 {
        const double a = (t - 0.5) * th;
        return {std::cos(a), -std::sin(a)};
    };
    const auto normal = [=](double t, double sign) -> Vec2 {
        const double q = slope(t);
        return -q * along(t) + sign * std::sqrt(1 - q * q) * left(along(t));
    };
    const auto edge = [=](double t, double from, double to, double w) -> Vec2 {
        const double a = from + (to - from) * w;
        return middle(t) + rho(t) * Vec2(std::cos(a), std::sin(a));
    };
    const auto angle = [](const Vec2& v) { return std::atan2(v.y(), v.x()); };
    const double le_from = angle(normal(0, 1));
    double le_to = angle(normal(0, -1));
    while (le_to < le_from)
        le_to += 2 * std::numbers::pi;
    const double te_from = angle(normal(1, -1));
    double te_to = angle(normal(1, 1));
    while (te_to < te_from)
        te_to += 2 * std::numbers::pi;
    const auto place = [=](double t) -> Vec2 {
        const double part = std::floor(t), w = t - part;
        if (part == 0) return edge(0, le_from, le_to, w);
        if (part == 2) return edge(1, te_from, te_to, w);
        const double s = part == 1 ? w : 1 - w;
        return middle(s) + rho(s) * normal(s, part == 1 ? -1 : 1);
    };
    ExactSection out;
    out.name = "envelope";
    out.at = [place](double t) { return differences(place, t); };
    out.camber = [=](double w) -> Vec2 {
        const double s = w * (length + r1 + r2) - r1;
        if (s < 0) return middle(0) + s * along(0);
        if (s > length) return middle(1) + (s - length) * along(1);
        return middle(s / length);
    };
    return out;
}

}  // namespace cmm::fitting::section_truth
