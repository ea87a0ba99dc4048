// SPDX-License-Identifier: Apache-2.0
#include "tests/system/soak.hpp"

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <regex>
#include <set>

#include "acquisition/journal.hpp"
#include "tests/support/outputs.hpp"
#include "tests/system/compare_samples.hpp"
#include "tests/system/resumable_run.hpp"

namespace cmm::test {
namespace {

constexpr auto job_deadline = std::chrono::seconds(300);
constexpr int most_resumes = 40;  // of a job, with a fault every one or two seconds of wall time

/// What strikes, beside when: every kind after which a job can be finished.
constexpr const char* kinds[] = {"what = 'emergency_stop'\nfor_s = 0.3",
                                 "what = 'door'\nfor_s = 0.3",
                                 "what = 'temperature'\nfor_s = 0.3",
                                 "what = 'over_deflection'",
                                 "what = 'collision'",
                                 "what = 'travel_limit'",
                                 "what = 'encoder_jump'\nfor_s = 0.3",
                                 "what = 'fifo_overflow'",
                                 "what = 'clock_jump'\nby_s = -0.5",
                                 "what = 'drift'\num_per_s = 2\nfor_s = 0.5",
                                 "what = 'lift_off'\num = 300\ntimes = 2",
                                 "what = 'dirt'\num = 120\ntimes = 4",
                                 "what = 'restart'\nfor_s = 0.3",
                                 "what = 'hang'\nfor_s = 1.5",
                                 "what = 'exception'\ncode = 4",
                                 "what = 'exception'\ncode = 6",
                                 "what = 'delay'\nms = 300",
                                 "what = 'lost_reply'",
                                 "what = 'bad_crc'",
                                 "what = 'split'\nms = 20",
                                 "what = 'merged'",
                                 "what = 'duplicated'",
                                 "what = 'stale'",
                                 "what = 'truncated'",
                                 "what = 'reordered'",
                                 "what = 'closed'\nfor_s = 0.2",
                                 "what = 'cable'\nfor_s = 0.2"};

void write_faults(const SoakOptions& options, const std::string& file) {
    const double mean_s = options.fault_every_s / options.speed * static_cast<double>(std::size(kinds));
    std::ofstream out(file);
    for (const char* kind : kinds)
        out << "[[fault]]\n" << kind << "\nseconds = [0, " << 2.0 * mean_s << "]\nagain = true\n\n";
}

/// The fault job's blade with a section every two millimetres: a job of some minutes.
void write_part(const std::string& file) {
    std::ifstream in("tests/system/parts/fault-job.toml");
    std::string text(std::istreambuf_iterator<char>(in), {});
    std::string heights = "heights_mm = [";
    for (int z = 6; z <= 94; z += 2)
        heights += std::to_string(z) + ".0, ";
    text = std::regex_replace(text, std::regex("heights_mm = [^\n]*"), heights + "]");
    text = std::regex_replace(text, std::regex("pitch_mm = [^\n]*"), "pitch_mm = 0.4");
    std::ofstream(file) << std::regex_replace(text, std::regex("max_speed_mm_s = [^\n]*"), "max_speed_mm_s = 10.0");
}

std::string endpoint(Wire wire, const TemporaryFolder& folder) {
    if (wire == Wire::rtu) return "modbus+rtu://" + folder.path() + "/port?pty=yes&baud=921600&parity=none&unit=5";
    if (wire == Wire::line) return "line+serial://" + folder.path() + "/port?pty=yes&baud=921600";
    return "modbus+tcp://127.0.0.1:0";
}

/// The errors after which the same command is given again.
bool may_end_with(const std::string& code) {
    static const std::set<std::string> codes{
        "machine_emergency", "machine_door",     "machine_temperature", "machine_deflection", "machine_collision",
        "machine_fault",     "machine_limit",    "machine_position",    "machine_overflow",   "machine_no_contact",
        "machine_watchdog",  "machine_refused",  "transport_timeout",   "transport_connect",  "transport_closed",
        "protocol_invalid",  "protocol_mismatch"};
    return codes.contains(code);
}

class Soak {
  public:
    explicit Soak(const SoakOptions& options)
        : options_(options), part_(folder_ / "part.toml"), faults_(folder_ / "faults.toml") {
        write_part(part_);
        write_faults(options, faults_);
        machine_ = std::make_unique<SimulatedMachine>(
            part_, folder_,
            std::vector<std::string>{"--speed", std::to_string(options.speed), "--seed", std::to_string(options.seed),
                                     "--faults", faults_},
            endpoint(options.wire, folder_));
    }

    SoakResult run() {
        if (machine_->url().empty()) {
            result_.wrong.push_back("the simulator does not start: " + machine_->process().err());
            return result_;
        }
        while (hours() < options_.hours && result_.wrong.empty())
            job();
        result_.hours = hours();
        machine_->end();
        count_faults();
        const std::string lost = compare_samples(run_files_, machine_->log());
        if (!lost.empty()) result_.wrong.push_back(lost);
        return result_;
    }

  private:
    double hours() const {
        return std::chrono::duration<double, std::ratio<3600>>(std::chrono::steady_clock::now() - began_).count() *
               options_.speed;
    }

    /// One job to its end, however often it is interrupted.
    void job() {
        const std::string out = folder_ / ("job-" + std::to_string(++result_.jobs));
        const std::string run_file = out + "/run.cmmrun";
        largest_ = {};
        for (int again = 0; again <= most_resumes; ++again) {
            if (attempt(out, std::filesystem::exists(run_file))) {
                result_.host_at_its_largest.push_back(largest_);
                keep(run_file);
                return;
            }
            if (!result_.wrong.empty()) return;
            ++result_.resumes;
        }
        result_.wrong.push_back(out + " is not done after " + std::to_string(most_resumes) + " resumes");
    }

    bool attempt(const std::string& out, bool resume) {
        auto command = scan_command(*machine_, part_, out, resume);
        command.emplace_back("--json");
        Process process(command, folder_ / "scan");
        const auto end = std::chrono::steady_clock::now() + job_deadline;
        while (process.running() && std::chrono::steady_clock::now() < end) {
            wait_for([&] { return !process.running(); }, std::chrono::milliseconds(1000));
            watch(process);
        }
        if (process.running()) {
            result_.wrong.push_back(out + " hangs");
            return false;
        }
        const Finished run = process.wait(std::chrono::seconds(1));
        if (run.exit_code >= 0 && run.exit_code <= 2) return true;
        const auto document = nlohmann::json::parse(run.out, nullptr, false);
        const bool told = !document.is_discarded() && document.contains("error");
        const std::string code = told ? document["error"]["code"].get<std::string>() : "no error document";
        ++result_.endings[code];
        if (!may_end_with(code)) {
            result_.wrong.push_back(out + " ends with " + std::to_string(run.exit_code) + " " + code + ": " + run.err);
        }
        return false;
    }

    void watch(Process& host) {
        const Holdings simulator = holdings_of(machine_->process().pid(), hours());
        const Holdings now = holdings_of(host.pid(), hours());
        result_.simulator.push_back(simulator);
        if (now.memory_kb > largest_.memory_kb) largest_ = now;
        if (options_.watch_file.empty()) return;
        if (!csv_.is_open()) {
            csv_.open(options_.watch_file);
            csv_ << "machine_h,job,simulator_kb,simulator_files,host_kb,host_files\n";
        }
        csv_ << simulator.hours << ',' << result_.jobs << ',' << simulator.memory_kb << ',' << simulator.files << ','
             << now.memory_kb << ',' << now.files << std::endl;
    }

    /// The run file alone is needed at the end; the other files of a night's jobs would fill the disk.
    void keep(const std::string& run_file) {
        const std::string kept = folder_ / ("job-" + std::to_string(result_.jobs) + ".cmmrun");
        std::filesystem::rename(run_file, kept);
        std::filesystem::remove_all(std::filesystem::path(run_file).parent_path());
        run_files_.push_back(kept);
        const auto journal = acquisition::Journal::read(kept);
        if (!journal) return;
        if (const auto samples = (*journal)->samples()) result_.samples += samples->size();
    }

    void count_faults() {
        const std::string told = machine_->process().err();
        const std::regex fault("fault ([a-z_]+) after");
        for (std::sregex_iterator at(told.begin(), told.end(), fault), none; at != none; ++at)
            ++result_.faults[(*at)[1]];
    }

    SoakOptions options_;
    TemporaryFolder folder_;
    std::string part_, faults_;
    std::unique_ptr<SimulatedMachine> machine_;
    std::chrono::steady_clock::time_point began_ = std::chrono::steady_clock::now();
    std::vector<std::string> run_files_;
    Holdings largest_;
    std::ofstream csv_;
    SoakResult result_;
};

}  // namespace

SoakResult soak(const SoakOptions& options) {
    return Soak(options).run();
}

}  // namespace cmm::test
