// SPDX-License-Identifier: Apache-2.0
#include "app/console.hpp"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <filesystem>

#include "acquisition/json_text.hpp"
#include "core/text.hpp"

namespace cmm::app {

int report(const core::Error& error, bool json) {
    const int code = core::exit_code(error.code);
    std::fprintf(stderr, "cmmlive: %s\n", error.text().c_str());
    if (error.motion != core::Motion::not_concerned) {
        std::fprintf(stderr, "  machine: %s\n", std::string(core::to_string(error.motion)).c_str());
    }
    std::fprintf(stderr, "  %s\n", std::string(core::advice(error.code)).c_str());
    if (json) {
        std::printf("{\"error\":{\"code\":%s,\"message\":%s,\"advice\":%s,\"motion\":%s},\"exit_code\":%d}\n",
                    acquisition::json_string(core::to_string(error.code)).c_str(),
                    acquisition::json_string(error.text()).c_str(),
                    acquisition::json_string(core::advice(error.code)).c_str(),
                    acquisition::json_string(core::to_string(error.motion)).c_str(), code);
    }
    return code;
}

int exit_code(acquisition::Decision verdict) noexcept {
    switch (verdict) {
        case acquisition::Decision::accept:
        case acquisition::Decision::reported:
            return 0;
        case acquisition::Decision::reject:
            return 1;
        case acquisition::Decision::undecided:
        case acquisition::Decision::not_evaluable:
            return 2;
    }
    return 70;
}

core::Result<std::string> config_folder() {
    namespace fs = std::filesystem;
    std::error_code ignored;
    std::vector<fs::path> candidates;
    if (const char* named = std::getenv("CMMLIVE_CONFIG_DIR")) candidates.emplace_back(named);
    const fs::path executable = fs::read_symlink("/proc/self/exe", ignored);
    candidates.push_back(executable.parent_path() / "../../config");
    candidates.push_back(executable.parent_path() / "../share/cmmlive/config");
    for (const auto& candidate : candidates) {
        if (fs::exists(candidate / "maps", ignored)) return fs::weakly_canonical(candidate, ignored).string();
    }
    return core::fail(core::ErrorCode::input_missing,
                      "the folder config/ of cmmlive was not found beside the program; set CMMLIVE_CONFIG_DIR to it");
}

Progress::Progress(bool quiet) : quiet_(quiet), terminal_(::isatty(STDERR_FILENO) == 1) {}
Progress::~Progress() {
    clear();
}

void Progress::clear() {
    if (dirty_) std::fputs("\r\033[K", stderr);
    dirty_ = false;
}

void Progress::show(double share, std::string_view text) {
    if (quiet_) return;
    const int percent = static_cast<int>(std::clamp(share, 0.0, 1.0) * 100.0);
    if (terminal_) {
        std::fprintf(stderr, "\r\033[K%3d %%  %.*s", percent, static_cast<int>(text.size()), text.data());
        std::fflush(stderr);
        dirty_ = true;
        return;
    }
    if (percent / 10 == last_tenth_) return;
    last_tenth_ = percent / 10;
    std::fprintf(stderr, "%3d %%  %.*s\n", percent, static_cast<int>(text.size()), text.data());
}

void Progress::line(std::string_view text) {
    if (quiet_) return;
    clear();
    std::fprintf(stderr, "%.*s\n", static_cast<int>(text.size()), text.data());
}

core::Result<std::shared_ptr<EventFile>> EventFile::open(const std::string& name) {
    if (name.empty()) return std::shared_ptr<EventFile>();
    std::FILE* file = name == "-" ? stdout : std::fopen(name.c_str(), "w");
    if (file == nullptr) {
        return core::fail(core::ErrorCode::journal_io, name + ": cannot be written: " + std::strerror(errno));
    }
    return std::shared_ptr<EventFile>(new EventFile(file));
}

EventFile::~EventFile() {
    if (file_ != stdout) std::fclose(file_);
}

void EventFile::write(const acquisition::Event& event) {
    const std::string line = acquisition::to_ndjson(event) + "\n";
    std::fwrite(line.data(), 1, line.size(), file_);
    std::fflush(file_);
}

std::string utc_now() {
    const std::time_t now = std::time(nullptr);
    std::tm utc{};
    gmtime_r(&now, &utc);
    char text[32];
    std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &utc);
    return text;
}

std::string version() {
    return CMMLIVE_VERSION;
}

}  // namespace cmm::app
