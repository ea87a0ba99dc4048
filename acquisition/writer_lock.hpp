// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "core/error.hpp"

namespace cmm::acquisition {

/// Keeps a second writer away from a run file for as long as it lives; the lock dies with the process. Movable.
class WriterLock {
  public:
    /// Errors: journal_io (cannot be opened for writing; another run is writing it).
    static core::Result<WriterLock> take(const std::string& file);
    WriterLock(WriterLock&& other) noexcept;
    WriterLock& operator=(WriterLock&&) = delete;
    WriterLock(const WriterLock&) = delete;
    WriterLock& operator=(const WriterLock&) = delete;
    ~WriterLock();

  private:
    explicit WriterLock(int descriptor) : descriptor_(descriptor) {}
    int descriptor_;
};

}  // namespace cmm::acquisition
