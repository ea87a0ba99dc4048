// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>

#include "fitting/edge_kind.hpp"
#include "fitting/edge_model.hpp"

namespace cmm::fitting {

/// What kind of end an edge is, and the sizes that say so.
struct FormFinding {
    EdgeForm form = EdgeForm::round;
    double flat_mm = 0.0;           ///< length of the flat between the corners
    double corner_radius_mm = 0.0;  ///< mean radius of the part outside the flat
    double gap_rad = 0.0;           ///< largest turn between two neighbouring points
    std::string text() const;       ///< for the user; empty when round
};

/// Recognises ends that no round model fits, from the points [begin, end) of an edge zone: *partial* when two
/// neighbouring points are turned by more than 30 degrees against each other (a part of the edge was not measured),
/// *square* when a flat that turns by at most 12 degrees lies between two corners of 40 degrees or more and is at least
/// four times as long as the corners' mean radius, *blunt* when it is at least as long as that radius.
FormFinding recognise_form(const EdgePoints& edge, std::size_t begin, std::size_t end);

}  // namespace cmm::fitting
