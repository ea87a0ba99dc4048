// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/clock.hpp"

namespace cmm::core {

/// What the processors have worked for the calling thread by now: no waiting, of whatever kind, is in its differences.
Duration thread_processor_time() noexcept;

}  // namespace cmm::core
