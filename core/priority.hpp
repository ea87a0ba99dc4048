// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace cmm::core {

/// What talks to machines goes first: the calling thread gets the given niceness (5: fits and files; 10: pages), once.
void stand_back(int niceness) noexcept;

}  // namespace cmm::core
