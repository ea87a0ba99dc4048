// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <utility>

#include "core/error.hpp"

namespace cmm::drivers {

/// What a machine is not asked to do: machine_refused, and it stands. Any Result takes it.
inline tl::unexpected<core::Error> refuse(std::string why) {
    return core::fail(core::ErrorCode::machine_refused, std::move(why), core::Motion::stopped);
}

}  // namespace cmm::drivers
