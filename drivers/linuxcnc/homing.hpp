// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <boost/asio/awaitable.hpp>

#include "drivers/linuxcnc/linuxcnc_settings.hpp"
#include "drivers/linuxcnc/motions.hpp"

namespace cmm::drivers::linuxcnc {

/// Emergency stop off, if it may be taken back, and drives on. LinuxCNC starts in emergency stop, and does not tell
/// that from one that somebody has pressed. Errors: machine_emergency, machine_refused, transport_*.
boost::asio::awaitable<core::Status> switch_on(RshSession& session, bool may_reset_estop);
/// Switches on, homes all joints in the order of LinuxCNC's ini file and waits until they are homed and stand. All
/// three outlive it.
boost::asio::awaitable<core::Status> home_all_joints(RshSession& session, Motions& motions,
                                                     const LinuxcncSettings& settings);

}  // namespace cmm::drivers::linuxcnc
