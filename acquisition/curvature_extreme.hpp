// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "acquisition/characteristic_spec.hpp"
#include "acquisition/decision_rule.hpp"
#include "acquisition/section_result.hpp"
#include "fitting/best_fit.hpp"
#include "fitting/measured_section.hpp"
#include "fitting/nominal.hpp"

namespace cmm::acquisition {

/// The nominal beside a measured section: as a section (section_of_nominal), and how the measured one lies to it.
struct CurvatureNominal {
    const fitting::NominalSection& curve;
    const fitting::ContourGeometry& contour;
    const fitting::PlaneMotion& motion;
};

/// Least or greatest curvature of a zone, or its largest deviation from that of the nominal, over windows of
/// spec.window_mm that lie within the zone, with where it is. The zone is that of the nominal, carried over by the best
/// fit; without a nominal (nullptr) that of the contour. The extreme of many uncertain values: its U95 holds the
/// extreme of the true ones, guards are those of the rule, set where the limits of `spec` need them. Without limits of
/// its own.
Characteristic curvature_extreme(const CharacteristicSpec& spec, const fitting::MeasuredSection& section,
                                 const CurvatureNominal* nominal, const DecisionRule& rule);

/// The same number of a nominal itself. Errors: fit_not_evaluable (the zone is shorter than the window).
core::Result<double> curvature_of_nominal(const CharacteristicSpec& spec, const fitting::NominalSection& curve,
                                          const fitting::ContourGeometry& contour);

}  // namespace cmm::acquisition
