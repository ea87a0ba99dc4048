// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "acquisition/journal.hpp"
#include "acquisition/sample_codec.hpp"
#include "core/error.hpp"

namespace cmm::acquisition {

/// The run file on the disk: the only place that knows SQLite and the schema (docs/outputs.md). One connection, one
/// thread at a time; several connections to one file may be open. Every failure says which file and why, as journal_io,
/// journal_full or journal_corrupt.
class RunFile {
  public:
    /// Makes the whole file under another name first, so that the name never leads to half a file.
    static core::Status create(const std::string& file, const Journal::Header& header);
    enum class Access : std::uint8_t { read, write };
    static core::Result<std::unique_ptr<RunFile>> open(const std::string& file, Access access);
    ~RunFile();
    RunFile(const RunFile&) = delete;
    RunFile& operator=(const RunFile&) = delete;

    core::Status begin();
    core::Status commit();
    void roll_back() noexcept;
    core::Status set_origin(std::uint32_t boot_id, std::int64_t sequence_shift);
    core::Status set_part_frame(const std::map<std::string, double>& numbers);
    core::Status add_batch(std::span<const core::Sample> samples);
    core::Status add_path(const JournalPath& path);
    core::Status set_path_finished(std::uint16_t path);
    core::Status add_event(std::uint64_t seq, std::string_view kind, std::string_view line);
    core::Status set_verdict(std::string_view verdict);
    /// A finished run becomes one plain file without WAL, readable from read-only media.
    core::Status settle();

    core::Result<Journal::Header> header() const;
    core::Status each_batch(std::uint64_t from, const Journal::BatchVisitor& visit) const;
    core::Status each_event(std::uint64_t from_seq, const Journal::EventVisitor& visit) const;
    core::Result<std::vector<JournalPath>> paths() const;
    core::Result<std::map<std::string, double>> part_frame() const;
    core::Result<std::string> verdict() const;
    core::Result<std::uint64_t> last_event_seq() const;

  private:
    struct Connection;
    explicit RunFile(std::unique_ptr<Connection> connection);
    std::unique_ptr<Connection> connection_;
    SampleEncoder encoder_;
};

}  // namespace cmm::acquisition
