// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

/// Sections whose shape is known exactly, and scans of them. Written from formulas of its own: nothing of cmm::fitting.
namespace cmm::fitting::truth {

using Vec2 = Eigen::Vector2d;

/// A closed counter-clockwise outline as a dense polygon (steps of some micrometres) with outward unit normals.
struct Outline {
    std::string name;
    std::vector<Vec2> points, normals;

    /// Signed distance, positive outside; exact for the polygon.
    double distance(const Vec2& p) const;
    double perimeter() const;
};

struct EnvelopeBlade {
    double chord = 40, thickness = 4, camber_deg = 30, stagger_deg = 25, le_radius = 0.6, te_radius = 0.3;
};
/// docs/part-file.md, "The parametric blade", at the root.
Outline envelope_blade(const EnvelopeBlade& blade);
/// A circular-arc camber line with semi-elliptic ends (half axes a along, b across) and a quintic between.
Outline ellipse_edged_blade(double chord, double camber_deg, double le_a, double le_b, double te_a, double te_b,
                            double thickness);
/// NACA four-digit thickness with a rounded trailing edge on a parabolic-arc camber (m, p = 0.4).
Outline naca_blade(double chord, double thickness_share, double camber_share);
/// A periodic spline of its own through points (any direction).
Outline spline_outline(const std::vector<Vec2>& points, const std::string& name);
/// A polygon as it is, e.g. the cut of a mesh: normals of its facets.
Outline polygon_outline(const std::vector<Vec2>& points, const std::string& name);

/// Profiles of ../shared/data; empty when the folder is absent. Projected along the span, so plane curves of real
/// shape.
std::vector<Outline> hannover_outlines();
std::vector<Outline> rotor37_outlines();
std::vector<Outline> engine_outlines();
/// The raw profile points of hannover rotor 1 (sparse at the edges).
std::vector<std::vector<Vec2>> hannover_profiles();

/// The curve of ball centres: the outer parallel curve, cut where the ball does not reach.
Outline ball_centres(const Outline& part, double ball_radius);

struct ScanOptions {
    double pitch = 0.4, edge_density = 4.0;
    double step_rad = 0.08;  ///< the pitch shrinks to this turn a step, at most by edge_density
    double grading = 0.25;   ///< change of the pitch per mm travelled; large: the pitch may jump
    double noise = 0.001;
    double bad_share = 0.01;
    double bad_low = 0.020, bad_high = 0.400;
    double start_share = 0.0;  ///< of the perimeter
    double overlap_mm = 0.0;   ///< past the start; negative leaves a gap
    bool clockwise = false;
    std::uint64_t seed = 1;
};

struct Scan {
    std::vector<Vec2> points;
    std::vector<double> bad;  ///< displacement of a bad point, 0 of a good one
};
Scan scan(const Outline& centres, const ScanOptions& options);

}  // namespace cmm::fitting::truth
