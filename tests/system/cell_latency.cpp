// SPDX-License-Identifier: Apache-2.0
// How long a decision takes to a PLC: from the arrival of the sample that settled it (its host time in the run file) to
// the reply in which the PLC read it, and to WebSockets that hear the run. Simulator, cell and PLC are three processes
// on one host; the PLC asks every millisecond over Modbus TCP. Prints a table; built and run by hand:
//   cell_latency [bad parts] [good parts] [speed] [listeners]
#include <arpa/inet.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <span>
#include <stdexcept>
#include <thread>

#include "acquisition/journal.hpp"
#include "tests/support/process.hpp"
#include "tests/system/simulated_machine.hpp"
#include "tests/web/raw_client.hpp"

namespace cmm::test {
namespace {

using Steady = std::chrono::steady_clock;

std::int64_t now_ns() {
    return std::chrono::duration_cast<std::chrono::nanoseconds>(Steady::now().time_since_epoch()).count();
}

/// Writes heartbeat, command and program, reads registers 100 to 112: one exchange, function 23.
class Plc {
  public:
    explicit Plc(std::uint16_t port) : socket_(::socket(AF_INET, SOCK_STREAM, 0)) {
        sockaddr_in there{};
        there.sin_family = AF_INET;
        there.sin_port = htons(port);
        there.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        if (::connect(socket_, reinterpret_cast<const sockaddr*>(&there), sizeof there) != 0)
            throw std::runtime_error("the cell does not listen");
    }
    ~Plc() { ::close(socket_); }
    Plc(const Plc&) = delete;
    Plc& operator=(const Plc&) = delete;

    void exchange(unsigned command, unsigned program) {
        ++beat_;
        const auto high = [](unsigned word) { return static_cast<std::uint8_t>(word >> 8U & 0xFFU); };
        const auto low = [](unsigned word) { return static_cast<std::uint8_t>(word & 0xFFU); };
        const std::array<std::uint8_t, 23> request{0,
                                                   1,
                                                   0,
                                                   0,
                                                   0,
                                                   17,
                                                   1,
                                                   23,
                                                   0,
                                                   100,
                                                   0,
                                                   13,
                                                   0,
                                                   0,
                                                   0,
                                                   3,
                                                   6,
                                                   high(beat_),
                                                   low(beat_),
                                                   high(command),
                                                   low(command),
                                                   high(program),
                                                   low(program)};
        const auto asked = now_ns();
        ::send(socket_, request.data(), request.size(), MSG_NOSIGNAL);
        std::array<std::uint8_t, 9 + 26> reply{};
        for (std::size_t got = 0; got < reply.size();) {
            const auto more = ::recv(socket_, reply.data() + got, reply.size() - got, 0);
            if (more <= 0) throw std::runtime_error("the cell went away");
            got += static_cast<std::size_t>(more);
        }
        at_ns = now_ns();
        round_trips_ms.push_back(static_cast<double>(at_ns - asked) * 1e-6);
        for (std::size_t i = 0; i < words.size(); ++i)
            words[i] = static_cast<std::uint16_t>(reply[9 + 2 * i] << 8U | reply[10 + 2 * i]);
    }
    bool status(unsigned bit) const { return (words[4] & bit) != 0; }

    std::array<std::uint16_t, 13> words{};
    std::int64_t at_ns = 0;
    std::vector<double> round_trips_ms;

  private:
    int socket_;
    unsigned beat_ = 0;
};

struct PartTimes {
    std::int64_t rejected_ns = 0, done_ns = 0;  // read by the PLC
    unsigned run = 0, result = 0;
};

PartTimes measure(Plc& plc, unsigned program, const std::function<void(unsigned run)>& begun) {
    constexpr unsigned present = 1, start = 2, acknowledge = 8, ready = 1, busy = 2, done = 4;
    PartTimes times;
    const auto until = [&](unsigned command, unsigned bit, bool set) {
        const auto give_up = Steady::now() + std::chrono::seconds(120);
        do {
            plc.exchange(command, program);
            if (times.rejected_ns == 0 && plc.words[8] == 2) times.rejected_ns = plc.at_ns;
            if (Steady::now() > give_up) {
                throw std::runtime_error("nothing for two minutes, state " + std::to_string(plc.words[5]) +
                                         ", command " + std::to_string(command));
            }
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        } while (plc.status(bit) != set);
    };
    until(present, ready, true);
    until(present | start, busy, true);
    times.run = static_cast<unsigned>(plc.words[10]) << 16U | plc.words[11];
    begun(times.run);
    until(present, done, true);
    times.done_ns = plc.at_ns;
    times.result = plc.words[6];
    until(present | acknowledge, done, false);
    return times;
}

std::string folder_of(unsigned run) {
    std::array<char, 16> name{};
    std::snprintf(name.data(), name.size(), "%06u", run);
    return name.data();
}

/// A page that hears each run from its first event, on a thread of its own.
class Listener {
  public:
    explicit Listener(std::uint16_t port) : port_(port), thread_([this] { listen(); }) {}
    ~Listener() {
        ending_ = true;
        thread_.join();
    }
    Listener(const Listener&) = delete;
    Listener& operator=(const Listener&) = delete;

    void hear(unsigned run) { run_ = run; }
    /// When a rejection while measuring was heard, by run. After the end.
    std::map<unsigned, std::int64_t> heard() {
        const std::lock_guard guard(mutex_);
        return heard_;
    }

  private:
    void listen() {
        unsigned before = 0;
        while (!ending_) {
            const unsigned run = run_;
            web::test::RawClient page(port_);
            page.send(web::test::upgrade_request(port_, "/api/events?from=1&run=" + folder_of(run)));
            if (run == before || run == 0 || !page.answer().starts_with("HTTP/1.1 101")) {
                std::this_thread::sleep_for(std::chrono::milliseconds(5));
                continue;
            }
            before = run;
            follow(page, run);
        }
    }
    void follow(web::test::RawClient& page, unsigned run) {
        while (!ending_ && run_ == run) {
            const std::string lines = page.frame(std::chrono::milliseconds(500));
            const auto at = now_ns();
            if (lines.find("\"while_measuring\":true") != std::string::npos) {
                const std::lock_guard guard(mutex_);
                heard_.emplace(run, at);
            }
            if (lines.find("RunStopped") != std::string::npos) return;
        }
    }

    std::uint16_t port_;
    std::atomic<unsigned> run_{0};
    std::atomic<bool> ending_{false};
    std::mutex mutex_;
    std::map<unsigned, std::int64_t> heard_;
    std::thread thread_;
};

struct Deciding {
    std::int64_t rejected_ns = 0, last_ns = 0;  // arrival of the sample that settled a rejection, and of the last one
};

/// Of a run file: the first event that rejects a section carries the machine time of its newest sample.
Deciding deciding_samples(const std::string& file) {
    auto journal = acquisition::Journal::read(file);
    if (!journal) throw std::runtime_error(journal.error().text());
    double settled_s = -1.0;
    auto take = [&](std::uint64_t, std::string_view line) -> core::Status {
        const auto event = nlohmann::json::parse(line);
        if (settled_s < 0.0 && event.at("event") == "GateDecision" && event.at("decision") == "reject")
            settled_s = event.at("t_machine_s");
        return {};
    };
    Deciding found;
    auto look = [&](std::span<const core::Sample> samples) -> core::Status {
        for (const auto& sample : samples) {
            found.last_ns = std::max(found.last_ns, sample.host_time_ns);
            if (std::llround(settled_s * 1e6) == sample.machine_time_us) found.rejected_ns = sample.host_time_ns;
        }
        return {};
    };
    if (!(*journal)->each_event(1, take) || !(*journal)->each_batch(look)) throw std::runtime_error("unreadable");
    return found;
}

void print(const char* what, std::vector<double> times_ms) {
    if (times_ms.empty()) return;
    std::sort(times_ms.begin(), times_ms.end());
    const auto rank = [&](double share) {
        return times_ms[static_cast<std::size_t>(std::ceil(share * static_cast<double>(times_ms.size())) - 1.0)];
    };
    std::printf("%-62s n %6zu  p50 %8.2f  p99 %8.2f  max %8.2f ms\n", what, times_ms.size(), rank(0.5), rank(0.99),
                times_ms.back());
}

std::string text_of(const std::string& file) {
    std::ifstream in(file);
    return {std::istreambuf_iterator<char>(in), {}};
}

void run_all(int bad, int good, const std::string& speed, int listeners) {
    const TemporaryFolder folder;
    const std::string part = "tests/system/parts/fault-job.toml";
    std::string text = text_of(part);
    std::filesystem::create_directory(folder / "parts");
    const auto replace = [&](const std::string& from, const std::string& to) {
        text.replace(text.find(from), from.size(), to);
    };
    replace("pitch_mm = 1.0", "pitch_mm = 0.4");
    std::ofstream(folder / "parts/1.toml") << text;
    replace("thickness_root_mm = 6.0", "thickness_root_mm = 6.3");
    replace("thickness_tip_mm = 4.0", "thickness_tip_mm = 4.3");
    std::ofstream(folder / "parts/2.toml") << text;
    SimulatedMachine machine(part, folder, {"--speed", speed});
    Process cell({cmmlive(), "cell", "--machine", machine.url(), "--parts", folder / "parts", "--runs", folder / "runs",
                  "--plc", "modbus+tcp://127.0.0.1:0", "--stop-when-rejected", "--serve", "127.0.0.1:0", "--json"},
                 folder / "cell");
    wait_for([&] { return cell.out().find('\n') != std::string::npos || !cell.running(); });
    const auto printed = nlohmann::json::parse(cell.out());
    const auto port_in = [](const std::string& url) {
        return static_cast<std::uint16_t>(std::stoi(url.substr(url.find(':', url.find("//")) + 1)));
    };
    Plc plc(port_in(printed.at("plc")));
    std::vector<std::unique_ptr<Listener>> pages;
    for (int i = 0; i < listeners; ++i)
        pages.push_back(std::make_unique<Listener>(port_in(printed.at("page"))));
    const auto begun = [&](unsigned run) {
        for (const auto& page : pages)
            page->hear(run);
    };
    std::map<unsigned, std::int64_t> deciding;  // arrival, by run
    std::vector<double> rejected_ms, rejected_done_ms, accepted_done_ms;
    std::map<unsigned, unsigned> results;
    for (int i = 0; i < bad + good; ++i) {
        const bool is_bad = i < bad;
        PartTimes times;
        try {
            times = measure(plc, is_bad ? 2 : 1, begun);
        } catch (const std::exception&) {
            std::fprintf(stderr, "%s", cell.err().c_str());
            throw;
        }
        ++results[times.result];
        const auto samples = deciding_samples(folder / ("runs/" + folder_of(times.run) + "/run.cmmrun"));
        const auto ms = [](std::int64_t from, std::int64_t to) { return static_cast<double>(to - from) * 1e-6; };
        if (is_bad && times.rejected_ns != 0 && samples.rejected_ns != 0) {
            deciding[times.run] = samples.rejected_ns;
            rejected_ms.push_back(ms(samples.rejected_ns, times.rejected_ns));
            rejected_done_ms.push_back(ms(samples.last_ns, times.done_ns));
        }
        if (!is_bad) accepted_done_ms.push_back(ms(samples.last_ns, times.done_ns));
    }
    for (const auto& [result, number] : results)
        std::printf("result %u: %u parts\n", result, number);
    std::vector<double> heard_ms;
    for (const auto& page : pages)
        for (const auto& [run, at_ns] : page->heard())
            if (deciding.contains(run)) heard_ms.push_back(static_cast<double>(at_ns - deciding[run]) * 1e-6);
    std::printf("%d listeners\n", listeners);
    print("deciding sample to the PLC's reading of the rejection", rejected_ms);
    print("deciding sample to the WebSockets that hear the run", heard_ms);
    print("last sample to done, rejected (retract, release, record)", rejected_done_ms);
    print("last sample to done, accepted (the same, and all surfaces)", accepted_done_ms);
    print("the PLC's exchanges", plc.round_trips_ms);
    cell.signal(15);
    cell.wait(std::chrono::seconds(10));
}

}  // namespace
}  // namespace cmm::test

int main(int count, char** arguments) {
    const auto number = [&](int at, int fallback) { return count > at ? std::atoi(arguments[at]) : fallback; };
    try {
        cmm::test::run_all(number(1, 100), number(2, 20), count > 3 ? arguments[3] : "1", number(4, 0));
    } catch (const std::exception& error) {
        std::fprintf(stderr, "cell_latency: %s\n", error.what());
        return 1;
    }
    return 0;
}
