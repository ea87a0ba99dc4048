// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "core/error.hpp"
#include "sim/patch.hpp"
#include "sim/warp.hpp"

namespace cmm::sim {

/// The numbers of the parametric blade (docs/part-file.md, "The parametric blade"). Millimetres and radians.
struct BladeNumbers {
    double chord_root_mm = 0.0, chord_tip_mm = 0.0;
    double thickness_root_mm = 0.0, thickness_tip_mm = 0.0;
    double camber_rad = 0.0;
    double stagger_root_rad = 0.0, stagger_tip_rad = 0.0;
    double le_radius_mm = 0.0, te_radius_mm = 0.0;
    double lean_x_rad = 0.0, lean_y_rad = 0.0;
    double z_root_mm = 0.0, z_tip_mm = 0.0;
};

/// The parametric blade as a smooth tube: u runs in about a millimetre of contour from the trailing edge over the
/// suction side, the leading edge and the pressure side back; the edges are true arcs. v = z before the warp's shift.
/// Immutable.
class BladePatch final : public Patch {
  public:
    /// Between z_root - beyond and z_tip + beyond. Errors: config_invalid when the numbers give no sound section there.
    static core::Result<std::shared_ptr<const BladePatch>> make(const BladeNumbers& numbers, double beyond_mm,
                                                                const Warp& warp = {});

    PatchPoint at(double u, double v) const override;
    Eigen::Vector3d point(double u, double v) const override;
    const std::vector<double>& u_breaks() const override { return u_breaks_; }
    const std::vector<double>& v_breaks() const override { return v_breaks_; }

    const BladeNumbers& numbers() const { return numbers_; }

  private:
    BladePatch(const BladeNumbers& numbers, double beyond_mm, const Warp& warp);
    core::Status check() const;
    template <class T>
    struct Section;
    template <class T>
    Section<T> section(const T& z) const;
    template <class T>
    std::array<T, 3> evaluate(const T& u, double u_value, const T& z) const;

    BladeNumbers numbers_;
    Warp warp_;
    std::vector<double> u_breaks_, v_breaks_;
};

}  // namespace cmm::sim
