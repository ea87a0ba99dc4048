// SPDX-License-Identifier: Apache-2.0
#include "app/stop_signals.hpp"

#include <csignal>
#include <utility>

namespace cmm::app {

StopSignals::StopSignals(std::function<void()> first, std::function<void()> again)
    : next_(std::move(first)), again_(std::move(again)), signals_(context_, SIGINT, SIGTERM) {
    wait();
    thread_ = std::thread([this] { context_.run(); });
}

StopSignals::~StopSignals() {
    context_.stop();
    thread_.join();
}

void StopSignals::wait() {
    signals_.async_wait([this](const boost::system::error_code& code, int) {
        if (code) return;
        std::exchange(next_, again_)();
        wait();
    });
}

}  // namespace cmm::app
