// SPDX-License-Identifier: Apache-2.0
#include <stdlib.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>

#include "acquisition/run_results.hpp"
#include "app/commands.hpp"
#include "app/console.hpp"
#include "app/run_input.hpp"
#include "app/scan_runner.hpp"

namespace cmm::app {
namespace {

/// A folder for results that nobody asked for; gone at the end.
class ScratchFolder {
  public:
    ScratchFolder() : path_((std::filesystem::temp_directory_path() / "cmmlive-replay-XXXXXX").string()) {
        made_ = ::mkdtemp(path_.data()) != nullptr;
    }
    ~ScratchFolder() {
        std::error_code ignored;
        if (made_) std::filesystem::remove_all(path_, ignored);
    }
    ScratchFolder(const ScratchFolder&) = delete;
    ScratchFolder& operator=(const ScratchFolder&) = delete;
    bool made() const { return made_; }
    const std::string& path() const { return path_; }

  private:
    std::string path_;
    bool made_ = false;
};

core::Result<std::string> machine_of(const ReplayOptions& options, const std::string& run_file) {
    if (options.speed != std::floor(options.speed) || options.speed > 1000.0) {
        return core::fail(core::ErrorCode::usage,
                          "--speed of a replay is a whole number from 0 (as fast as it goes) to 1000");
    }
    return "replay:" + run_file + "?speed=" + std::to_string(static_cast<int>(options.speed));
}

}  // namespace

/// The run is planned by the part file kept in it and answered by its own samples.
int run_replay(const ReplayOptions& options) {
    const std::string run_file = run_file_of(options.input);
    const auto machine = machine_of(options, run_file);
    if (!machine) return report(machine.error(), options.json);
    auto part = acquisition::part_of_run(run_file);
    if (!part) return report(part.error(), options.json);
    std::unique_ptr<ScratchFolder> scratch;
    if (options.out.empty()) {
        scratch = std::make_unique<ScratchFolder>();
        if (!scratch->made()) {
            return report({core::ErrorCode::journal_io,
                           scratch->path() + ": cannot be made; give --out DIR",
                           {},
                           core::Motion::not_concerned},
                          options.json);
        }
    }
    RunnerOptions runner;
    runner.machine = *machine;
    runner.known_part = std::make_shared<const acquisition::PartFile>(std::move(*part));
    runner.out = scratch ? scratch->path() : options.out;
    runner.scratch = scratch != nullptr;
    runner.events = options.events;
    runner.json = options.json;
    return run_main_job(runner);
}

}  // namespace cmm::app
