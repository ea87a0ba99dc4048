// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "core/config.hpp"
#include "core/error.hpp"
#include "sim/machine_error.hpp"

namespace cmm::sim {

/// The nearest point of a part to a ball centre.
struct Contact {
    double distance_mm = 0.0;                           ///< signed: negative inside the material
    Eigen::Vector3d point = Eigen::Vector3d::Zero();    ///< on the surface
    Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  ///< unit, out of the material
};

struct Box {
    Eigen::Vector3d low = Eigen::Vector3d::Zero();
    Eigen::Vector3d high = Eigen::Vector3d::Zero();
};

/// What lies on the simulated machine, as the exact distance to its surface: the ball touches where the distance of its
/// centre equals its radius, which is where the 3-D normals agree. Millimetres, machine frame. Immutable after
/// construction; may be asked from several threads.
class Surface {
  public:
    virtual ~Surface() = default;
    /// `warm` keeps the last answer's place for the next call nearby; one per caller, starts at 0.
    virtual Contact nearest(const Eigen::Vector3d& centre_mm, std::size_t& warm) const = 0;
    virtual Box box() const = 0;

  protected:
    Surface() = default;
    Surface(const Surface&) = default;
    Surface& operator=(const Surface&) = default;
};

/// What the simulator takes from a part file ([nominal] for its geometry, [actual] for what differs, [stylus], [scan]
/// pitch).
struct Part {
    std::string name;
    std::shared_ptr<const Surface> surface;
    double ball_radius_mm = 1.0;       ///< of the ball that touches; the host may be told another one
    double noise_mm = 0.0;             ///< standard deviation along the normal
    MachineError error;                ///< of the machine that measures it
    double bad_points_share = 0.0;     ///< 0 ... 1 of the recorded points
    std::vector<std::string> remarks;  ///< what the user should know about the geometry, e.g. a mesh with holes
};

/// Reads the part file (docs/part-file.md). Errors: config_*, input_*.
core::Result<Part> load_part(const std::string& part_file);
core::Result<Part> read_part(const core::ConfigTable& root);

}  // namespace cmm::sim
