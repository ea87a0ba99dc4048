// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <boost/asio/co_spawn.hpp>
#include <boost/asio/io_context.hpp>
#include <chrono>
#include <exception>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/clock.hpp"
#include "drivers/registry.hpp"
#include "sim/simulator.hpp"

/// What the measurements of links share: a simulated machine with a prism on it, and a host that scans it.
namespace cmm::bench {

using SteadyClock = std::chrono::steady_clock;

/// A simulator that goes as fast as it can.
class LinkSimulator {
  public:
    /// Throws std::runtime_error when it does not start.
    LinkSimulator(const std::string& config_folder, const std::vector<sim::Listen>& listen,
                  std::function<void()> on_stop = {});
    ~LinkSimulator();
    LinkSimulator(const LinkSimulator&) = delete;
    LinkSimulator& operator=(const LinkSimulator&) = delete;
    const sim::Simulator& machine() const { return *simulator_; }

  private:
    std::filesystem::path folder_;
    std::unique_ptr<sim::Simulator> simulator_;
};

sim::Listen on_serial(sim::Listen::Kind kind, const std::string& port);

/// Ball centres round the prism, again and again, until there are so many.
std::vector<drivers::PathPoint> ring(std::size_t count, double start_rad = 0.0);

/// Notes when samples come, and keeps none.
class CountingSink final : public drivers::SampleSink {
  public:
    core::Status on_samples(std::span<const core::Sample> samples) override;
    std::uint64_t durable_sequence() const noexcept override { return keeps ? last : 0; }
    core::Result<bool> hasten() override { return true; }
    /// Samples a second from the first delivery to the last.
    double rate() const;
    double seconds() const { return std::chrono::duration<double>(ended - begun).count(); }

    bool keeps = true;                   ///< false: nothing is ever acknowledged
    std::uint64_t give_up = 0;           ///< an error after so many; 0: never
    std::function<void()> first, every;  ///< called with the first delivery; with each
    std::uint64_t last = 0, count = 0, first_count = 0;
    SteadyClock::time_point begun{}, ended{};
};

/// A host with one machine and the loop it lives on. What fails throws std::runtime_error with the error's text.
class LinkHost {
  public:
    explicit LinkHost(const std::string& url, std::uint64_t seed = 1);

    template <class T>
    T run(boost::asio::awaitable<T> work) {
        std::optional<T> result;
        boost::asio::co_spawn(io_, std::move(work), [&](const std::exception_ptr& thrown, T value) {
            if (thrown) std::rethrow_exception(thrown);
            result = std::move(value);
        });
        io_.restart();
        io_.run();
        return std::move(*result);
    }
    /// The same for what has to succeed.
    template <class T>
    T must(boost::asio::awaitable<core::Result<T>> work) {
        auto result = run(std::move(work));
        if (!result) throw std::runtime_error(result.error().text());
        return std::move(*result);
    }
    void must(boost::asio::awaitable<core::Status> work);

    /// Connects, takes the machine and brings the ball beside the prism.
    void bring_up();
    core::Result<drivers::ScanResult> scan(const std::vector<drivers::PathPoint>& path, drivers::SampleSink& sink);

    drivers::Machine& machine() { return *machine_; }
    boost::asio::io_context& io() { return io_; }

  private:
    core::SystemClock clock_;
    boost::asio::io_context io_;
    std::unique_ptr<drivers::Machine> machine_;  // after the loop: it goes first
};

}  // namespace cmm::bench
