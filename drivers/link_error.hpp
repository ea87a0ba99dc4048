// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/error.hpp"

namespace cmm::drivers {

/// Whether an error is one of the link itself: what was asked may have been done all the same, and a machine may move
/// on unheard.
constexpr bool is_transport(core::ErrorCode code) noexcept {
    return code == core::ErrorCode::transport_connect || code == core::ErrorCode::transport_timeout ||
           code == core::ErrorCode::transport_closed;
}

}  // namespace cmm::drivers
