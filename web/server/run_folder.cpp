// SPDX-License-Identifier: Apache-2.0
#include "web/server/run_folder.hpp"

#include <algorithm>
#include <filesystem>
#include <system_error>
#include <utility>

namespace cmm::web {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t most_runs = 1000;

bool holds_run(const RunFolder& run) {
    std::error_code ignored;
    return fs::is_regular_file(run.run_file(), ignored);
}

}  // namespace

RunFolders::RunFolders(std::string folder, const std::string& live) : folder_(std::move(folder)) {
    begin(live);
}

void RunFolders::begin(const std::string& live) {
    live_.reset();
    if (live.empty()) return;
    std::error_code ignored;
    const fs::path whole = fs::weakly_canonical(fs::absolute(live, ignored), ignored);
    const std::string name = whole.filename().empty() ? "run" : whole.filename().string();
    live_ = RunFolder{name, whole.string()};
}

std::vector<RunFolder> RunFolders::list() const {
    std::vector<RunFolder> runs;
    std::error_code code;
    fs::directory_iterator entries(folder_, fs::directory_options::skip_permission_denied, code);
    for (; !folder_.empty() && !code && entries != fs::directory_iterator() && runs.size() < most_runs;
         entries.increment(code)) {
        RunFolder run{entries->path().filename().string(), entries->path().string()};
        if ((live_ && run.id == live_->id) || !holds_run(run)) continue;
        runs.push_back(std::move(run));
    }
    if (live_) runs.push_back(*live_);
    std::sort(runs.begin(), runs.end(), [](const auto& a, const auto& b) { return a.id < b.id; });
    return runs;
}

std::optional<RunFolder> RunFolders::find(const std::string& id) const {
    if (live_ && id == live_->id) return live_;
    for (auto& run : list())
        if (run.id == id) return run;
    return {};
}

}  // namespace cmm::web
