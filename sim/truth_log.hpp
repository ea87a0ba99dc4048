// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdio>
#include <memory>
#include <string>

#include "core/clock.hpp"
#include "sim/controller.hpp"

namespace cmm::sim {

/// What really happened, as CSV: one row for each sample pushed into the FIFO, appended to what the file holds (the
/// boot id tells the runs apart). Handed to the operating system at least every 100 ms of `flush_if_due`, and on
/// destruction. One thread.
class TruthLog {
  public:
    /// Errors: journal_io.
    static core::Result<std::unique_ptr<TruthLog>> open(const std::string& file, std::uint16_t boot_id);

    void write(const SampleTruth& truth);
    void flush_if_due(core::Duration now);

  private:
    struct Closer {
        void operator()(std::FILE* file) const { std::fclose(file); }
    };
    TruthLog(std::FILE* file, std::uint16_t boot_id) : file_(file), boot_id_(boot_id) {}
    std::unique_ptr<std::FILE, Closer> file_;
    std::uint16_t boot_id_;
    core::Duration last_flush_{0};
};

}  // namespace cmm::sim
