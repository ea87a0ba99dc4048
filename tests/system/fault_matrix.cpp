// SPDX-License-Identifier: Apache-2.0
#include "tests/system/fault_matrix.hpp"

#include <sys/resource.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <map>
#include <mutex>
#include <regex>

#include "core/rng.hpp"
#include "tests/support/outputs.hpp"
#include "tests/system/compare_samples.hpp"
#include "tests/system/resumable_run.hpp"

namespace cmm::test {
namespace {

constexpr const char* part = "tests/system/parts/fault-job.toml";
constexpr auto deadline = std::chrono::seconds(40);
constexpr int most_resumes = 4;
constexpr auto asking = std::chrono::milliseconds(1000);  // for another host to connect and to be told

std::string endpoint(Wire wire, const TemporaryFolder& folder) {
    if (wire == Wire::rtu) return "modbus+rtu://" + folder.path() + "/port?pty=yes&baud=115200&parity=none&unit=5";
    if (wire == Wire::line) return "line+serial://" + folder.path() + "/port?pty=yes&baud=115200";
    return "modbus+tcp://127.0.0.1:0";
}

bool of_host(const FaultCase& fault) {
    return fault.name.starts_with("host-") || fault.name.starts_with("disk-");
}

std::string text_of(const std::string& path) {
    std::ifstream in(path);
    return std::string(std::istreambuf_iterator<char>(in), {});
}

bool finished(const Finished& run) {
    return run.exit_code >= 0 && run.exit_code <= 2;
}

bool is_at_rest(const std::string& state) {
    return state == "idle" || state == "stopped" || state == "fault" || state == "emergency stop";
}

/// The code of the error that a run with --json ended with, and whether it came with advice.
struct Ending {
    std::string code;
    bool advised = false;
};
Ending ending_of(const Finished& run) {
    const auto document = nlohmann::json::parse(run.out, nullptr, false);
    if (document.is_discarded() || !document.contains("error")) return {};
    const auto& error = document["error"];
    return {error["code"], !error["advice"].get<std::string>().empty()};
}

/// The points of the job with this seed when nothing breaks, over TCP.
std::string points_without_faults(std::uint64_t seed) {
    static std::mutex mutex;
    static std::map<std::uint64_t, std::string> known;
    const std::lock_guard lock(mutex);
    const auto found = known.find(seed);
    if (found != known.end()) return found->second;
    const TemporaryFolder folder;
    const SimulatedMachine machine(part, folder, {"--speed", "20", "--seed", std::to_string(seed)});
    const auto scan = Process(scan_command(machine, part, folder / "out", false), folder / "scan").wait(deadline);
    return known[seed] = finished(scan) ? text_of(folder / "out/points.csv") : "the job fails without a fault";
}

/// One run of the matrix: a machine, and the host's attempts on it.
class Rehearsal {
  public:
    Rehearsal(const FaultCase& fault, Wire wire, std::uint64_t seed, const TemporaryFolder& folder)
        : fault_(fault),
          folder_(folder),
          out_(folder / "out"),
          seed_(seed),
          rng_(core::Rng::keyed(seed, 11, static_cast<std::uint64_t>(wire))),
          machine_(part, folder, options(fault, seed), endpoint(wire, folder)) {}

    FaultRun run() {
        if (machine_.url().empty()) {
            result_.wrong = "the simulator does not start: " + machine_.process().err();
            return result_;
        }
        auto last = attempt(true);
        result_.finished_at_once = finished(last);
        if (of_host(fault_) && fault_.stop_ms > 0.0 && !finished(last)) watch_rest();
        if (!finished(last)) judge_end(last);
        if (!fault_.finishes && finished(last) && struck()) result_.wrong = "finished though it should not";
        bool done = finished(last);
        for (int resume = 0; !done && resume < most_resumes && result_.good(); ++resume) {
            if (fault_.lasting) wait_until_mended();
            last = attempt(false);
            done = finished(last);
            if (!done) judge_end(last);
            if (!done && !fault_.curable) break;
        }
        result_.recovered = done;
        if (!done && fault_.curable && result_.good()) result_.wrong = "does not finish: " + last.err;
        machine_.end();
        judge_machine();
        if (done && std::filesystem::exists(run_file())) result_.lost = compare_samples({run_file()}, machine_.log());
        const bool same_points = fault_.spares_points && result_.finished_at_once;
        if (same_points && text_of(out_ + "/points.csv") != points_without_faults(seed_))
            result_.wrong = "the points are not those of a run without faults";
        return result_;
    }

  private:
    static std::vector<std::string> options(const FaultCase& fault, std::uint64_t seed) {
        std::vector<std::string> list{"--speed", fault.speed, "--seed", std::to_string(seed)};
        if (!of_host(fault)) {
            list.emplace_back("--faults");
            list.push_back("config/faults/" + (fault.plan.empty() ? fault.name : fault.plan) + ".toml");
        }
        return list;
    }
    std::string run_file() const { return out_ + "/run.cmmrun"; }
    bool fills_disk() const { return fault_.name.starts_with("disk-full"); }
    bool struck() { return of_host(fault_) || machine_.process().err().find("fault ") != std::string::npos; }
    void wait_until_mended() {
        wait_for([this] { return machine_.process().err().find("mended") != std::string::npos; });
    }

    /// What the host's surroundings do to the first attempt.
    std::vector<std::string> surroundings() {
        if (fault_.name == "disk-slow") {
            return {"env", "LD_PRELOAD=" CMMLIVE_SLOW_DISK, "ASAN_OPTIONS=verify_asan_link_order=0",
                    "SLOW_DISK_MS=" + std::to_string(20 + rng_.below(180))};
        }
        if (fills_disk()) {  // a file that may not grow refuses like a full disk
            // With less than this there is no run file to go on with.
            const auto kilobytes = (fault_.plan.empty() ? 16 : 60) + rng_.below(fault_.plan.empty() ? 64 : 20);
            return {"bash", "-c", "trap '' XFSZ; ulimit -S -f " + std::to_string(kilobytes) + "; exec \"$@\"", "bash"};
        }
        return {};
    }

    Finished attempt(bool first) {
        auto command = first ? surroundings() : std::vector<std::string>();
        const auto scan = scan_command(machine_, part, out_, std::filesystem::exists(run_file()));
        command.insert(command.end(), scan.begin(), scan.end());
        command.insert(command.end(), {"--wait-s", fault_.wait_s});
        const bool watched = first && fills_disk() && fault_.wait_s != "0";
        if (!watched) command.emplace_back("--json");
        Process process(command, folder_ / ("scan-" + std::to_string(attempts_++)));
        if (first && fault_.name == "host-killed") {
            wait_for([&] { return !process.running(); }, std::chrono::milliseconds(50 + rng_.below(1500)));
            process.signal(SIGKILL);
        }
        if (watched) make_room(process);
        auto ended = process.wait(deadline);
        if (ended.exit_code == 128 + SIGKILL && fault_.name != "host-killed") {
            result_.hung = "the scan did not end within " + std::to_string(deadline.count()) + " s";
        }
        return ended;
    }

    /// When the host says that it waits, the disk is empty again.
    static void make_room(Process& process) {
        const auto waits = [&] { return process.err().find("waiting at rest") != std::string::npos; };
        wait_for([&] { return waits() || !process.running(); });
        const rlimit unlimited{RLIM_INFINITY, RLIM_INFINITY};
        ::prlimit(process.pid(), RLIMIT_FSIZE, &unlimited, nullptr);
    }

    void judge_end(const Finished& run) {
        if (run.exit_code == 128 + SIGKILL) return;
        const Ending end = ending_of(run);
        if (result_.error.empty()) result_.error = end.code;
        const bool expected = std::find(fault_.errors.begin(), fault_.errors.end(), end.code) != fault_.errors.end();
        if (!expected) result_.wrong = "ends with " + std::to_string(run.exit_code) + ": " + run.err;
        if (expected && !end.advised) result_.wrong = end.code + " comes without advice";
    }

    /// The simulator cannot know when the host died: it is asked by another one until it stands.
    void watch_rest() {
        const auto began = std::chrono::steady_clock::now();
        const auto patience = std::chrono::milliseconds(static_cast<int>(fault_.stop_ms)) + asking;
        const bool stands = wait_for([this] { return is_at_rest(state_of(machine_).state); }, patience);
        result_.moved = true;
        result_.rest_ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - began).count();
        if (!stands) result_.unsafe = "the machine still moves";
    }

    void judge_machine() {
        const std::string told = machine_.process().err();
        result_.struck = struck();
        if (of_host(fault_)) return;
        result_.moved = told.find("machine in motion") != std::string::npos;
        if (!result_.moved || fault_.stop_ms == 0.0) return;
        const std::regex rest("at rest ([0-9.]+) ms later, ([0-9.]+) ms of the machine");
        std::smatch found;
        if (!std::regex_search(told, found, rest)) {
            result_.unsafe = "the machine did not come to rest";
            return;
        }
        result_.rest_ms = std::stod(found[1]);
        if (result_.rest_ms > fault_.stop_ms) result_.unsafe = "at rest only after " + found[1].str() + " ms";
    }

    const FaultCase& fault_;
    const TemporaryFolder& folder_;
    std::string out_;
    std::uint64_t seed_;
    core::Rng rng_;
    SimulatedMachine machine_;
    FaultRun result_;
    int attempts_ = 0;
};

}  // namespace

std::string to_string(Wire wire) {
    return wire == Wire::tcp ? "tcp" : wire == Wire::rtu ? "rtu" : "line";
}

std::string FaultRun::text() const {
    std::string line = finished_at_once ? "finished at once" : recovered ? "finished after --resume" : "not finished";
    if (!error.empty()) line += ", " + error;
    if (!struck) line += ", nothing struck";
    if (!lost.empty()) line += "; LOST " + lost;
    if (!hung.empty()) line += "; HUNG " + hung;
    if (!unsafe.empty()) line += "; UNSAFE " + unsafe;
    if (!wrong.empty()) line += "; WRONG " + wrong;
    return line;
}

FaultRun run_fault(const FaultCase& fault, Wire wire, std::uint64_t seed, const TemporaryFolder& folder) {
    return Rehearsal(fault, wire, seed, folder).run();
}

}  // namespace cmm::test
