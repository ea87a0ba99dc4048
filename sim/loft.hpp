// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "core/error.hpp"
#include "sim/patch.hpp"
#include "sim/spline.hpp"

namespace cmm::sim {

/// The loft of closed profiles (docs/part-file.md, "Loft"): periodic cubic splines along the profiles, natural cubic
/// splines across, as one tensor product; C2 everywhere. Beyond the end profiles it goes on straight. u and v run in
/// about a millimetre along and across. Immutable; any thread.
class LoftPatch final : public Patch {
  public:
    /// Profiles in any order, either direction, without the closing point; span along +z. `beyond_mm`: how far the
    /// surface goes on over both ends. Errors: input_invalid (fewer than two profiles, fewer than eight points,
    /// profiles at the same height).
    static core::Result<std::shared_ptr<const LoftPatch>> make(std::vector<Points> profiles, double beyond_mm);

    PatchPoint at(double u, double v) const override;
    Eigen::Vector3d point(double u, double v) const override;
    const std::vector<double>& u_breaks() const override { return u_; }
    const std::vector<double>& v_breaks() const override { return v_breaks_; }

  private:
    /// A grid point's value, second derivatives along and across, and the mixed fourth one.
    struct Node {
        Eigen::Vector3d p, uu, vv, uuvv;
    };
    struct Place;
    LoftPatch(const std::vector<Points>& profiles, double beyond_mm);
    Place locate(double u, double v) const;

    std::vector<double> u_, v_, v_breaks_;
    std::vector<Node> nodes_;  // profile by profile
};

}  // namespace cmm::sim
