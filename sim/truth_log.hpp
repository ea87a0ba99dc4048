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
    static core::Result<std::unique_ptr<TruthLog>> open(const std::string& file);

    void write(const SampleTruth& truth, std::uint16_t boot_id);
    void flush_if_due(core::Duration now);

  private:
    struct Closer {
        void operator()(std::FILE* file) const { std::fclose(file); }
    };
    explicit TruthLog(std::FILE* file) : file_(file) {}
    std::unique_ptr<std::FILE, Closer> file_;
    core::Duration last_flush_{0};
};

}  // namespace cmm::sim
