// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/signal_set.hpp>
#include <functional>
#include <thread>

namespace cmm::app {

/// SIGINT and SIGTERM for as long as it lives, on a thread of its own, so that they are heard whatever the run is
/// busy with: `first` at the first of them, `again` at each later one. What they use outlives this object.
class StopSignals {
  public:
    StopSignals(std::function<void()> first, std::function<void()> again);
    ~StopSignals();
    StopSignals(const StopSignals&) = delete;
    StopSignals& operator=(const StopSignals&) = delete;

  private:
    void wait();

    std::function<void()> next_, again_;
    boost::asio::io_context context_;
    boost::asio::signal_set signals_;
    std::thread thread_;
};

}  // namespace cmm::app
