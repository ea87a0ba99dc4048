// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include "sim/mesh.hpp"
#include "sim/surface.hpp"

namespace cmm::sim {

/// A point of a smooth surface S(u, v) with its derivatives.
struct PatchPoint {
    Eigen::Vector3d s, su, sv, suu, suv, svv;
};

/// A smooth tube S(u, v): closed in u (counter-clockwise seen from +z), v rising along the span. Millimetres.
/// Immutable.
class Patch {
  public:
    virtual ~Patch() = default;
    virtual PatchPoint at(double u, double v) const = 0;  ///< any u (periodic), v from first to last break
    virtual Eigen::Vector3d point(double u, double v) const = 0;
    /// Rising parameters between which the surface is smooth; the last u break is the first one plus the period.
    virtual const std::vector<double>& u_breaks() const = 0;
    virtual const std::vector<double>& v_breaks() const = 0;

  protected:
    Patch() = default;
    Patch(const Patch&) = default;
    Patch& operator=(const Patch&) = default;
};

/// The exact signed distance to a patch that is closed by flat ends: nearest triangle of a tessellation with a chord
/// error of a few micrometres, then Newton's method on the patch itself, so that a contact knows no facets. The
/// tessellation decides which part of the surface is nearest; a Newton result worse than its foot is not believed.
/// Immutable; any thread.
class PatchSurface final : public Surface {
  public:
    /// The facets stay within about `chord_mm` of the patch; they bound the speed, not the accuracy.
    explicit PatchSurface(std::shared_ptr<const Patch> patch, double chord_mm = 0.004);

    Contact nearest(const Eigen::Vector3d& centre_mm, std::size_t& warm) const override;
    Box box() const override { return facets_.box(); }

    const Patch& patch() const { return *patch_; }
    const std::vector<double>& u_lines() const { return u_; }
    const MeshSurface& facets() const { return facets_; }

  private:
    struct Foot;
    Foot start(const Bvh::Hit& hit) const;
    bool refine(const Eigen::Vector3d& centre, Foot& foot) const;

    std::shared_ptr<const Patch> patch_;
    std::vector<double> u_, v_;    // lines of the tessellation; the last u closes the tube
    MeshSurface facets_;           // the tube's triangles first, two a cell, then the ends
    double chord_error_mm_ = 0.0;  // measured
};

}  // namespace cmm::sim
