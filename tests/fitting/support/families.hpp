// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

/// Prismatic blades of three families with exact truth, and scans of them. Formulas of their own: nothing of
/// cmm::fitting. A blade is a polynomial camber line y = f(x), ends that are exact (semi-)ellipses or circles about the
/// camber's end tangent, and sides m(x) +- h(x) n(x) that continue the ends with the same tangent; the curvature jumps
/// there, as on drawings. Millimetres.
namespace cmm::fitting::families {

using Vec2 = Eigen::Vector2d;

enum class Family : std::uint8_t { compressor, turbine, fan };
constexpr std::array<Family, 3> all_families{Family::compressor, Family::turbine, Family::fan};
std::string to_string(Family family);

/// Parts of the outline in counter-clockwise order.
enum class Part : std::uint8_t { le, pressure, te, suction };

/// One end: nose on the camber line, semi-axes along and across the camber's end tangent (equal: a circle).
struct End {
    Vec2 nose = Vec2::Zero(), centre = Vec2::Zero();
    Vec2 inward = Vec2::UnitX();  ///< unit, from the nose along the camber line
    double along = 0.0, across = 0.0;
    double half_angle = 0.0;  ///< eccentric angle from the nose to where the sides begin
    double nose_radius() const { return across * across / along; }
};

/// What a blade is made from; `make` draws it from a seed.
struct Shape {
    double chord = 40.0, camber = 0.1, skew = 0.0;  ///< f = chord w (1 - w)(4 camber + skew (2 w - 1)), w = x/chord
    double thickness = 3.0, forward = 0.0;          ///< largest thickness, and where it lies: > 0 nearer to the LE
    double le_along = 0.6, le_across = 0.3, te_along = 0.25, te_across = 0.25;
    double le_wedge = 0.1, te_wedge = 0.08;  ///< half wedge angles, rad
    double stagger = 0.0;                    ///< rotation of the whole, rad
    Vec2 shift = Vec2::Zero();
};

/// Position on the outline with derivatives by the parameter.
struct OutlineJet {
    Vec2 position, d1, d2;
    Vec2 normal() const { return Vec2(d1.y(), -d1.x()).normalized(); }  ///< outward
    double curvature() const;                                           ///< 1/mm, positive where convex
};

struct Foot {
    double t = 0.0;
    double distance = 0.0;  ///< signed, positive outside
};

/// A closed counter-clockwise outline; parameter t in [0, 4), its whole part is the Part. Immutable, any thread.
class Blade {
  public:
    Blade(const Shape& shape, std::string name);

    OutlineJet at(double t) const;
    static Part part_of(double t);
    /// Foot point by Newton's method to 1e-13 of the parameter; for points nearer than the concave radius.
    Foot closest(const Vec2& p) const;
    double distance(const Vec2& p) const { return closest(p).distance; }
    /// Centre of the ball that touches at t: the exact parallel curve; regular while concave radii exceed the ball.
    Vec2 ball_centre(double t, double ball_mm) const;
    /// Length of the ball centres' curve along one part, and the parameter at a share of it (to 1e-9).
    double length_of(Part part, double ball_mm) const;
    std::vector<double> even_parameters(Part part, double ball_mm, const std::vector<double>& shares) const;

    const std::string& name() const { return name_; }
    const Shape& shape() const { return shape_; }
    const End& le() const { return le_; }
    const End& te() const { return te_; }

  private:
    struct Camber {
        Vec2 position, e, n;  // e along, n to the left
        double speed = 0.0, speed1 = 0.0, curvature = 0.0, curvature1 = 0.0;
    };
    struct Side {
        double x0 = 0.0, x1 = 0.0;         // camber stations of its ends
        double h0 = 0.0, h1 = 0.0;         // half thickness there
        double d0 = 0.0, d1 = 0.0;         // its slope by w
        double bump = 0.0, forward = 0.0;  // bump w^2 (1-w)^2 (1 + forward (1 - 2 w))
    };

    Camber camber(double x) const;
    End end_at(bool leading) const;
    Side make_side(double sign) const;
    OutlineJet on_side(const Side& side, double sign, double w) const;
    static OutlineJet on_end(const End& end, double angle, double rate);
    OutlineJet placed(const OutlineJet& jet) const;

    Shape shape_;
    std::string name_;
    End le_, te_;  // in the blade's own frame until the constructor has placed them
    End le_local_, te_local_;
    Side pressure_, suction_;
    std::array<std::vector<Vec2>, 4> samples_;  // of each part, for the start of `closest`
};

/// A blade of a family: sizes and angles drawn within the family's range.
Blade make(Family family, std::uint64_t seed);

struct ScanOptions {
    double ball_mm = 1.0;
    std::vector<double> places = {};  ///< parameters on the outline to measure at, in order; instead of what follows
    std::size_t points = 600;
    double edge_share = 0.12;    ///< of the points, on each end
    double side_pitch_mm = 0.0;  ///< with edge_pitch_mm: spacing of the ball centres instead of counts
    double edge_pitch_mm = 0.0;
    double jitter = 0.1;     ///< of the spacing, uniform to either side
    double sigma_mm = 1e-3;  ///< along the normal
    double bad_share = 0.015;
    std::size_t shortest_run = 1, longest_run = 3;  ///< of adjacent bad points
    double bad_low_mm = 0.020, bad_high_mm = 0.400;
    double bad_at_edges = 0.8;      ///< share of the runs that begin on an end or within 8 points of it
    double outward = 0.8;           ///< share of the runs that lie outside
    std::size_t least_between = 2;  ///< good points between two runs
    std::size_t dirt = 0;           ///< smooth bumps of 5-10 points, 20-60 um high
    double overlap = 0.0;           ///< share of the points that are measured again past the start
    bool clockwise = false;
    std::uint64_t seed = 1;  ///< noise, bad points and where the scan begins
};

struct BladeScan {
    std::vector<Vec2> points;  ///< ball centres in measuring order
    std::vector<double> t;     ///< parameter of the touched outline point
    std::vector<double> bad;   ///< displacement of a bad point along the normal, 0 of a good one
    std::vector<double> dirt;  ///< height of the dirt under the point
};
BladeScan scan(const Blade& blade, const ScanOptions& options);

}  // namespace cmm::fitting::families
