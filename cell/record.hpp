// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "cell/outcome.hpp"
#include "core/error.hpp"

namespace cmm::cell {

/// What survives the service: the part that was taken on last and how far it is.
struct CellRecord {
    enum class Phase : std::uint8_t {
        cleared,  ///< its result was acknowledged, or there was none yet
        measuring,
        done,  ///< its result waits for the acknowledgement
    };
    Phase phase = Phase::cleared;
    Order order;
    Outcome outcome;
};

/// Of a file; absent: nothing was taken on yet. Errors: input_missing, input_invalid.
core::Result<CellRecord> load_record(const std::string& file);
/// Whole and on the disk when it returns, or the one before. Errors: journal_io, journal_full.
core::Status save_record(const std::string& file, const CellRecord& record);

}  // namespace cmm::cell
