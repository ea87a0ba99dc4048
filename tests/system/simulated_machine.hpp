// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "tests/support/process.hpp"

namespace cmm::test {

/// `cmmlive sim` as a process of its own, on a free port unless told otherwise.
class SimulatedMachine {
  public:
    SimulatedMachine(const std::string& part, const TemporaryFolder& folder, const std::vector<std::string>& more = {},
                     const std::string& listen = "modbus+tcp://127.0.0.1:0") {
        std::vector<std::string> arguments{cmmlive(),  "sim",  "--part", part,
                                           "--listen", listen, "--log",  log_ = folder / "sim-log.csv"};
        arguments.insert(arguments.end(), more.begin(), more.end());
        process_ = std::make_unique<Process>(arguments, folder / "sim");
        const bool up =
            wait_for([&] { return process_->out().find('\n') != std::string::npos || !process_->running(); });
        const std::string line = process_->out();
        const auto at = line.find(listen.substr(0, listen.find("://") + 3));
        if (up && at != std::string::npos) url_ = line.substr(at, line.find_first_of(" \n", at) - at);
    }
    const std::string& url() const { return url_; }
    const std::string& log() const { return log_; }
    Process& process() { return *process_; }
    /// Asks it to end, so that its log is complete.
    Finished end() {
        process_->signal(15);
        return process_->wait(std::chrono::seconds(10));
    }

  private:
    std::string log_, url_;
    std::unique_ptr<Process> process_;
};

}  // namespace cmm::test
