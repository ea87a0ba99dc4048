// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/error.hpp"
#include "core/sample.hpp"

namespace cmm::acquisition {

/// What a run file says about a path of the plan.
struct JournalPath {
    std::uint16_t path = 0;         ///< the id given to the controller, unique in the run
    std::size_t section = 0;        ///< index of the section it belongs to
    std::uint32_t first_index = 0;  ///< of its first recorded point in the section's plan (resume cuts a path)
    bool finished = false;
    std::uint8_t pass = 0;  ///< 0: the lap; k: the kth pass that measures stretches of it again
};

/// The run file `run.cmmrun` (SQLite, WAL, synchronous=FULL): what was planned, every sample, every event of note.
/// Samples are handed over without waiting (`append`, bounded queue) and written by one writer thread in one
/// transaction per 50 ms or 4096 samples; `durable_sequence` tells how far the disk has them. Killing the process at
/// any instant leaves a valid file: a gap-free prefix that holds at least `durable_sequence`. Thread-safe; samples come
/// from one producer. After a failure of the disk every call answers with it.
class Journal {
  public:
    /// A new run; refuses to overwrite an existing file (journal_io). `part_text` and `machine_text` are kept verbatim.
    struct Header {
        std::string run_id, started_utc, part_path, part_text, machine_url, machine_model, machine_serial,
            software_version;
        std::string plan_hash;
        double lsb_mm = 0.0;
        std::uint32_t boot_id = 0;        ///< of the controller, with sequence_shift: drivers::RunOrigin
        std::int64_t sequence_shift = 0;  ///< run sequence = controller sequence + shift
        double ball_radius_mm = 0.0;
        /// What the machine could do, and how it measures (recorded_machine.hpp); empty in files of schema 1.
        std::map<std::string, double> capabilities;
    };
    static core::Result<std::unique_ptr<Journal>> create(const std::string& file, const Header& header);
    /// Opens for going on (`--resume`); one writer at a time. Errors: journal_io, journal_corrupt (application_id,
    /// user_version, CRC, gap).
    static core::Result<std::unique_ptr<Journal>> open(const std::string& file);
    /// Read only: for fit, gate, export, replay.
    static core::Result<std::unique_ptr<Journal>> read(const std::string& file);
    virtual ~Journal() = default;

    virtual const Header& header() const = 0;
    /// The controller was restarted: from now on its numbers mean this. Durable on return.
    virtual core::Status set_origin(std::uint32_t boot_id, std::int64_t sequence_shift) = 0;
    /// Where the part stands on the machine (part_frame.hpp), found once before anything is measured of it; a second
    /// frame is refused (journal_corrupt). Durable on return.
    virtual core::Status set_part_frame(const std::map<std::string, double>& numbers) = 0;
    /// Never blocks the caller for long: when the queue (1 << 20 samples) is full (journal_slow) or the disk failed,
    /// the error comes back and the caller holds the machine. A sequence other than the last one plus 1 is refused
    /// (journal_corrupt).
    virtual core::Status append(std::span<const core::Sample> samples) = 0;
    virtual std::uint64_t durable_sequence() const noexcept = 0;
    /// Has everything written now. Whether it is on the disk; does not wait. An error: the disk has failed.
    virtual core::Result<bool> hasten() = 0;
    /// Waits until everything appended is on the disk.
    virtual core::Status flush() = 0;
    /// Paths and events wait in the same queue and reach the disk in order with the samples. The same id with other
    /// facts, or the end of a path that never began, is refused (internal). Nothing is to be measured before the
    /// beginning is on the disk.
    virtual core::Status begin_path(const JournalPath& path) = 0;
    virtual core::Status finish_path(std::uint16_t path) = 0;
    virtual core::Status add_event(std::uint64_t seq, std::string_view kind, std::string_view ndjson) = 0;
    /// Waits for the disk.
    virtual core::Status finish_run(std::string_view verdict) = 0;

    /// Reading flushes first: it sees all that was appended. Samples come batch by batch, in sequence; `from` the batch
    /// that holds this sequence on.
    using BatchVisitor = std::function<core::Status(std::span<const core::Sample>)>;
    virtual core::Status each_batch_from(std::uint64_t from, const BatchVisitor& visit) const = 0;
    core::Status each_batch(const BatchVisitor& visit) const { return each_batch_from(1, visit); }
    using EventVisitor = std::function<core::Status(std::uint64_t seq, std::string_view ndjson)>;
    virtual core::Status each_event(std::uint64_t from_seq, const EventVisitor& visit) const = 0;
    virtual core::Result<std::uint64_t> last_event_seq() const = 0;  ///< 0: none; a resumed run counts on from it
    virtual core::Result<std::vector<core::Sample>> samples() const = 0;
    virtual core::Result<std::vector<JournalPath>> paths() const = 0;
    /// Empty: none was found, the machine's frame is the part's.
    virtual core::Result<std::map<std::string, double>> part_frame() const = 0;
    virtual core::Result<std::string> verdict() const = 0;  ///< empty: the run did not end

  protected:
    Journal() = default;
    Journal(const Journal&) = default;
    Journal& operator=(const Journal&) = default;
};

}  // namespace cmm::acquisition
