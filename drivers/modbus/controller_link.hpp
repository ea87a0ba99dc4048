// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <boost/asio/awaitable.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <boost/asio/steady_timer.hpp>
#include <span>
#include <vector>

#include "core/rng.hpp"
#include "drivers/modbus/blocks.hpp"
#include "drivers/modbus/bus.hpp"
#include "drivers/registry.hpp"

namespace cmm::drivers::modbus {

/// The bus as coroutines: transactions of several users one after another, with the only retry of this driver. Every
/// exchange of the protocol may be repeated (commands by their sequence, windows by their index, samples by from_seq),
/// so all are. A broken link is opened again, and only goes on with the same start of the same controller. Used on one
/// executor.
class ControllerLink {
  public:
    ControllerLink(const LinkSettings& settings, RegisterMap map, const DriverContext& context);

    /// One attempt to connect and to read the identity. Errors: transport_*, protocol_*.
    boost::asio::awaitable<core::Result<Capabilities>> open();
    /// Runs the transactions in order until each is answered, by what was asked for or by an exception (see `outcome`).
    /// Errors: transport_*, protocol_invalid after `reconnect_ms` of trying; machine_fault: the controller was
    /// restarted.
    boost::asio::awaitable<core::Status> transact(std::span<Transaction* const> batch);
    boost::asio::awaitable<core::Status> transact(Transaction& transaction);
    boost::asio::awaitable<void> pause(double ms);

    Bus& bus() noexcept { return bus_; }
    const Bus& bus() const noexcept { return bus_; }
    const RegisterMap& map() const noexcept { return map_; }
    bool opened() const noexcept { return opened_; }
    double now_ms() const noexcept { return core::seconds(clock_.now()) * 1e3; }
    /// When the controller last answered, in the time of now_ms().
    double last_answer_ms() const noexcept { return last_answer_ms_; }

  private:
    boost::asio::awaitable<void> acquire();
    void release();
    boost::asio::awaitable<void> job_done();
    boost::asio::awaitable<core::Status> verify();
    boost::asio::awaitable<core::Status> attempt();
    boost::asio::awaitable<core::Result<Capabilities>> read_identity();
    core::Status judge();
    double timeout_for(double watchdog_ms) const;
    core::Status check_speed(double watchdog_ms) const;

    RegisterMap map_;
    double reconnect_ms_;
    double settings_timeout_ms_;
    double timeout_ms_;  // never so long that one lost reply lets the watchdog run out
    std::string where_;
    const core::Clock& clock_;
    core::Rng rng_;
    boost::asio::any_io_executor executor_;
    boost::asio::steady_timer turn_;  // cancelled when the bus is free again
    bool taken_ = false;
    bool opened_ = false;
    std::uint32_t boot_id_ = 0;
    std::uint64_t link_number_ = 0;  // of the link whose identity was read
    int timeouts_in_row_ = 0;
    std::uint16_t watchdog_ = 0;
    double last_answer_ms_ = 0.0;
    Transaction identity_;
    Transaction* identity_batch_[1] = {&identity_};
    std::vector<Transaction*> open_;  // those of the present batch that are not answered yet
    Bus bus_;
    boost::asio::posix::stream_descriptor done_;
};

}  // namespace cmm::drivers::modbus
