// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/units.hpp"
#include "sim/parametric.hpp"

/// Parametric blades for tests.
namespace cmm::sim::test {

/// Twist, taper and lean together.
inline BladeNumbers twisted_blade() {
    BladeNumbers n;
    n.chord_root_mm = 40.0;
    n.chord_tip_mm = 32.0;
    n.thickness_root_mm = 4.0;
    n.thickness_tip_mm = 2.4;
    n.camber_rad = core::rad_from_deg(35.0);
    n.stagger_root_rad = core::rad_from_deg(20.0);
    n.stagger_tip_rad = core::rad_from_deg(45.0);
    n.le_radius_mm = 0.6;
    n.te_radius_mm = 0.35;
    n.lean_x_rad = core::rad_from_deg(3.0);
    n.lean_y_rad = core::rad_from_deg(-5.0);
    n.z_tip_mm = 60.0;
    return n;
}

/// The same section at every height, without camber.
inline BladeNumbers straight_blade() {
    BladeNumbers n = twisted_blade();
    n.chord_tip_mm = n.chord_root_mm;
    n.thickness_tip_mm = n.thickness_root_mm;
    n.camber_rad = n.stagger_root_rad = n.stagger_tip_rad = n.lean_x_rad = n.lean_y_rad = 0.0;
    return n;
}

}  // namespace cmm::sim::test
