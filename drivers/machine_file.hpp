// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "core/config.hpp"
#include "core/error.hpp"
#include "drivers/dro/dro_settings.hpp"
#include "drivers/endpoint.hpp"
#include "drivers/linuxcnc/linuxcnc_settings.hpp"
#include "drivers/machine_errors.hpp"

namespace cmm::drivers {

/// How to reach a machine, and by how much it may err: the [link] table of a machine file
/// (config/machines/modbus-tcp.toml explains the keys), or a URL alone with the defaults below. A plain value.
struct LinkSettings {
    Endpoint endpoint;
    std::string map_file;  ///< register map; empty: version 1 as documented
    double connect_timeout_ms = 2000.0;
    double response_timeout_ms = 500.0;
    double reconnect_ms = 3000.0;  ///< how long a broken link is tried again before an operation fails
    double poll_ms = 2.0;  ///< pause between exchanges while no sample waits, at most 10; longer where the controller
                           ///< has points in plenty
    dro::DroSettings dro;  ///< of dro+serial
    linuxcnc::LinuxcncSettings linuxcnc;
    MachineErrors errors;  ///< not of the link: what its points are worth
};

/// Reads a machine file; the table [controller] belongs to the simulator. Errors: input_missing,
/// config_*.
core::Result<LinkSettings> load_link_settings(const std::string& path);
core::Result<LinkSettings> read_link_settings(const core::ConfigTable& root);
/// A URL ("scheme:...") or the name of a machine file.
core::Result<LinkSettings> link_settings_from(const std::string& url_or_file);

}  // namespace cmm::drivers
