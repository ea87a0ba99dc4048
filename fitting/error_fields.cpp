// SPDX-License-Identifier: Apache-2.0
#include "fitting/error_fields.hpp"

#include <cmath>

namespace cmm::fitting {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

// In this order. A figure of the ball's form holds harmonics from the second on, as its size and its place are those of
// the fitted ball; a length errs by those up to the third as well, the constant one being the ball's size.
constexpr Index ball_field = 0, form_first = 1, form_low = 2, form_high = 4;
constexpr Index constant_first = 7, constant_high = 3, scale_first = 14, shear_first = 17, expansion_field = 20;

constexpr double harmonics_of_form = 3.0;

/// The standard uncertainty of a length with opposite normals at its ends is what is asked for, half of its variance
/// from the direction of the normals and half from the places: c^2 = 4 (c/4)^2 (1 + 1) + 2 (c/2)^2.
constexpr double direction_share = 0.25, place_share = 0.5;

const double shear_share = std::sqrt(0.5);  // then a length has the same uncertainty in any direction

ErrorSource source_of(Index field) {
    if (field == ball_field) return ErrorSource::ball;
    if (field < constant_first) return ErrorSource::probing;
    return field < expansion_field ? ErrorSource::length : ErrorSource::temperature;
}

double root_of_squares(const std::array<double, error_sources>& parts) {
    double sum = 0.0;
    for (const double part : parts)
        sum += part * part;
    return std::sqrt(sum);
}

/// Cosine and sine of m times the direction of `heading`, times its length to the power m.
void add_harmonics(const Vec2& heading, Index low, Index high, double amplitude, Index first, FieldLoads& out) {
    double c = 1.0, s = 0.0;
    for (Index m = 1; m <= high; ++m) {
        const double next = c * heading.x() - s * heading.y();
        s = s * heading.x() + c * heading.y();
        c = next;
        if (m < low) continue;
        out[first++] = amplitude * c;
        out[first++] = amplitude * s;
    }
}

/// The displacement of a surface at a place: `facing` is its normal times `stretch`, `heading` its direction in x and
/// y.
FieldLoads displacements(const SystematicErrors& e, const Vector3d& at, const Vector3d& facing, const Vec2& heading,
                         double stretch) {
    FieldLoads out = FieldLoads::Zero();
    out[ball_field] = e.ball_mm * stretch;
    add_harmonics(heading, form_low, form_high, e.form_mm / std::sqrt(harmonics_of_form) * stretch, form_first, out);
    const double amplitude = direction_share * e.constant_mm * stretch;
    out[constant_first] = amplitude;
    add_harmonics(heading, 1, constant_high, amplitude, constant_first + 1, out);
    const Vector3d arm = at - e.fixed_at_mm;
    for (Index axis = 0; axis < 3; ++axis) {
        out[scale_first + axis] = e.per_mm * arm[axis] * facing[axis];
        const Index next = (axis + 1) % 3;
        out[shear_first + axis] = shear_share * e.per_mm * (arm[axis] * facing[next] + arm[next] * facing[axis]);
    }
    out[expansion_field] = e.expansion * arm.dot(facing);
    out[error_fields - 1] = e.known_expansion * arm.dot(facing);
    return out;
}

}  // namespace

bool SystematicErrors::any() const {
    return ball_mm > 0.0 || form_mm > 0.0 || constant_mm > 0.0 || per_mm > 0.0 || expansion > 0.0 ||
           known_expansion != 0.0;
}

double variance_of(const FieldLoads& loads, ErrorSource source) {
    double sum = 0.0;
    for (Index k = 0; k + 1 < error_fields; ++k)
        if (source_of(k) == source) sum += loads[k] * loads[k];
    return sum;
}

double variance_of(const FieldLoads& loads) {
    return loads.head<error_fields - 1>().squaredNorm();
}

double ErrorBudget::shared() const {
    return root_of_squares(machine);
}

double PlaceErrors::shared_mm() const {
    return root_of_squares(standard_mm);
}

ErrorBudget ErrorBudget::times(double factor) const {
    ErrorBudget out = *this;
    out.noise *= factor;
    for (double& part : out.machine)
        part *= factor;
    out.bound *= factor;
    return out;
}

FieldLoads ErrorFields::at(const Vec2& position_mm, const Vec2& normal, double rise) const {
    const Vector3d place(position_mm.x(), position_mm.y(), z_mm_), facing(normal.x(), normal.y(), rise);
    FieldLoads out = displacements(errors_, place, facing, normal, std::hypot(1.0, rise));
    out -= frame_.topRows<3>().transpose() * facing;
    out -= frame_.bottomRows<3>().transpose() * (place - about_mm_).cross(facing);
    return out;
}

double ErrorFields::place_mm(double rise) const {
    return place_share * errors_.constant_mm * std::hypot(1.0, rise);
}

double ErrorFields::direction_mm() const {
    return std::hypot(errors_.form_mm,
                      std::sqrt(static_cast<double>(constant_high)) * direction_share * errors_.constant_mm);
}

void ErrorFields::lie_in_frame_of(const SixPoints& points) {
    about_mm_ = hold_of(points).middle_mm;
    const auto touches = touches_of(points);
    Eigen::Matrix<double, Eigen::Dynamic, error_fields> off(static_cast<Index>(touches.size()), error_fields);
    for (std::size_t i = 0; i < touches.size(); ++i) {
        const DatumTouch& touch = touches[i];
        off.row(static_cast<Index>(i)) =
            displacements(errors_, touch.place_mm, touch.normal, touch.normal.head<2>(), 1.0).transpose();
    }
    frame_ = motion_by_touches(points) * off;
}

Matrix6 ErrorFields::covariance_of_touches(const SystematicErrors& errors, const SixPoints& points) {
    const auto touches = touches_of(points);
    Eigen::VectorXd own(static_cast<Index>(touches.size()));
    for (std::size_t i = 0; i < touches.size(); ++i) {
        // A touch from above has no direction in x and y: it errs there by itself.
        const double level = touches[i].normal.head<2>().norm();
        double variance = std::pow(place_share * errors.constant_mm, 2);
        for (Index m = 1; m <= form_high; ++m) {
            const double missing = 1.0 - std::pow(level, 2.0 * static_cast<double>(m));
            if (m >= form_low) variance += errors.form_mm * errors.form_mm / harmonics_of_form * missing;
            if (m <= constant_high) variance += std::pow(direction_share * errors.constant_mm, 2) * missing;
        }
        own[static_cast<Index>(i)] = variance;
    }
    const auto motion = motion_by_touches(points);
    return motion * own.asDiagonal() * motion.transpose();
}

}  // namespace cmm::fitting
