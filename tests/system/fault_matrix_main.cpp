// SPDX-License-Identifier: Apache-2.0
// The whole fault matrix, as a table (./run faults).
#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <mutex>
#include <sstream>
#include <thread>

#include "tests/system/fault_matrix.hpp"

namespace cmm::test {
namespace {

struct Task {
    FaultCase fault;
    Wire wire = Wire::tcp;
    std::uint64_t seed = 0;
};

/// A row of the table: the runs of a fault on a wire.
struct Row {
    int runs = 0, struck = 0, at_once = 0, recovered = 0, must_stop = 0, stopped = 0, lost = 0, hung = 0, wrong = 0;
    double longest_stop_ms = 0.0;

    void add(const FaultCase& fault, const FaultRun& run) {
        ++runs;
        struck += run.struck ? 1 : 0;
        at_once += run.finished_at_once ? 1 : 0;
        recovered += run.recovered && !run.finished_at_once ? 1 : 0;
        const bool stop = fault.stop_ms > 0.0 && run.moved;
        must_stop += stop ? 1 : 0;
        stopped += stop && run.unsafe.empty() ? 1 : 0;
        lost += run.lost.empty() ? 0 : 1;
        hung += run.hung.empty() ? 0 : 1;
        wrong += run.wrong.empty() ? 0 : 1;
        longest_stop_ms = std::max(longest_stop_ms, run.rest_ms);
    }
    void add(const Row& other) {
        runs += other.runs;
        struck += other.struck;
        at_once += other.at_once;
        recovered += other.recovered;
        must_stop += other.must_stop;
        stopped += other.stopped;
        lost += other.lost;
        hung += other.hung;
        wrong += other.wrong;
        longest_stop_ms = std::max(longest_stop_ms, other.longest_stop_ms);
    }
    bool good() const { return lost + hung + wrong == 0 && stopped == must_stop; }
    std::string text(const std::string& fault, const std::string& wire) const {
        char line[256];
        std::string stops = must_stop == 0 ? "" : std::to_string(stopped) + "/" + std::to_string(must_stop);
        char longest[32] = "";
        if (must_stop > 0) std::snprintf(longest, sizeof longest, "%.0f", longest_stop_ms);
        std::snprintf(line, sizeof line, "| %s | %s | %d | %d | %d | %d | %s | %s | %d | %d | %d |\n", fault.c_str(),
                      wire.c_str(), runs, struck, at_once, recovered, stops.c_str(), longest, lost, hung, wrong);
        return line;
    }
};

constexpr const char* head =
    "| fault | wire | runs | struck | finished at once | after --resume | stopped in time | longest, ms | lost or "
    "doubled | hung | "
    "other end than expected |\n|---|---|---|---|---|---|---|---|---|---|---|\n";

struct Options {
    std::uint64_t seeds = 50, first = 1;
    int jobs = 3;
    double minutes = 1e6;
    std::string only, wire, keep, out;
};

std::vector<Task> tasks_of(const Options& options) {
    std::vector<Task> tasks;
    for (std::uint64_t seed = options.first; seed < options.first + options.seeds; ++seed)
        for (const FaultCase& fault : fault_cases())
            for (const Wire wire : fault.wires) {
                if (!options.only.empty() && fault.name != options.only) continue;
                if (!options.wire.empty() && to_string(wire) != options.wire) continue;
                tasks.push_back({fault, wire, seed});
            }
    return tasks;
}

using Table = std::map<std::pair<std::string, Wire>, Row>;

Table run_all(const Options& options) {
    const auto tasks = tasks_of(options);
    Table table;
    std::mutex mutex;
    std::atomic<std::size_t> next{0};
    const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double, std::ratio<60>>(options.minutes);
    const auto work = [&] {
        for (std::size_t at = next++; at < tasks.size() && std::chrono::steady_clock::now() < end; at = next++) {
            const Task& task = tasks[at];
            const TemporaryFolder folder;
            const FaultRun run = run_fault(task.fault, task.wire, task.seed, folder);
            const std::lock_guard lock(mutex);
            table[{task.fault.name, task.wire}].add(task.fault, run);
            std::fprintf(stderr, "%zu/%zu %s %s %s seed %llu: %s\n", at + 1, tasks.size(), run.good() ? "ok" : "BAD",
                         task.fault.name.c_str(), to_string(task.wire).c_str(),
                         static_cast<unsigned long long>(task.seed), run.text().c_str());
            if (run.good() || options.keep.empty()) continue;
            const std::string kept =
                options.keep + "/" + task.fault.name + "-" + to_string(task.wire) + "-" + std::to_string(task.seed);
            std::filesystem::create_directories(options.keep);
            std::filesystem::copy(folder.path(), kept,
                                  std::filesystem::copy_options::recursive |
                                      std::filesystem::copy_options::overwrite_existing |
                                      std::filesystem::copy_options::skip_symlinks);
        }
    };
    std::vector<std::thread> threads;
    for (int k = 0; k < options.jobs; ++k)
        threads.emplace_back(work);
    for (std::thread& thread : threads)
        thread.join();
    return table;
}

/// Puts the table between the marks of a document.
void write_into(const std::string& file, const std::string& table) {
    std::stringstream text;
    text << std::ifstream(file).rdbuf();
    const std::string begin = "<!-- matrix -->\n", end = "<!-- end of matrix -->";
    std::string document = text.str();
    const auto from = document.find(begin), to = document.find(end);
    if (from == std::string::npos || to == std::string::npos) {
        std::fprintf(stderr, "%s has no marks for the table\n", file.c_str());
        return;
    }
    document.replace(from + begin.size(), to - from - begin.size(), table);
    std::ofstream(file) << document;
}

int main_of(const Options& options) {
    const Table table = run_all(options);
    std::string text = head;
    Row all;
    for (const FaultCase& fault : fault_cases()) {
        for (const Wire wire : fault.wires) {
            const auto row = table.find({fault.name, wire});
            if (row == table.end()) continue;
            text += row->second.text(fault.name, to_string(wire));
            all.add(row->second);
        }
    }
    text += all.text("all", "");
    std::printf("%s", text.c_str());
    if (!options.out.empty()) write_into(options.out, text);
    return all.good() ? 0 : 1;
}

}  // namespace
}  // namespace cmm::test

int main(int argc, char** argv) {
    cmm::test::Options options;
    CLI::App app("Every fault over every wire, at random instants of a job, as a table.");
    app.add_option("--seeds", options.seeds, "runs of each fault on each wire")->check(CLI::PositiveNumber);
    app.add_option("--first", options.first, "the first seed");
    app.add_option("--only", options.only, "one fault, by its name in the table");
    app.add_option("--wire", options.wire, "one wire")->check(CLI::IsMember({"tcp", "rtu", "line"}));
    app.add_option("--jobs", options.jobs, "runs at a time")->check(CLI::PositiveNumber);
    app.add_option("--minutes", options.minutes, "after so many no run is begun any more")->check(CLI::PositiveNumber);
    app.add_option("--keep", options.keep, "folder for what bad runs leave");
    app.add_option("--out", options.out, "document that gets the table between its marks")->check(CLI::ExistingFile);
    CLI11_PARSE(app, argc, argv);
    return cmm::test::main_of(options);
}
