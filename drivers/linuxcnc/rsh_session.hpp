// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <atomic>
#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/awaitable.hpp>
#include <optional>
#include <string>

#include "drivers/linuxcnc/rsh_link.hpp"
#include "drivers/registry.hpp"

namespace cmm::drivers::linuxcnc {

/// Between two looks at what is waited for.
inline constexpr double look_every_ms = 10.0;

/// The controller at one moment.
struct Look {
    bool estop = false, machine_on = false, idle = false;
};

/// What LinuxCNC had to say meanwhile.
struct Messages {
    std::string error;  ///< the first one; empty: none
    std::optional<Report> report;
};

core::Error emergency_error();

/// The conversation with one LinuxCNC: questions (tried again over a new connection), settings, messages, stops. Used
/// on one executor, by one operation at a time but for the questions; stop() from any thread. Lengths in millimetres,
/// machine frame.
class RshSession {
  public:
    RshSession(const LinkSettings& settings, const DriverContext& context);

    /// Connects; takes no control and changes nothing.
    boost::asio::awaitable<core::Status> open();
    /// The one connection that may command; LinuxCNC gives it to whoever asked last.
    boost::asio::awaitable<core::Status> take_control();
    boost::asio::awaitable<core::Status> give_control_back();
    bool in_control() const noexcept { return in_control_; }

    /// Errors: transport_*, protocol_*, both only after the time for reconnecting has passed.
    boost::asio::awaitable<core::Result<std::string>> get(std::string what);
    boost::asio::awaitable<core::Result<bool>> get_switch(std::string what);
    boost::asio::awaitable<core::Result<Eigen::Vector3d>> position_mm(std::string what);
    boost::asio::awaitable<core::Result<Look>> look();
    boost::asio::awaitable<core::Result<bool>> homed();
    /// Once: what was lost may have been carried out. Errors: machine_* with the reason when it is refused.
    boost::asio::awaitable<core::Status> set(std::string what);
    /// Sets what may be set again, and waits until GET says so.
    boost::asio::awaitable<core::Status> set_switch(std::string what, bool on, core::ErrorCode failure);
    boost::asio::awaitable<core::Status> set_mode(std::string mode);

    /// Reads what waits in LinuxCNC's queue of messages.
    boost::asio::awaitable<core::Status> collect(Messages& messages);

    void stop(StopKind kind) noexcept;
    /// 0 none, 1 controlled, 2 emergency: since it was forgotten last.
    int stop_asked() const noexcept { return stop_asked_; }
    void forget_stop() noexcept { stop_asked_ = 0; }

    boost::asio::awaitable<void> pause(double ms);
    double now_ms() const noexcept;
    LinkLog& log() noexcept { return link_.log(); }
    const LinkLog& log() const noexcept { return link_.log(); }

  private:
    boost::asio::awaitable<core::Status> relink();
    boost::asio::awaitable<core::Status> claim();
    boost::asio::awaitable<core::Status> connect();
    boost::asio::awaitable<core::Result<Reply>> ask(std::string line);
    boost::asio::awaitable<core::Error> refusal(std::string what);

    LinkSettings settings_;
    const core::Clock& clock_;
    boost::asio::any_io_executor executor_;
    double unit_mm_ = 1.0;  // of positions
    bool known_ = false;    // connected before
    std::atomic<bool> in_control_{false};
    bool relinking_ = false;
    std::atomic<int> stop_asked_{0};
    RshLink link_;
};

}  // namespace cmm::drivers::linuxcnc
