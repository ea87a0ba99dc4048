// SPDX-License-Identifier: Apache-2.0
#include "machine_rig.hpp"

#include <boost/asio/co_spawn.hpp>
#include <exception>
#include <stdexcept>
#include <utility>

namespace cmm::drivers::test {

MachineRig::MachineRig(const LinkSettings& settings, std::uint64_t seed) {
    auto made = standard_registry().make(settings, {io_.get_executor(), clock_, seed});
    if (made) machine = std::move(*made);
    EXPECT_TRUE(made) << made.error().text();
}

template <class T>
std::shared_ptr<Pending<T>> MachineRig::start(boost::asio::awaitable<T> work) {
    auto pending = std::make_shared<Pending<T>>();
    boost::asio::co_spawn(io_, std::move(work), [pending](std::exception_ptr failure, T value) {
        if (failure) std::rethrow_exception(failure);
        pending->result = std::move(value);
    });
    return pending;
}

bool MachineRig::wait(const std::function<bool()>& condition, std::chrono::seconds deadline) {
    const auto end = std::chrono::steady_clock::now() + deadline;
    io_.restart();
    while (!condition()) {
        if (std::chrono::steady_clock::now() >= end) return false;
        io_.run_one_for(std::chrono::milliseconds(20));
        if (io_.stopped()) io_.restart();
    }
    return true;
}

template <class T>
T MachineRig::run(boost::asio::awaitable<T> work) {
    auto pending = start(std::move(work));
    const bool ended = wait([&] { return pending->done(); });
    if (!ended) throw std::runtime_error("the operation did not end within its deadline");
    return std::move(*pending->result);
}

// Once here rather than in every test.
#define CMM_RUNS(T)                                                                    \
    template std::shared_ptr<Pending<T>> MachineRig::start(boost::asio::awaitable<T>); \
    template T MachineRig::run(boost::asio::awaitable<T>)
CMM_RUNS(core::Status);
CMM_RUNS(core::Result<Capabilities>);
CMM_RUNS(core::Result<Eigen::Vector3d>);
CMM_RUNS(core::Result<MachineStatus>);
CMM_RUNS(core::Result<RunOrigin>);
CMM_RUNS(core::Result<ScanResult>);
CMM_RUNS(core::Result<std::uint64_t>);
#undef CMM_RUNS

}  // namespace cmm::drivers::test
