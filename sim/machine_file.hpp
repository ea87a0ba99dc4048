// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <string>

#include "core/config.hpp"
#include "core/error.hpp"

namespace cmm::sim {

/// What the simulated machine is: the [controller] table of a machine file. Millimetres, seconds. A plain value.
struct MachineSettings {
    std::string model = "cmmlive sim";  ///< at most 16 characters
    std::string serial = "SIM-0001";    ///< at most 16 characters
    double lsb_mm = 1e-4;               ///< size of a count
    Eigen::Vector3d limit_min_mm{-500, -500, -100};
    Eigen::Vector3d limit_max_mm{500, 500, 700};
    Eigen::Vector3d home_mm{-500, -500, 700};
    double max_speed_mm_s = 400;
    double max_accel_mm_s2 = 1500;
    int sample_rate_hz = 1000;
    std::size_t fifo_depth = 8192;
    std::size_t path_capacity = 4096;
    int watchdog_ms = 500;
};

/// Reads [controller]; [link] belongs to the host side. Errors: input_missing, config_syntax, config_invalid.
core::Result<MachineSettings> load_machine_settings(const std::string& file);
core::Result<MachineSettings> read_machine_settings(const core::ConfigTable& root);

}  // namespace cmm::sim
