// SPDX-License-Identifier: Apache-2.0
#include "bench/peer_table.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <sstream>

#include "bench/bench.hpp"

namespace cmm::bench {
namespace {

namespace fs = std::filesystem;

constexpr double nanometre = 1e-6;

Peer run_peer(const std::string& name, const std::string& command) {
    Peer peer{name, {}, {}};
    std::FILE* pipe = ::popen((command + " 2>/dev/null").c_str(), "r");
    if (pipe == nullptr) return peer;
    std::array<char, 256> buffer{};
    while (std::fgets(buffer.data(), buffer.size(), pipe) != nullptr) {
        std::istringstream line(buffer.data());
        std::string task;
        line >> task;
        if (task == "version") std::getline(line >> std::ws, peer.version);
        peers::Times t;
        if (line >> t.low >> t.median >> t.high) peer.times[task] = t;
    }
    ::pclose(pipe);
    return peer;
}

}  // namespace

std::vector<Peer> run_peers(const std::string& folder, const std::string& script, const std::string& ending) {
    const fs::path here = fs::read_symlink("/proc/self/exe").parent_path();
    const fs::path path = here / "../../bench/peers" / script,
                   unpacked = here / "../peers/usr/lib/python3/dist-packages";
    std::vector<Peer> found;
    const auto take = [&](const std::string& name, const std::string& command, const std::string& how) {
        found.push_back(run_peer(name, command + " " + folder));
        if (found.back().times.empty()) {
            std::printf("%s: skipped, %s is not here\n", name.c_str(), how.c_str());
            found.pop_back();
        } else {
            std::printf("%s: %s\n", name.c_str(), found.back().version.c_str());
        }
    };
    take("fitpack", "PYTHONPATH=" + unpacked.string() + " /usr/bin/python3 " + path.string(), "python3-scipy");
    take("occt", (here / ("cmmlive_bench_occt" + ending)).string(), "libocct-modeling-algorithms-dev, -data-dev");
    take("sisl", (here / ("cmmlive_bench_sisl" + ending)).string(), "libsisl-dev");
    return found;
}

void PeerTable::task(const std::string& title, const std::string& name, const peers::Times& ours,
                     const std::string& quality, const std::string& target, const Judge& judge) const {
    print_ms(title, ours, target + "; " + quality);
    for (const Peer& peer : peers_)
        for (const auto& [done, times] : peer.times) {
            if (done.rfind(name, 0) != 0) continue;
            std::array<char, 32> ratio{};
            std::snprintf(ratio.data(), ratio.size(), "%.1f x; ", times.median / ours.median);
            print_ms("  " + peer.name + " " + done, times,
                     ratio.data() + judge(peers::numbers(folder_ + "/" + peer.name + "." + done)));
        }
}

void print_ms(const std::string& what, const peers::Times& t, const std::string& note) {
    print(what, {t.low, t.median, t.high}, "ms CPU", note);
}

std::string rms_and_max(const std::vector<double>& errors_mm) {
    double squares = 0.0, worst = 0.0;
    for (const double e : errors_mm) {
        squares += e * e;
        worst = std::max(worst, std::abs(e));
    }
    std::array<char, 64> text{};
    std::snprintf(text.data(), text.size(), "rms %.3f, max %.2f um",
                  1e3 * std::sqrt(squares / static_cast<double>(std::max<std::size_t>(1, errors_mm.size()))),
                  1e3 * worst);
    return text.data();
}

std::string farther_and_nearer(const std::vector<double>& distances_mm, const std::vector<double>& ours_mm) {
    std::size_t farther = 0, nearer = 0;
    const std::size_t count = std::min(distances_mm.size(), ours_mm.size());
    for (std::size_t i = 0; i < count; ++i) {
        farther += !(distances_mm[i] <= ours_mm[i] + nanometre);
        nearer += distances_mm[i] < ours_mm[i] - nanometre;
    }
    return std::to_string(farther) + " of " + std::to_string(count) + " farther than ours by 1 nm, " +
           std::to_string(nearer) + " nearer";
}

}  // namespace cmm::bench
