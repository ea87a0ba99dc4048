// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "fitting/error_fields.hpp"
#include "fitting/join.hpp"
#include "fitting/plane_error.hpp"
#include "fitting/plane_motion.hpp"
#include "fitting/sensitivity.hpp"
#include "fitting/smoothing.hpp"

namespace cmm::fitting {

struct ContourPoint;

/// How a number answers to a random function along a section, by its independent values.
using PlaceLoads = Eigen::Matrix<double, 12, 1>;

/// The uncertainty of a number that was computed from a contour.
struct NumberUncertainty {
    double standard = 0.0;      ///< one standard deviation
    double u95 = 0.0;           ///< half the 95 % interval, bounds included
    double offset_error = 0.0;  ///< part of u95: what the 2-D offset makes of it (A22), whose sign is known
    double scatter = 0.0;       ///< standard, by the points alone, bounds as if they were standard
    double in_gaps = 0.0;       ///< share of what the number rests on that was not measured, 0 to 1
    double place = 0.0;  ///< standard, by what the machine does differently from place to place: in no other section
    FieldLoads loads = FieldLoads::Zero();  ///< how it answers to what all sections have in common
    ErrorBudget budget;
};

/// What a number depends on beside the contour's noise.
struct BesideContour {
    double variance = 0.0;  ///< by what is not in the contour (the radius of an edge's circle)
    Sensitivity
        slopes;  ///< of that: by what errs alike (the fields, the 2-D offset, bounds) only, its noise is `variance`
    FieldLoads loads = FieldLoads::Zero();  ///< by other sections, through an alignment
};

/// The errors of a section's contour as a whole, so that those of neighbouring places go together (docs/theory.md,
/// section 13): of the free form by the posterior covariance of the smoothing spline, at the edges by that of their
/// models' parameters; and by what machine, probe and temperature do alike to many points (section 16). Value type;
/// refers to nothing.
class ContourNoise {
  public:
    /// Nothing is known but the points' own u95.
    ContourNoise() = default;
    /// `period` of the curve's parameter; `coverage` makes a 95 % interval of a standard deviation.
    ContourNoise(CurveNoise free, std::vector<EdgePatch> patches, double period, double coverage);

    double coverage() const { return coverage_; }
    /// The contour was moved since: `motion` leads from where it is to where the noise was found.
    void lies_in(const PlaneMotion& motion) { from_contour_ = motion; }
    /// The plane of the section is not where it should be by this.
    void take(PlaneError plane) { plane_ = std::move(plane); }
    /// Of a number by that alone.
    double plane_variance(const Sensitivity& number) const { return plane_.variance(number); }
    /// Of the frame where the noise was found; without them nothing errs but the points.
    void set_fields(const ErrorFields& fields) { fields_ = fields; }
    bool has_fields() const { return fields_.any(); }
    FieldLoads loads(std::span<const ContourPoint> contour, const Sensitivity& number) const;
    /// Of the contour's own place, and by what differs from place to place, standard.
    FieldLoads loads_at(const ContourPoint& point) const;
    /// Loads on what differs from place to place.
    PlaceLoads place_loads(std::span<const ContourPoint> contour, const Sensitivity& number) const;
    double place_mm(const ContourPoint& point) const;
    /// From the part of the bounds that is chance.
    double drawn_variance(std::span<const ContourPoint> contour, const Sensitivity& number) const;
    double direction_mm() const { return fields_.direction_mm(); }
    /// From the noise of the points alone, in the square of the number's unit. Where nothing is known, the points' own
    /// u95 fully correlated, which is never too small.
    double variance(std::span<const ContourPoint> contour, const Sensitivity& number) const;
    /// Of the displacements of several points along their normals, from the noise of the points alone, mm^2; what
    /// neighbouring sections took of it as a share of each. O(places x controls).
    Eigen::MatrixXd covariance(std::span<const ContourPoint> contour, std::span<const std::size_t> places) const;
    /// With the error of the plane and with the bounds, which are added; and with the fields of errors.
    NumberUncertainty of(std::span<const ContourPoint> contour, const Sensitivity& number,
                         const BesideContour& beside = {}) const;

  private:
    /// Of a point's displacement: on the model of an edge and its parameters, and on the free form.
    struct PlaceDependence {
        double on_free = 1.0;
        std::size_t patch = 0;
        Eigen::VectorXd on_model;  ///< empty: not on the patch
    };
    PlaceDependence dependence_of(const ContourPoint& point) const;
    void add_fields(std::span<const ContourPoint> contour, const Sensitivity& number, const FieldLoads& of_others,
                    NumberUncertainty& out) const;

    std::optional<CurveNoise> free_;
    std::vector<EdgePatch> patches_;
    double period_ = 0.0, coverage_ = 2.0;
    PlaneMotion from_contour_;
    PlaneError plane_;
    ErrorFields fields_;
};

}  // namespace cmm::fitting
