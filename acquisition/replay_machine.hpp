// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "core/error.hpp"
#include "drivers/registry.hpp"

namespace cmm::acquisition {

/// A run file as a machine (`replay:run.cmmrun?speed=1`): it has the capabilities of the machine that was recorded and
/// answers the same plan with the recorded samples, each once, in order, with their numbers, machine times and counts;
/// the host time is that of the replay, the path the one asked for. Paced by the recorded machine times; speed 0, the
/// default, gives them as fast as they are taken. Where the recording ends, a scan ends with fewer points than asked
/// for and no error. A touch finds what was found on the same line, else nothing. Everything else succeeds at once.
/// Another plan is refused by the plan check (Capabilities::recorded_plan). Makes the machine; the file is read by
/// connect(). Errors of connect: those of Recording::load and recorded_capabilities.
core::Result<std::unique_ptr<drivers::Machine>> make_replay_machine(const drivers::LinkSettings& settings,
                                                                    const drivers::DriverContext& context);

}  // namespace cmm::acquisition
