// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <string>

#include "core/config.hpp"

namespace cmm::drivers::linuxcnc {

/// What linuxcncrsh cannot be asked: the [linuxcnc] table of a machine file (docs/linuxcnc.md). A plain value.
struct LinuxcncSettings {
    std::string connect_password = "EMC";    ///< linuxcncrsh --connectpw
    std::string enable_password = "EMCTOO";  ///< linuxcncrsh --enablepw
    std::size_t joints = 3;                  ///< as [KINS] JOINTS
    bool reset_estop = false;  ///< homing and the clearing of a fault may take its own emergency stop back
    std::optional<Eigen::Vector3d> limit_min_mm, limit_max_mm;
    double max_speed_mm_s = 0.0;          ///< 0: whatever LinuxCNC allows
    double max_acceleration_mm_s2 = 0.0;  ///< 0: not known
    double latch_delay_us =
        0.0;  ///< mean time from contact until the position is latched; taken back along the approach
    double home_patience_s = 30.0;  ///< homing that stands still for so long has failed
};

/// Errors are left in the table (ConfigTable::complain).
LinuxcncSettings read_linuxcnc_settings(const core::ConfigTable& table);

}  // namespace cmm::drivers::linuxcnc
