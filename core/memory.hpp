// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace cmm::core {

/// For a program's first line: memory that is freed stays with the process for its next use. By default glibc gives
/// large pieces back to the system at once and has to fault them in again: half of a section fit's time. A heap keeps
/// up to 64 MB so. Returns whether the allocator does it: those of other C libraries and of sanitizers do not.
bool keep_freed_memory() noexcept;

}  // namespace cmm::core
