// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "bench/peers/problem.hpp"

/// Peers' programs run on the files of a folder, and their results beside ours.
namespace cmm::bench {

struct Peer {
    std::string name, version;
    std::map<std::string, peers::Times> times;
};

/// Runs FITPACK (the script in bench/peers), Open CASCADE and SISL (cmmlive_bench_occt, _sisl with `ending`); says
/// which are not here.
std::vector<Peer> run_peers(const std::string& folder, const std::string& script, const std::string& ending);

/// One task: our own time and quality, then every peer's that has done it, with its time as a multiple of ours.
class PeerTable {
  public:
    /// What a peer wrote becomes a word on its quality.
    using Judge = std::function<std::string(const std::vector<double>&)>;

    PeerTable(const std::vector<Peer>& all, std::string folder) : peers_(all), folder_(std::move(folder)) {}
    void task(const std::string& title, const std::string& name, const peers::Times& ours, const std::string& quality,
              const std::string& target, const Judge& judge) const;

  private:
    const std::vector<Peer>& peers_;
    std::string folder_;
};

void print_ms(const std::string& what, const peers::Times& times, const std::string& note);
std::string rms_and_max(const std::vector<double>& errors_mm);
/// How many of a peer's distances are farther, and nearer, than ours by more than a nanometre.
std::string farther_and_nearer(const std::vector<double>& distances_mm, const std::vector<double>& ours_mm);

}  // namespace cmm::bench
