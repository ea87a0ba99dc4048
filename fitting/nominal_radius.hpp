// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/error.hpp"
#include "fitting/nominal.hpp"
#include "fitting/section.hpp"
#include "fitting/thickness_measures.hpp"

namespace cmm::fitting {

/// The radius of an edge of the nominal, mm, found as that of the part was: by the form that the points of the part
/// supported, or the mean circle where they supported none, through exact points of the nominal about its nose, by
/// equal steps of the ball's centre, over the same turn (of the mean circle: as much of it, in the middle of the edge
/// zone). An edge that has the form has the same radius over any stretch; elsewhere the radius is one of form and
/// stretch, and only what was found alike can be compared. Errors: fit_not_evaluable
/// (the part's edge has no radius, the nominal's edge does not turn so far, no such form goes through it).
core::Result<double> nominal_radius(const NominalSection& nominal, EdgeName edge, const SectionFit& fit);

/// The chord RADCENTER of the nominal, mm, by the circles of these radii. Errors: likewise.
core::Result<double> nominal_rad_center(const NominalSection& nominal, const SectionFit& fit);

}  // namespace cmm::fitting
