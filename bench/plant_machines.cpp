// SPDX-License-Identifier: Apache-2.0
#include "bench/plant_machines.hpp"

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <memory>
#include <stdexcept>

#include "sim/simulator.hpp"

namespace cmm::bench {
namespace {

using Pipe = std::array<int, 2>;  // to read from, to write to

Pipe make_pipe() {
    Pipe pipe{};
    if (::pipe2(pipe.data(), O_CLOEXEC) != 0) throw std::runtime_error("no pipe");
    return pipe;
}

double seconds(const timeval& time) {
    return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

/// In the child: tells the URLs, or the error in their place, and waits until it is let go.
void serve(const sim::SimulatorOptions& wanted, const std::filesystem::path& logs, std::size_t count, int told,
           int hold) {
    std::vector<std::unique_ptr<sim::Simulator>> machines;
    std::string text;
    for (std::size_t k = 0; k < count; ++k) {
        auto options = wanted;
        options.seed = k + 1;
        options.log_file = PlantMachines::log_of(logs, k);
        auto machine = sim::Simulator::start(options);
        text += (machine ? (*machine)->url() : machine.error().text()) + "\n";
        if (!machine) break;
        machines.push_back(std::move(*machine));
    }
    if (::write(told, text.data(), text.size()) != static_cast<ssize_t>(text.size())) return;
    ::close(told);
    char end = 0;
    static_cast<void>(::read(hold, &end, 1) == 0);
}

}  // namespace

PlantMachines::PlantMachines(const std::string& config_folder, const std::string& part_file,
                             const std::filesystem::path& logs, std::size_t count) {
    sim::SimulatorOptions options;
    options.part_file = part_file;
    options.machine_file = config_folder + "/machines/sim.toml";
    options.map_file = config_folder + "/maps/cmm-v1.toml";
    const Pipe told = make_pipe();
    const Pipe hold = make_pipe();
    std::fflush(nullptr);
    process_ = ::fork();
    if (process_ < 0) throw std::runtime_error("no process for the machines");
    if (process_ == 0) {
        ::close(told[0]);
        ::close(hold[1]);
        serve(options, logs, count, told[1], hold[0]);
        ::_exit(0);
    }
    ::close(told[1]);
    ::close(hold[0]);
    hold_ = hold[1];
    const std::unique_ptr<std::FILE, int (*)(std::FILE*)> lines(::fdopen(told[0], "r"), &std::fclose);
    std::array<char, 512> line{};
    while (std::fgets(line.data(), line.size(), lines.get()) != nullptr) {
        urls_.emplace_back(line.data());
        urls_.back().pop_back();
    }
    if (urls_.size() == count && urls_.back().starts_with("modbus")) return;
    end();
    throw std::runtime_error(urls_.empty() ? "the machines did not start" : urls_.back());
}

PlantMachines::~PlantMachines() {
    end();
}

std::filesystem::path PlantMachines::log_of(const std::filesystem::path& logs, std::size_t machine) {
    return logs / ("machine-" + std::to_string(machine) + ".csv");
}

PlantMachines::Cost PlantMachines::end() {
    if (process_ < 0) return {};
    ::close(hold_);
    rusage used{};
    int status = 0;
    ::wait4(process_, &status, 0, &used);
    process_ = -1;
    return {seconds(used.ru_utime) + seconds(used.ru_stime), static_cast<double>(used.ru_maxrss) / 1024.0};
}

}  // namespace cmm::bench
