// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "drivers/controller/port.hpp"
#include "drivers/registry.hpp"

namespace cmm::drivers::line {

/// The line protocol (docs/protocol-line.md) as a port, on a thread of its own: each question carries a tag and is
/// repeated under it until it is answered; a stop goes out beside it.
class LinePort final : public controller::Port {
  public:
    LinePort(const LinkSettings& settings, const DriverContext& context);
    ~LinePort() override;

    boost::asio::awaitable<core::Result<Capabilities>> open() override;
    boost::asio::awaitable<core::Status> run(controller::Round& round) override;
    boost::asio::awaitable<void> pause(double ms) override;
    std::size_t window_limit() const noexcept override;
    core::Status check_point(const PathPoint& point, std::uint64_t index, double lsb_mm) const override;
    std::uint32_t unwrapped_passed(std::uint32_t value, std::uint32_t) const noexcept override { return value; }
    double status_every_ms() const noexcept override { return 200.0; }
    bool opened() const noexcept override;
    double now_ms() const noexcept override;
    double last_answer_ms() const noexcept override;
    void stop(StopKind kind) noexcept override;
    LinkStats stats() const override;
    void count(const std::function<void(LinkStats&)>& change) override;
    void set_trace(std::function<void(std::string_view)> line) override;

  private:
    class Impl;
    std::unique_ptr<Impl> impl_;
};

/// Makes a machine behind `line+serial://` without connecting. Errors: usage (a pty to be made).
core::Result<std::unique_ptr<Machine>> make_line_machine(const LinkSettings& settings, const DriverContext& context);

}  // namespace cmm::drivers::line
