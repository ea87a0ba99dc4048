// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

namespace cmm::bench {

/// Simulated machines in one process of their own, each a thread and a TCP port, at real time: what they cost is not
/// the host's. Begin it while this process has one thread.
class PlantMachines {
  public:
    /// Throws std::runtime_error when they do not start.
    PlantMachines(const std::string& config_folder, const std::string& part_file, const std::filesystem::path& logs,
                  std::size_t count);
    ~PlantMachines();
    PlantMachines(const PlantMachines&) = delete;
    PlantMachines& operator=(const PlantMachines&) = delete;

    const std::vector<std::string>& urls() const { return urls_; }
    /// What a machine has recorded in truth; complete after end().
    static std::filesystem::path log_of(const std::filesystem::path& logs, std::size_t machine);

    struct Cost {
        double cpu_s = 0.0, memory_mb = 0.0;
    };
    /// Ends them; a second call does nothing.
    Cost end();

  private:
    pid_t process_ = -1;
    int hold_ = -1;  // the machines run until it is closed
    std::vector<std::string> urls_;
};

}  // namespace cmm::bench
