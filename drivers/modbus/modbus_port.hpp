// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <boost/asio/awaitable.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <boost/asio/steady_timer.hpp>
#include <span>
#include <vector>

#include "core/rng.hpp"
#include "drivers/controller/port.hpp"
#include "drivers/modbus/blocks.hpp"
#include "drivers/modbus/bus.hpp"
#include "drivers/modbus/in_flight.hpp"
#include "drivers/registry.hpp"

namespace cmm::drivers::modbus {

/// The bus as a port: rounds as transactions of registers, with the only retry of this driver. Every exchange of the
/// protocol may be repeated (commands by their sequence, windows by their index, samples by from_seq), so all are. A
/// broken link is opened again, and only goes on with the same start of the same controller. Used on one executor.
class ModbusPort final : public controller::Port {
  public:
    ModbusPort(const LinkSettings& settings, RegisterMap map, const DriverContext& context);

    boost::asio::awaitable<core::Result<Capabilities>> open() override;
    boost::asio::awaitable<core::Status> run(controller::Round& round) override;
    boost::asio::awaitable<void> pause(double ms) override;
    std::size_t window_limit() const noexcept override { return window_points(map_); }
    controller::Reach reach() const noexcept override { return {in_flight_.allowed(), block_samples(map_)}; }
    core::Status check_point(const PathPoint& point, std::uint64_t index, double lsb_mm) const override {
        return controller::check_point(point, index, lsb_mm, map_.scale.speed_mm_s);
    }
    std::uint32_t unwrapped_passed(std::uint32_t value, std::uint32_t near) const noexcept override {
        return RegisterMap::unwrapped(map_.status.path_recorded, value, near);
    }
    double status_every_ms() const noexcept override;
    bool opened() const noexcept override { return opened_; }
    double now_ms() const noexcept override { return core::seconds(clock_.now()) * 1e3; }
    double last_answer_ms() const noexcept override { return last_answer_ms_; }
    void stop(StopKind kind) noexcept override { bus_.stop(kind); }
    LinkStats stats() const override { return bus_.stats(); }
    void count(const std::function<void(LinkStats&)>& change) override { bus_.count(change); }
    void set_trace(std::function<void(std::string_view)> line) override { bus_.set_trace(std::move(line)); }

  private:
    /// What became of several requests in flight.
    struct Batch {
        std::size_t sent = 0, answered = 0;
        std::uint64_t stale_before = 0;
    };
    boost::asio::awaitable<void> acquire();
    void release();
    boost::asio::awaitable<void> job_done();
    boost::asio::awaitable<core::Status> verify();
    boost::asio::awaitable<core::Status> attempt(std::size_t in_flight);
    boost::asio::awaitable<core::Result<Capabilities>> read_identity();
    void weigh_batch();
    void weigh_half_answered();
    void conclude(const Batch& batch);
    core::Status judge();
    core::Status judge(Transaction& transaction);
    void drop_what_was_sent_ahead();
    boost::asio::awaitable<core::Status> repeat();
    void prepare(const controller::Round& round);
    void settle(controller::Round& round) const;
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
    double lsb_mm_ = 0.0;
    InFlight in_flight_;
    Batch half_answered_;  // in the present round; nothing sent: none
    Transaction identity_, command_, status_;
    std::vector<Transaction> windows_, exchanges_;  // as many as may be in flight
    Transaction* identity_batch_[1] = {&identity_};
    std::vector<Transaction*> open_;  // those of the present batch that are not answered yet
    Bus bus_;
    boost::asio::posix::stream_descriptor done_;
};

}  // namespace cmm::drivers::modbus
