// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <boost/asio/awaitable.hpp>
#include <boost/asio/io_context.hpp>
#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/clock.hpp"
#include "drivers/registry.hpp"

namespace cmm::drivers::test {

/// Keeps every sample and checks that the sequence is gap-free. What counts as durable is up to the test.
class RecordingSink final : public SampleSink {
  public:
    core::Status on_samples(std::span<const core::Sample> samples) override {
        if (fail_at != 0 && delivered_ + samples.size() >= fail_at) {
            return core::fail(core::ErrorCode::journal_full, "the disk is full");
        }
        for (const auto& sample : samples) {
            if (sample.sequence != last + 1) out_of_order.push_back(sample.sequence);
            last = sample.sequence;
            kept.push_back(sample);
        }
        delivered_ += samples.size();
        if (immediately_durable) durable = last;
        if (on_delivery) on_delivery();
        return {};
    }
    std::uint64_t durable_sequence() const noexcept override { return durable; }
    core::Result<bool> hasten() override {
        ++hastened;
        if (durable_when_hastened) durable = last;
        return durable == last;
    }
    std::size_t delivered() const { return delivered_; }

    bool immediately_durable = true, durable_when_hastened = true;
    std::uint64_t last = 0, durable = 0;
    std::size_t fail_at = 0;  // 0: never
    int hastened = 0;
    std::vector<core::Sample> kept;
    std::vector<std::uint64_t> out_of_order;
    std::function<void()> on_delivery;

  private:
    std::size_t delivered_ = 0;
};

/// An operation that was started and may have ended.
template <class T>
struct Pending {
    std::optional<T> result;
    bool done() const { return result.has_value(); }
};

/// A machine and the event loop it lives on, turned by the test's own thread. What a Machine returns can be run, and
/// nothing else (machine_rig.cpp).
class MachineRig {
  public:
    explicit MachineRig(const LinkSettings& settings, std::uint64_t seed = 1);

    template <class T>
    std::shared_ptr<Pending<T>> start(boost::asio::awaitable<T> work);
    /// Turns the loop until the condition holds; false when it does not within the deadline.
    bool wait(const std::function<bool()>& condition, std::chrono::seconds deadline = std::chrono::seconds(20));
    template <class T>
    T run(boost::asio::awaitable<T> work);

  private:
    core::SystemClock clock_;
    boost::asio::io_context io_;

  public:
    std::unique_ptr<Machine> machine;  // after the loop: it goes first
};

inline LinkSettings settings_for(const std::string& url) {
    auto endpoint = Endpoint::parse(url);
    EXPECT_TRUE(endpoint) << endpoint.error().text();
    LinkSettings settings;
    if (endpoint) settings.endpoint = *endpoint;
    settings.reconnect_ms = 1500.0;
    return settings;
}

/// Ball centres on a circle about the z axis, counter-clockwise, once round.
inline std::vector<PathPoint> circle_path(double radius_mm, double z_mm, std::size_t count, double speed_mm_s) {
    std::vector<PathPoint> points(count);
    for (std::size_t k = 0; k < count; ++k) {
        const double angle = 2.0 * 3.141592653589793 * static_cast<double>(k) / static_cast<double>(count);
        points[k].normal = {std::cos(angle), std::sin(angle), 0.0};
        points[k].centre_mm = radius_mm * points[k].normal + Eigen::Vector3d(0.0, 0.0, z_mm);
        points[k].speed_mm_s = speed_mm_s;
    }
    return points;
}

}  // namespace cmm::drivers::test
