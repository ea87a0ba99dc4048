// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/error.hpp"
#include "fitting/contour_noise.hpp"
#include "fitting/edge_kind.hpp"
#include "fitting/smoothing.hpp"

/// One section of a blade from ball centres in a plane z = const (seed 000, A1-A26; docs/theory.md).
/// Pure functions: no I/O, no threads, no clock. Millimetres, part frame, plane coordinates x and y.
namespace cmm::fitting {

class ClosedCurve;
struct OpenEdges;

enum class Zone : std::uint8_t { le, suction, te, pressure };
std::string_view to_string(Zone zone) noexcept;

enum class RejectReason : std::uint8_t { none, spline_residual, fit_residual, no_contact, duplicate, by_operator };
std::string_view to_string(RejectReason reason) noexcept;

struct SectionOptions {
    double ball_radius_mm = 1.0;        ///< 0: the points lie on the part
    std::size_t contour_points = 2400;  ///< that were measured; at least 2000 in the files of the contract
    double reject_floor_mm = 0.002;     ///< never reject below this residual; the noise asks for more from 0.4 um on
    double gap_factor = 8.0;            ///< a gap when the next point is this many local point spacings away
    std::optional<Eigen::Vector2d>
        le_hint;  ///< a point near the LE (from the nominal); otherwise the larger edge radius is LE
    std::optional<Eigen::Vector2d> te_hint;
    const ClosedCurve* nominal = nullptr;         ///< lends its way where an edge or a side was not measured
    std::optional<EdgeModel> le_model, te_model;  ///< asked for; otherwise the points choose
    double fairing_mm = 0.0;  ///< A20: how far fairing may move the contour; 0: none, as befits a tolerance decision
    /// A22: angle of the surface to the section normal plane where it is known (one per contour is enough for the
    /// bound).
    double lean_rad = 0.0;
};

/// What became of an input point. Nothing is deleted: every input has a verdict.
struct PointVerdict {
    RejectReason reason = RejectReason::none;
    double residual_mm = 0.0;  ///< signed along the outward normal of the ball-centre curve
    bool kept = false;         ///< by an operator: used, whatever the neighbours say
};

/// A number of an edge's model; the unit is in the name.
struct EdgeParameter {
    std::string_view name;
    double value = 0.0;
    double u95 = 0.0;
};

/// What speaks for a model and against it.
struct EdgeEvidence {
    EdgeModel model = EdgeModel::free;
    double rms_mm = 0.0;
    double gain = 0.0;           ///< Bayesian information criterion of the free form less the model's; from 6 on strong
    std::string why;             ///< not empty: the points refuse it
    double arc_radius_mm = 0.0;  ///< of an arc; 0: none came about
};

/// One edge of the part (A10-A14): the model that its points support, by orthogonal distances.
struct EdgeFit {
    bool valid = false;  ///< there is a radius; false: `why` says why not (short arc, too few points, not round)
    std::string why;
    EdgeForm form = EdgeForm::round;
    EdgeModel model = EdgeModel::free;
    std::vector<EdgeParameter> parameters;                ///< of the model
    std::vector<EdgeEvidence> evidence;                   ///< of each model that was tried
    Eigen::Vector2d centre_mm = Eigen::Vector2d::Zero();  ///< of curvature at the nose
    double radius_mm = 0.0;  ///< of the part: of the arc, of curvature at the nose of the others; free: mean circle
    double radius_u95_mm = 0.0;
    /// Of centre x, centre y and radius; mm^2. Zero where there is no radius.
    Eigen::Matrix3d covariance_mm2 = Eigen::Matrix3d::Zero();
    std::array<Sensitivity, 3> slopes;  ///< of the same three, by points of the contour
    double arc_angle_rad = 0.0;         ///< by which the points turn that the model explains
    double rms_mm = 0.0;
    bool used_in_contour = false;  ///< false: the contour's edge is free form
};

struct ContourPoint {
    Eigen::Vector2d position_mm = Eigen::Vector2d::Zero();
    Eigen::Vector2d normal = Eigen::Vector2d::Zero();  ///< unit, out of the material
    Zone zone = Zone::suction;
    double u95_mm = 0.0;  ///< expanded uncertainty (k = 2) from the residual noise, and the next
    /// A22: by how much the 2-D offset makes the part too thick here, as far as the lean of the surface is known.
    double offset_error_mm = 0.0;
    bool reached = true;             ///< false: the ball rests in a hollow here, and the contour shows the ball
    bool measured = true;            ///< false: in a gap of the points, which the contour only bridges
    std::optional<double> lean_rad;  ///< of the surface, upwards; there where the contour was cut from the surface
    double rise = 0.0;               ///< tangent of the surface's lean, as far as anything tells it
    double arc_length_mm = 0.0;      ///< from the contour's first point
    double t = 0.0;                  ///< parameter of the curve of ball centres
    double noise_share = 1.0;  ///< of the noise of the curve of ball centres: the neighbouring sections take some of it
    double scatter_share = 1.0, kept_share = 1.0;  ///< the same, of CurveNoise::Variance's parts
    double bound_mm = 0.0;      ///< part of u95_mm, added: what is not known of the lean, and fairing
    double drawn_mm = 0.0;      ///< of that, with its sign, what is chance: of a number of many points it is not added
    double flattened_mm = 0.0;  ///< beside u95_mm: so much of a narrow form the curve may leave out (`flattened_mm`)
    PlaceErrors machine;        ///< beside u95_mm: by machine, probe and temperature
};

/// The curve of ball centres, free form also at the edges, and the points that it was fitted to, in its order.
struct SectionCentres {
    SmoothCurve curve;
    std::vector<Eigen::Vector2d> points;
};

struct SectionFit {
    std::string missing;  ///< of an edge, or of much of the way round, that was not measured; empty: of neither
    std::vector<PointVerdict> verdicts;  ///< one per input point, in input order
    std::size_t rejected = 0;
    double noise_sigma_mm = 0.0;  ///< estimated standard deviation of the accepted points about the fit
    double faired_mm = 0.0;       ///< by so much fairing moved the contour at most; part of every point's u95
    EdgeFit le, te;               ///< made by `fit_edges`, as far as the contour does not need them
    Eigen::Vector2d le_point_mm = Eigen::Vector2d::Zero();  ///< nose point of the part contour
    Eigen::Vector2d te_point_mm = Eigen::Vector2d::Zero();
    double le_scale_mm = 0.0;  ///< length over turn of the edge's sharpest 120 degrees: the radius of a circular edge
    double te_scale_mm = 0.0;
    ContourNoise contour_noise;         ///< how the errors of the contour's points go together
    double chord_mm = 0.0;              ///< method NOSETAIL: |TE - LE| between the nose points
    std::vector<ContourPoint> contour;  ///< of the part, counter-clockwise seen from +Z; closed (last joins first)
    SectionCentres centres;             ///< as measured, also where the contour comes from the surface
    std::shared_ptr<const OpenEdges> open_edges;  ///< what `fit_edges` has still to do; none: nothing
};

/// Fits a section that goes round the blade, its gaps bridged. `centres` are in measuring order, any start, either
/// direction; `excluded[i]` != none keeps a point out from the beginning (no contact, operator); `kept[i]` != 0 keeps a
/// point in that the search would reject (operator); `later[i]`: the number of the pass after the lap, over
/// stretches of it, its points between those of before; 0: of the lap. All three may be shorter than `centres`, or
/// empty. Errors: fit_not_evaluable (too few points, open and nothing tells the way, self-crossing, no two edges);
/// never throws.
core::Result<SectionFit> fit_section(std::span<const Eigen::Vector2d> centres, std::span<const RejectReason> excluded,
                                     const SectionOptions& options, std::span<const char> kept = {},
                                     std::span<const char> later = {});

/// The same in two steps, the numbers of edges that are not part of the contour (`le`, `te`) by the second one.
core::Result<SectionFit> fit_contour(std::span<const Eigen::Vector2d> centres, std::span<const RejectReason> excluded,
                                     const SectionOptions& options, std::span<const char> kept = {},
                                     std::span<const char> later = {});
void fit_edges(SectionFit& fit);

}  // namespace cmm::fitting
