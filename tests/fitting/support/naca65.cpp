// SPDX-License-Identifier: Apache-2.0
#include "support/naca65.hpp"

#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <utility>

namespace cmm::fitting::naca65 {
namespace {

using Vec2 = Eigen::Vector2d;

constexpr double camber_mm = 65.104, camber_rad = 35.0 * std::numbers::pi / 180.0;
constexpr double curvature = camber_rad / camber_mm;
constexpr double scale = 0.8;  // of 10 %
constexpr double le_mm = 0.4, te_mm = 0.25;
constexpr int side_points = 60000, edge_points = 8000;

// Stations and half thicknesses of NACA 65-010, per cent of the chord; radius of its nose.
constexpr double nose_percent = 0.687;
constexpr std::size_t stations = 26;
constexpr std::array<double, stations> station_percent{0.0,  0.5,  0.75, 1.25, 2.5,  5.0,  7.5,  10.0, 15.0,
                                                       20.0, 25.0, 30.0, 35.0, 40.0, 45.0, 50.0, 55.0, 60.0,
                                                       65.0, 70.0, 75.0, 80.0, 85.0, 90.0, 95.0, 100.0};
constexpr std::array<double, stations> half_percent{0.0,   0.772, 0.932, 1.169, 1.574, 2.177, 2.647, 3.040, 3.666,
                                                    4.143, 4.503, 4.760, 4.924, 4.996, 4.963, 4.812, 4.530, 4.146,
                                                    3.682, 3.156, 2.584, 1.987, 1.385, 0.810, 0.306, 0.0};

/// Half the thickness over u, the square root of the station's share of the camber line, where the nose is regular: the
/// cubic spline through the ordinates that has the nose's radius at one end and no second derivative at the other.
class Thickness {
  public:
    Thickness() {
        for (std::size_t i = 0; i < stations; ++i) {
            u_[i] = std::sqrt(station_percent[i] / 100.0);
            y_[i] = scale * camber_mm * half_percent[i] / 100.0;
        }
        const double slope = scale * camber_mm * std::sqrt(2.0 * nose_percent / 100.0);
        std::array<double, stations> diagonal{}, right{};
        const auto width = [&](std::size_t i) { return u_[i + 1] - u_[i]; };
        const auto rise = [&](std::size_t i) { return (y_[i + 1] - y_[i]) / width(i); };
        diagonal[0] = 2.0 * width(0);
        right[0] = 6.0 * (rise(0) - slope);
        for (std::size_t i = 1; i + 1 < stations; ++i) {
            const double factor = width(i - 1) / diagonal[i - 1];
            diagonal[i] = 2.0 * (width(i - 1) + width(i)) - factor * width(i - 1);
            right[i] = 6.0 * (rise(i) - rise(i - 1)) - factor * right[i - 1];
        }
        for (std::size_t i = stations - 1; i-- > 0;)
            second_[i] = (right[i] - width(i) * second_[i + 1]) / diagonal[i];
    }

    struct Value {
        double y, by_u;
    };
    Value at(double u) const {
        std::size_t i = 0;
        while (i + 2 < stations && u > u_[i + 1])
            ++i;
        const double h = u_[i + 1] - u_[i], a = (u_[i + 1] - u) / h, b = 1.0 - a;
        return {
            a * y_[i] + b * y_[i + 1] + h * h / 6.0 * ((a * a * a - a) * second_[i] + (b * b * b - b) * second_[i + 1]),
            (y_[i + 1] - y_[i]) / h +
                h / 6.0 * ((1.0 - 3.0 * a * a) * second_[i] + (3.0 * b * b - 1.0) * second_[i + 1])};
    }

  private:
    std::array<double, stations> u_{}, y_{}, second_{};
};

class Outline {
  public:
    explicit Outline(double offset_mm) : offset_(offset_mm) {
        const Edge le = edge(le_mm, 0.02, 0.3), te = edge(te_mm, 0.85, 0.9999);
        add_side(-1.0, le.lower, te.lower, 0);
        add_arc(te, at(te.lower, -1.0).normal, at(te.upper, 1.0).normal, 1);
        add_side(1.0, te.upper, le.upper, 2);
        add_arc(le, at(le.upper, 1.0).normal, at(le.lower, -1.0).normal, 3);
    }

    std::vector<OutlinePoint> take() && { return std::move(points_); }

  private:
    /// A circle that touches both sides.
    struct Edge {
        double radius, upper, lower;  // where, by u
        Vec2 centre;
    };

    /// On the upper (1) or the lower (-1) side.
    OutlinePoint at(double u, double side) const {
        const double s = camber_mm * u * u, speed = 2.0 * camber_mm * u, angle = curvature * (s - 0.5 * camber_mm);
        const Vec2 along(std::cos(angle), -std::sin(angle)), across(std::sin(angle), std::cos(angle));
        const Vec2 middle = Vec2(std::sin(angle), std::cos(angle) - 1.0) / curvature;
        const auto [y, by_u] = thickness_.at(u);
        const Vec2 normal = side * speed * (1.0 + side * curvature * y) * across - by_u * along;
        return {middle + side * y * across, normal.normalized(), 0};
    }

    Vec2 centre_from(double u, double side, double radius) const {
        const OutlinePoint p = at(u, side);
        return p.position - radius * p.normal;
    }

    /// Newton's method for the centre that both sides agree on, from where they would on a straight camber line.
    Edge edge(double radius, double low, double high) const {
        const auto off = [&](double u) {
            const double angle = curvature * camber_mm * (u * u - 0.5);
            return thickness_.at(u).y - radius * at(u, 1.0).normal.dot(Vec2(std::sin(angle), std::cos(angle)));
        };
        const double at_low = off(low);
        for (int i = 0; i < 60; ++i) {
            const double middle = 0.5 * (low + high);
            (off(middle) * at_low > 0.0 ? low : high) = middle;
        }
        Vec2 u(low, low);  // upper, lower
        for (int round = 0; round < 20; ++round) {
            constexpr double step = 1e-6;
            const auto slope = [&](double x, double side) {
                return Vec2((centre_from(x + step, side, radius) - centre_from(x - step, side, radius)) / (2.0 * step));
            };
            const Vec2 gap = centre_from(u[0], 1.0, radius) - centre_from(u[1], -1.0, radius);
            const Vec2 a = slope(u[0], 1.0), b = -slope(u[1], -1.0);
            const double determinant = a.x() * b.y() - a.y() * b.x();
            u -= Vec2(gap.x() * b.y() - gap.y() * b.x(), a.x() * gap.y() - a.y() * gap.x()) / determinant;
        }
        return {radius, u[0], u[1], centre_from(u[0], 1.0, radius)};
    }

    void add(OutlinePoint p, int part) {
        p.position += offset_ * p.normal;
        p.part = part;
        points_.push_back(p);
    }

    void add_side(double side, double from, double to, int part) {
        for (int i = 0; i < side_points; ++i)
            add(at(from + (to - from) * i / (side_points - 1), side), part);
    }

    /// Counter-clockwise from one normal to the other.
    void add_arc(const Edge& edge, const Vec2& from, const Vec2& to, int part) {
        for (const Vec2& normal : normals_between(from, to, edge_points))
            add({edge.centre + edge.radius * normal, normal, part}, part);
    }

    Thickness thickness_;
    double offset_;
    std::vector<OutlinePoint> points_;
};

}  // namespace

std::vector<Vec2> normals_between(const Vec2& from, const Vec2& to, int count) {
    const double begin = std::atan2(from.y(), from.x());
    double end = std::atan2(to.y(), to.x());
    while (end < begin)
        end += 2.0 * std::numbers::pi;
    std::vector<Vec2> normals;
    for (int i = 1; i + 1 < count; ++i) {
        const double angle = begin + (end - begin) * i / (count - 1);
        normals.emplace_back(std::cos(angle), std::sin(angle));
    }
    return normals;
}

std::vector<OutlinePoint> outline(double offset_mm) {
    return Outline(offset_mm).take();
}

}  // namespace cmm::fitting::naca65
