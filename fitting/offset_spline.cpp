// SPDX-License-Identifier: Apache-2.0
#include "fitting/offset_spline.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "fitting/trimming.hpp"

namespace cmm::fitting {
namespace {

using Piece = PiecewiseCubic::Piece;

constexpr std::size_t most_parts = 4096;

/// A cubic piece of the source on [0, width], its ends' unit normals and their derivatives by the parameter.
struct Frame {
    Piece source;
    Vec2 normal[2], slope[2];
    double width = 0.0;
};

/// The cubic on [0, width] with the given ends (Hermite).
Piece cubic_between(const Frame& f) {
    const double h = f.width;
    const Vec2 chord = (f.normal[1] - f.normal[0]) / h;
    return {f.normal[0], f.slope[0], (3.0 * chord - 2.0 * f.slope[0] - f.slope[1]) / h,
            (f.slope[0] + f.slope[1] - 2.0 * chord) / (h * h)};
}

double largest_of_quadratic(double q0, double q1, double q2) {
    double largest = std::max(std::abs(q0), std::abs(q0 + q1 + q2));
    if (const double top = -0.5 * q1 / q2; top > 0.0 && top < 1.0)
        largest = std::max(largest, std::abs(q0 + top * (q1 + top * q2)));
    return largest;
}

/// max |d N - d n| along n, and what the small part of N along the curve can add to it.
double error_bound(const Frame& f, const Piece& normal, double distance) {
    constexpr double peak = 1.0 / 16.0;  // of u^2 (1-u)^2
    const double h = f.width, r = std::abs(distance);
    const Vec2 n1 = h * normal[1], n2 = h * h * normal[2], n3 = h * h * h * normal[3];
    const double q2 = n3.squaredNorm(), q1 = 2.0 * n2.dot(n3) + 2.0 * q2;
    const double q0 = n2.squaredNorm() + 2.0 * n1.dot(n3) + 2.0 * q1 - q2;
    const double longer = peak * largest_of_quadratic(q0, q1, q2);
    if (longer >= 0.5) return r;
    const double across = r * longer / (1.0 + std::sqrt(1.0 - longer));

    const Vec2 c1 = f.source[1], c2 = 2.0 * h * f.source[2], c3 = 3.0 * h * h * f.source[3];
    const double l1 = n3.dot(c3), l0 = n2.dot(c3) + n3.dot(c2) + 2.0 * l1;
    const double leaning = r * peak * std::max(std::abs(l0), std::abs(l0 + l1));
    const Vec2 middle = c1 + 0.5 * c2, end = c1 + c2 + c3, along = (c1 + end).normalized();
    const double slow = std::min({c1.dot(along), middle.dot(along), end.dot(along)});
    if (leaning <= 1e-12 * slow) return across;
    if (!(slow > 0.0)) return r;
    // N moves the point by `shift` along the exact curve, from which that bends away by shift^2/2 times its curvature.
    const double shift = leaning / slow;
    const double bend =
        std::max({std::abs(cross(c1, middle)), 0.5 * std::abs(cross(c1, end)), std::abs(cross(middle, end))}) * 2.0 /
        (h * slow * slow * slow);
    const double regular = 1.0 - r * bend;
    const double away = regular > 0.0 ? std::min(shift, shift * shift * bend / regular) : shift;
    return across + away + shift * shift / r;
}

class Builder {
  public:
    Builder(const ParallelCurve& curve, double tolerance) : curve_(curve), tolerance_(std::max(tolerance, 1e-9)) {
        pieces_.reserve(3 * curve.stretches().size());
        breaks_.reserve(3 * curve.stretches().size() + 1);
        breaks_.push_back(0.0);
    }

    void append(const StretchPart& part) {
        const double width = part.to - part.from;
        if (!(std::abs(width) > 0.0)) return;
        // The error falls with the fourth power of the width.
        const double whole = add(part, 1);
        if (whole <= tolerance_) return;
        const double guess = std::min(std::pow(whole / tolerance_, 0.25), static_cast<double>(most_parts));
        for (auto parts = static_cast<std::size_t>(std::ceil(guess));; parts += 1 + parts / 4)
            if (parts = std::max<std::size_t>(parts, 2); add(part, parts) <= tolerance_ || parts >= most_parts) return;
    }

    OffsetSpline take() && {
        if (pieces_.empty()) return {};
        return {{std::move(breaks_), std::move(pieces_), true}, error_};
    }

  private:
    /// Appends the part in even pieces when the largest error bound, which is returned, is within the tolerance.
    double add(const StretchPart& part, std::size_t parts) {
        const std::size_t before = pieces_.size();
        const double distance = curve_.distance(), step = (part.to - part.from) / static_cast<double>(parts);
        double worst = 0.0;
        Frame f;
        set_end(f, 0, part.stretch, part.from);
        for (std::size_t i = 1; i <= parts; ++i) {
            const double begin = part.from + step * static_cast<double>(i - 1);
            set_source(f, part.stretch, begin, step);
            set_end(f, 1, part.stretch, i < parts ? begin + step : part.to);
            const Piece normal = cubic_between(f);
            worst = std::max(worst, error_bound(f, normal, distance));
            if (worst > tolerance_ && parts < most_parts) {
                pieces_.resize(before);
                breaks_.resize(before + 1);
                return worst;
            }
            Piece piece = f.source;
            for (std::size_t k = 0; k < piece.size(); ++k)
                piece[k] += distance * normal[k];
            pieces_.push_back(piece);
            breaks_.push_back(breaks_.back() + f.width);
            f.normal[0] = f.normal[1];
            f.slope[0] = f.slope[1];
        }
        error_ = std::max(error_, worst);
        return worst;
    }

    /// About a corner the source stands still and the normal turns; the parameter is then the length of the arc.
    void set_source(Frame& f, std::size_t stretch, double from, double step) const {
        const Stretch& s = curve_.stretches()[stretch];
        const Piece& piece = curve_.source().pieces()[s.span];
        if (s.about_corner) {
            f.source = {piece[0], Vec2::Zero(), Vec2::Zero(), Vec2::Zero()};
            f.width = std::abs(curve_.distance() * step);
            return;
        }
        const double u = from - curve_.source().breaks()[s.span];
        f.source = {piece[0] + u * (piece[1] + u * (piece[2] + u * piece[3])),
                    piece[1] + u * (2.0 * piece[2] + 3.0 * u * piece[3]), piece[2] + 3.0 * u * piece[3], piece[3]};
        f.width = step;
    }

    void set_end(Frame& f, std::size_t end, std::size_t stretch, double x) const {
        const Stretch& s = curve_.stretches()[stretch];
        if (s.about_corner) {
            const double sense = s.to > s.from ? 1.0 : -1.0;
            f.normal[end] = {std::cos(x), std::sin(x)};
            f.slope[end] = sense / std::abs(curve_.distance()) * Vec2(-std::sin(x), std::cos(x));
            return;
        }
        const Jet jet = curve_.source().jet_in(s.span, x);
        const double inverse = 1.0 / jet.speed();
        f.normal[end] = inverse * right_normal(jet.d1);
        f.slope[end] = cross(jet.d1, jet.d2) * inverse * inverse * inverse * jet.d1;
    }

    const ParallelCurve& curve_;
    double tolerance_;
    double error_ = 0.0;
    std::vector<double> breaks_;
    std::vector<Piece> pieces_;
};

}  // namespace

OffsetSpline offset_spline(const PiecewiseCubic& source, double distance_mm, double tolerance_mm) {
    const ParallelCurve curve(source, distance_mm);
    Builder builder(curve, tolerance_mm);
    for (const Branch& branch : largest_loop(curve).branches)
        for (const StretchPart& part : branch)
            builder.append(part);
    return std::move(builder).take();
}

}  // namespace cmm::fitting
