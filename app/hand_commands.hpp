// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <thread>

#include "drivers/event_fd.hpp"
#include "drivers/machine.hpp"

namespace cmm::app {

/// What a person types while points are taken by hand, a line each, for as long as it lives, on a thread of its own:
/// an empty line asks for a point, "e" ends the section. Without a standard input there is nothing to hear.
class HandCommands {
  public:
    explicit HandCommands(std::function<void(drivers::HandSignal)> tell);
    ~HandCommands();
    HandCommands(const HandCommands&) = delete;
    HandCommands& operator=(const HandCommands&) = delete;

  private:
    void listen();

    std::function<void(drivers::HandSignal)> tell_;
    drivers::EventFd quit_;
    std::thread thread_;
};

}  // namespace cmm::app
