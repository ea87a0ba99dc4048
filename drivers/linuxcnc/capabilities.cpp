// SPDX-License-Identifier: Apache-2.0
#include "drivers/linuxcnc/capabilities.hpp"

#include <array>
#include <limits>
#include <utility>

#include "core/text.hpp"

namespace cmm::drivers::linuxcnc {

using core::ErrorCode;
using core::Motion;
using Eigen::Vector3d;

Capabilities capabilities_of(const LinuxcncSettings& told, std::string ini_file) {
    Capabilities machine;
    machine.model = "LinuxCNC";
    machine.serial = std::move(ini_file);
    machine.touches = true;
    machine.lsb_mm = lsb_mm;
    const double reach_mm = lsb_mm * std::numeric_limits<std::int32_t>::max();
    machine.limit_min_mm = told.limit_min_mm.value_or(Vector3d::Constant(-reach_mm));
    machine.limit_max_mm = told.limit_max_mm.value_or(Vector3d::Constant(reach_mm));
    machine.max_speed_mm_s = told.max_speed_mm_s;
    machine.max_acceleration_mm_s2 = told.max_acceleration_mm_s2;
    return machine;
}

core::Status check_target(const LinuxcncSettings& told, const Vector3d& centre_mm, double speed_mm_s) {
    const Capabilities machine = capabilities_of(told, {});
    constexpr std::array names{"x", "y", "z"};
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
        const double value = centre_mm[axis];
        if (value >= machine.limit_min_mm[axis] && value <= machine.limit_max_mm[axis]) continue;
        return core::fail(ErrorCode::machine_limit,
                          "target " + std::string(names[static_cast<std::size_t>(axis)]) + " = " +
                              core::fixed(value, 3) + " mm lies outside the travel limits " +
                              core::fixed(machine.limit_min_mm[axis], 3) + " to " +
                              core::fixed(machine.limit_max_mm[axis], 3) + " mm",
                          Motion::stopped);
    }
    const bool has_fastest = machine.max_speed_mm_s > 0.0;
    const double fastest = has_fastest ? machine.max_speed_mm_s : std::numeric_limits<double>::max();
    if (speed_mm_s > 0.0 && speed_mm_s <= fastest) return {};
    return core::fail(ErrorCode::machine_refused,
                      "a speed of " + core::fixed(speed_mm_s, 3) + " mm/s is not " +
                          (has_fastest ? "within 0 to " + core::fixed(fastest, 3) + " mm/s" : "positive"),
                      Motion::stopped);
}

}  // namespace cmm::drivers::linuxcnc
