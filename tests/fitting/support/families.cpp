// SPDX-License-Identifier: Apache-2.0
#include "support/families.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "core/rng.hpp"
#include "support/outline_search.hpp"

namespace cmm::fitting::families {
namespace {

constexpr double degree = std::numbers::pi / 180.0;

Vec2 turned(const Vec2& p, double angle) {
    return {std::cos(angle) * p.x() - std::sin(angle) * p.y(), std::sin(angle) * p.x() + std::cos(angle) * p.y()};
}

Vec2 left_of(const Vec2& v) {
    return {-v.y(), v.x()};
}

/// Value and two derivatives by w.
std::array<double, 3> half_thickness(double h0, double h1, double d0, double d1, double bump, double forward,
                                     double w) {
    // Cubic Hermite polynomial between the ends, plus a bump that leaves values and slopes of the ends alone.
    const double c2 = 3 * (h1 - h0) - 2 * d0 - d1, c3 = 2 * (h0 - h1) + d0 + d1;
    const double b = w * w * (1 - w) * (1 - w), b1 = 2 * w * (1 - w) * (1 - 2 * w), b2 = 2 - 12 * w + 12 * w * w;
    const double s = 1 + forward * (1 - 2 * w), s1 = -2 * forward;
    return {h0 + w * (d0 + w * (c2 + w * c3)) + bump * b * s, d0 + w * (2 * c2 + 3 * w * c3) + bump * (b1 * s + b * s1),
            2 * c2 + 6 * w * c3 + bump * (b2 * s + 2 * b1 * s1)};
}

}  // namespace

std::string to_string(Family family) {
    switch (family) {
        case Family::compressor:
            return "compressor";
        case Family::turbine:
            return "turbine";
        case Family::fan:
            return "fan";
    }
    return "";
}

double OutlineJet::curvature() const {
    return (d1.x() * d2.y() - d1.y() * d2.x()) / std::pow(d1.norm(), 3);
}

Blade::Blade(const Shape& shape, std::string name) : shape_(shape), name_(std::move(name)) {
    le_local_ = end_at(true);
    te_local_ = end_at(false);
    pressure_ = make_side(-1);
    suction_ = make_side(1);
    le_ = le_local_;
    te_ = te_local_;
    for (End* end : {&le_, &te_}) {
        end->nose = turned(end->nose, shape.stagger) + shape.shift;
        end->centre = turned(end->centre, shape.stagger) + shape.shift;
        end->inward = turned(end->inward, shape.stagger);
    }
    samples_ = sample_outline([this](double t) { return at(t); }, 32, 160);
}

Blade::Camber Blade::camber(double x) const {
    const double c = shape_.chord, w = x / c, k = 4 * shape_.camber, s = shape_.skew;
    // f/c = (w - w^2)(k - s + 2 s w)
    const double f = c * (w - w * w) * (k - s + 2 * s * w);
    const double f1 = (1 - 2 * w) * (k - s + 2 * s * w) + 2 * s * (w - w * w);
    const double f2 = (-2 * (k - s + 2 * s * w) + 4 * s * (1 - 2 * w)) / c;
    const double f3 = -12 * s / (c * c);
    const double v = std::sqrt(1 + f1 * f1), v1 = f1 * f2 / v;
    Camber m;
    m.position = {x, f};
    m.e = Vec2(1, f1) / v;
    m.n = left_of(m.e);
    m.speed = v;
    m.speed1 = v1;
    m.curvature = f2 / (v * v * v);
    m.curvature1 = f3 / (v * v * v) - 3 * f2 * v1 / (v * v * v * v);
    return m;
}

End Blade::end_at(bool leading) const {
    const Camber m = camber(leading ? 0 : shape_.chord);
    End end;
    end.nose = m.position;
    end.inward = leading ? m.e : Vec2(-m.e);
    end.along = leading ? shape_.le_along : shape_.te_along;
    end.across = leading ? shape_.le_across : shape_.te_across;
    end.centre = end.nose + end.along * end.inward;
    // The tangent (along sin, across cos) leans by the half wedge angle.
    end.half_angle = std::atan2(end.across, end.along * std::tan(leading ? shape_.le_wedge : shape_.te_wedge));
    return end;
}

Blade::Side Blade::make_side(double sign) const {
    Side side;
    const auto join = [&](const End& end, bool leading, double wedge, double& x, double& h, double& slope) {
        const Vec2 across = leading ? left_of(end.inward) : Vec2(-left_of(end.inward));
        const Vec2 joint = end.centre - end.along * std::cos(end.half_angle) * end.inward +
                           sign * end.across * std::sin(end.half_angle) * across;
        const Vec2 tangent = std::cos(wedge) * end.inward + sign * std::sin(wedge) * across;
        x = joint.x();
        for (int step = 0; step < 60; ++step) {
            const Camber m = camber(x);
            const Vec2 off = joint - m.position;
            x += off.dot(m.e) / (m.speed * (1 - m.curvature * off.dot(m.n)));
        }
        const Camber m = camber(x);
        h = sign * (joint - m.position).dot(m.n);
        slope = sign * m.speed * (1 - sign * m.curvature * h) * tangent.dot(m.n) / tangent.dot(m.e);
    };
    double s0 = 0.0, s1 = 0.0;
    join(le_local_, true, shape_.le_wedge, side.x0, side.h0, s0);
    join(te_local_, false, shape_.te_wedge, side.x1, side.h1, s1);
    side.d0 = s0 * (side.x1 - side.x0);
    side.d1 = s1 * (side.x1 - side.x0);
    const double middle = 0.5 * (side.h0 + side.h1) + (side.d0 - side.d1) / 8;
    side.bump = 16 * (0.5 * shape_.thickness - middle);
    side.forward = shape_.forward;
    return side;
}

OutlineJet Blade::on_side(const Side& side, double sign, double w) const {
    const double width = side.x1 - side.x0;
    const auto [h, hw, hww] = half_thickness(side.h0, side.h1, side.d0, side.d1, side.bump, side.forward, w);
    const double h1 = hw / width, h2 = hww / (width * width);
    const Camber m = camber(side.x0 + width * w);
    // n' = -curvature speed e, e' = curvature speed n
    const double p = m.speed * (1 - sign * m.curvature * h), q = sign * h1;
    const double p1 = m.speed1 * (1 - sign * m.curvature * h) - sign * m.speed * (m.curvature1 * h + m.curvature * h1);
    const double turn = m.curvature * m.speed;
    return {m.position + sign * h * m.n, width * (p * m.e + q * m.n),
            width * width * ((p1 - q * turn) * m.e + (sign * h2 + p * turn) * m.n)};
}

OutlineJet Blade::on_end(const End& end, double angle, double rate) {
    const Vec2 across = left_of(end.inward);
    const double c = std::cos(angle), s = std::sin(angle);
    return {end.centre - end.along * c * end.inward + end.across * s * across,
            rate * (end.along * s * end.inward + end.across * c * across),
            rate * rate * (end.along * c * end.inward - end.across * s * across)};
}

OutlineJet Blade::placed(const OutlineJet& jet) const {
    return {turned(jet.position, shape_.stagger) + shape_.shift, turned(jet.d1, shape_.stagger),
            turned(jet.d2, shape_.stagger)};
}

Part Blade::part_of(double t) {
    return static_cast<Part>(static_cast<int>(std::floor(t)) & 3);
}

OutlineJet Blade::at(double t) const {
    const double w = t - std::floor(t);
    const auto end = [&](const End& e) { return on_end(e, e.half_angle * (1 - 2 * w), -2 * e.half_angle); };
    switch (part_of(t)) {
        case Part::le:
            return placed(end(le_local_));
        case Part::pressure:
            return placed(on_side(pressure_, -1, w));
        case Part::te:
            return placed(end(te_local_));
        case Part::suction: {
            OutlineJet back = on_side(suction_, 1, 1 - w);
            back.d1 = -back.d1;
            return placed(back);
        }
    }
    return {};
}

Foot Blade::closest(const Vec2& p) const {
    return closest_on_outline([this](double t) { return at(t); }, samples_, p);
}

Vec2 Blade::ball_centre(double t, double ball_mm) const {
    const OutlineJet jet = at(t);
    return jet.position + ball_mm * jet.normal();
}

double Blade::length_of(Part part, double ball_mm) const {
    // Composite Simpson over 2000 intervals: the integrand is smooth within a part.
    const int steps = 2000;
    double sum = 0;
    for (int k = 0; k <= steps; ++k) {
        const double t = std::min(double(part) + double(k) / steps, double(part) + 1 - 1e-15);
        const OutlineJet jet = at(t);
        sum += jet.d1.norm() * (1 + ball_mm * jet.curvature()) * (k == 0 || k == steps ? 1 : (k % 2 ? 4 : 2));
    }
    return sum / (3 * steps);
}

std::vector<double> Blade::even_parameters(Part part, double ball_mm, const std::vector<double>& shares) const {
    const int steps = 2000;
    const auto speed = [&](double w) {
        const OutlineJet jet = at(std::min(double(part) + w, double(part) + 1 - 1e-15));
        return jet.d1.norm() * (1 + ball_mm * jet.curvature());
    };
    std::vector<double> s(steps + 1, 0.0);
    for (int k = 0; k < steps; ++k) {
        const double a = double(k) / steps, d = 1.0 / steps;
        s[k + 1] = s[k] + d / 6 * (speed(a) + 4 * speed(a + d / 2) + speed(a + d));
    }
    std::vector<double> t;
    for (const double share : shares) {
        const double wanted = share * s.back();
        const auto above = std::upper_bound(s.begin() + 1, s.end() - 1, wanted) - s.begin();
        const double inside = (wanted - s[above - 1]) / (s[above] - s[above - 1]);
        t.push_back(double(part) + (double(above - 1) + inside) / steps);
    }
    return t;
}

Blade make(Family family, std::uint64_t seed) {
    core::Rng rng = core::Rng::keyed(seed, 0xB1ADE, static_cast<std::uint64_t>(family));
    Shape s;
    const auto wedges = [&](double le, double te) {
        s.le_wedge = std::atan(le * 0.5 * s.thickness / s.chord);
        s.te_wedge = std::atan(te * 0.5 * s.thickness / s.chord);
    };
    switch (family) {
        case Family::compressor: {
            s.chord = rng.uniform(30, 65);
            s.camber = std::tan(rng.uniform(15, 40) * 0.5 * degree) / 4;
            s.skew = rng.uniform(-0.06, 0.06);
            s.thickness = s.chord * rng.uniform(0.05, 0.09);
            s.le_across = rng.uniform(0.18, 0.45);
            s.le_along = s.le_across * rng.uniform(1.5, 3.0);
            s.te_across = rng.uniform(0.15, 0.30);
            s.te_along = s.te_across * (rng.uniform() < 0.5 ? 1.0 : rng.uniform(1.2, 2.0));
            s.forward = rng.uniform(-0.1, 0.4);
            wedges(rng.uniform(1.5, 2.6), rng.uniform(1.2, 2.0));
            break;
        }
        case Family::turbine: {
            s.chord = rng.uniform(30, 60);
            s.camber = std::tan(rng.uniform(90, 110) * 0.5 * degree) / 4;
            s.skew = rng.uniform(-0.12, 0.05);
            s.thickness = s.chord * rng.uniform(0.14, 0.20);
            s.le_across = s.le_along = s.chord * rng.uniform(0.030, 0.050);
            s.te_across = s.te_along = rng.uniform(0.30, 0.60);
            s.forward = rng.uniform(0.2, 0.7);
            wedges(rng.uniform(1.8, 2.8), rng.uniform(1.0, 1.6));
            break;
        }
        case Family::fan: {
            s.chord = rng.uniform(100, 200);
            s.camber = std::tan(rng.uniform(6, 25) * 0.5 * degree) / 4;
            s.skew = rng.uniform(-0.04, 0.04);
            s.thickness = s.chord * rng.uniform(0.025, 0.045);
            s.le_across = rng.uniform(0.25, 0.50);
            s.le_along = s.le_across * rng.uniform(1.5, 3.0);
            s.te_across = rng.uniform(0.20, 0.40);
            s.te_along = s.te_across * rng.uniform(1.0, 2.5);
            s.forward = rng.uniform(-0.4, 0.2);
            wedges(rng.uniform(1.2, 2.2), rng.uniform(1.2, 2.2));
            break;
        }
    }
    s.stagger = rng.uniform(-180, 180) * degree;
    s.shift = {rng.uniform(-50, 50), rng.uniform(-50, 50)};
    return {s, to_string(family) + "-" + std::to_string(seed)};
}

}  // namespace cmm::fitting::families
