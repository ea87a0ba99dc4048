// SPDX-License-Identifier: Apache-2.0
#include "app/hand_commands.hpp"

#include <poll.h>
#include <unistd.h>

#include <array>
#include <string>
#include <utility>

#include "core/text.hpp"

namespace cmm::app {

HandCommands::HandCommands(std::function<void(drivers::HandSignal)> tell) : tell_(std::move(tell)) {
    thread_ = std::thread([this] { listen(); });
}

HandCommands::~HandCommands() {
    quit_.signal();
    thread_.join();
}

void HandCommands::listen() {
    std::string line;
    std::array<char, 256> bytes{};
    while (true) {
        std::array<pollfd, 2> watched{pollfd{STDIN_FILENO, POLLIN, 0}, pollfd{quit_.fd(), POLLIN, 0}};
        if (::poll(watched.data(), watched.size(), -1) < 0 || watched[1].revents != 0) return;
        const auto count = ::read(STDIN_FILENO, bytes.data(), bytes.size());
        if (count <= 0) return;
        for (const char c : std::string_view(bytes.data(), static_cast<std::size_t>(count))) {
            if (c != '\n') {
                line += c;
                continue;
            }
            if (core::trim(line).empty()) tell_(drivers::HandSignal::take_point);
            if (core::trim(line) == "e") tell_(drivers::HandSignal::end_section);
            line.clear();
        }
    }
}

}  // namespace cmm::app
