// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdio>
#include <memory>
#include <string>
#include <string_view>

#include "acquisition/events.hpp"
#include "acquisition/section_result.hpp"
#include "core/error.hpp"

/// What the commands share towards the user: errors, exit codes, progress, the event file, and where config/ is.
namespace cmm::app {

/// Prints the error with its advice on standard error (and as one JSON document on standard output with `json`);
/// returns its exit code.
int report(const core::Error& error, bool json);
int exit_code(acquisition::Decision verdict) noexcept;

/// The folder with machines/, maps/, parts/: beside the build folder, or under share/ of the installation, or
/// CMMLIVE_CONFIG_DIR. Errors: input_missing.
core::Result<std::string> config_folder();

/// One live line on a terminal, a line per 10 % in a pipe; on standard error. One thread at a time.
class Progress {
  public:
    explicit Progress(bool quiet = false);
    ~Progress();
    Progress(const Progress&) = delete;
    Progress& operator=(const Progress&) = delete;
    void show(double share, std::string_view text);
    /// A line that stays.
    void line(std::string_view text);

  private:
    void clear();
    bool quiet_, terminal_;
    int last_tenth_ = -1;
    bool dirty_ = false;
};

/// Writes every event as a line of NDJSON, flushed at once. "-" is standard output.
class EventFile {
  public:
    static core::Result<std::shared_ptr<EventFile>> open(const std::string& name);
    ~EventFile();
    EventFile(const EventFile&) = delete;
    EventFile& operator=(const EventFile&) = delete;
    void write(const acquisition::Event& event);

  private:
    explicit EventFile(std::FILE* file) : file_(file) {}
    std::FILE* file_;
};

/// Now, as "2026-01-31T12:00:00Z".
std::string utc_now();
std::string version();

}  // namespace cmm::app
