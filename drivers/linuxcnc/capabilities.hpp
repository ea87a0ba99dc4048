// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>

#include "drivers/linuxcnc/linuxcnc_settings.hpp"
#include "drivers/machine.hpp"

namespace cmm::drivers::linuxcnc {

/// LinuxCNC prints 1e-6 of its unit; with this count 32 bits reach 21 m.
inline constexpr double lsb_mm = 1e-5;

/// What the machine can do, as far as LinuxCNC or the machine file tells; `ini_file` is the only name it has.
Capabilities capabilities_of(const LinuxcncSettings& told, std::string ini_file);
/// Within the limits that the machine file gives. Errors: machine_limit, machine_refused (speed).
core::Status check_target(const LinuxcncSettings& told, const Eigen::Vector3d& centre_mm, double speed_mm_s);

}  // namespace cmm::drivers::linuxcnc
