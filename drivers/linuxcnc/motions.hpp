// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <boost/asio/awaitable.hpp>
#include <string>

#include "drivers/linuxcnc/rsh_session.hpp"

namespace cmm::drivers::linuxcnc {

inline constexpr double arrived_mm = 0.02;  ///< the last servo cycles are still under way when the interpreter is idle

/// Motions by MDI commands, from making ready to seeing them end. For one operation at a time, on the session's
/// executor. Lengths in millimetres, machine frame. Errors say what is known about the motion.
class Motions {
  public:
    explicit Motions(RshSession& session) : session_(session) {}

    /// Ready for MDI: connected, in control, nothing stopped or moving, homed, in MDI mode, millimetres, no offsets but
    /// that of G54, which is looked up. Old messages are forgotten.
    boost::asio::awaitable<core::Status> prepare();
    /// What G54 adds: machine = program + offset.
    const Eigen::Vector3d& offset_mm() const noexcept { return offset_mm_; }
    /// Gives an MDI command. A link that breaks meanwhile is no error here: finish() looks on.
    boost::asio::awaitable<core::Status> give(std::string code);
    /// Waits until the interpreter is idle. Errors (the machine then stands, as far as can be seen): cancelled,
    /// machine_emergency, what LinuxCNC says, transport_*.
    boost::asio::awaitable<core::Status> finish(Messages& messages);
    /// Waits until a motion to this place has ended there, or somewhere else: where. The interpreter says idle also
    /// before the motion begins, on a busy host for some tenths of a second; so the machine must have stood for a while
    /// before a place short of the target counts. Errors: those of finish().
    boost::asio::awaitable<core::Result<Eigen::Vector3d>> arrive(Eigen::Vector3d target_mm, Messages& messages);
    /// Lets the interpreter print parameters, after the commands given before.
    boost::asio::awaitable<core::Status> ask_report(std::string parameters);
    /// What it printed since prepare(); asks again until it has been heard, for another user interface takes messages
    /// away from us. Errors: protocol_invalid, what LinuxCNC says.
    boost::asio::awaitable<core::Result<Report>> report(std::string parameters, Messages& messages);
    /// Asks until the machine stands. What is known otherwise.
    boost::asio::awaitable<core::Motion> standstill();
    /// Ends what is under way with the error, the machine told to abort.
    boost::asio::awaitable<core::Error> abandon(core::Error error);

  private:
    boost::asio::awaitable<core::Status> check_state();
    boost::asio::awaitable<core::Status> set_up_interpreter();
    boost::asio::awaitable<core::Error> halt();
    bool heard(const Messages& messages) const { return messages.report && messages.report->tag >= oldest_question_; }

    RshSession& session_;
    Eigen::Vector3d offset_mm_ = Eigen::Vector3d::Zero();
    bool rotation_checked_ = false;
    std::uint32_t question_ = 0;         // number of the report asked for last
    std::uint32_t oldest_question_ = 1;  // reports with smaller numbers are of another operation
};

}  // namespace cmm::drivers::linuxcnc
