// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <initializer_list>
#include <span>
#include <vector>

#include "sim/scan_path.hpp"
#include "tests/sim/served_bar.hpp"

namespace cmm::sim::test {

/// A host of a few lines on the raw wire, for the repository's register map: what a test needs to run a scan over TCP.
class WireClient {
  public:
    explicit WireClient(std::uint16_t port) : raw_(port) {}

    std::vector<std::uint16_t> read(std::uint16_t address, std::uint16_t count);
    /// FC 16; the exception code, 0 when taken.
    int write(std::uint16_t address, const std::vector<std::uint16_t>& registers);
    /// The FC 23 of the document; 125 registers.
    std::vector<std::uint16_t> exchange(std::uint32_t ack, std::uint32_t from = 0);
    /// Sends a command and waits for its end, feeding the watchdog; its result code.
    int run(std::uint16_t opcode, std::initializer_list<std::int32_t> args = {});
    void start(std::uint16_t opcode, std::initializer_list<std::int32_t> args);
    int finish();
    /// Claims, homes, qualifies the ball.
    void prepare(double ball_radius_mm);
    /// One window; the exception code.
    int send_window(std::uint16_t id, std::uint32_t first, std::span<const PathPoint> points);

  private:
    std::vector<std::uint8_t> ask(const std::vector<std::uint8_t>& pdu, std::size_t reply_size);
    RawClient raw_;
    std::uint16_t transaction_ = 0;
    std::uint16_t seq_ = 0;
    std::uint16_t watchdog_ = 0;
};

/// The path of a ball once around a section at height z, found by walking along the surface with steps of `step_mm`.
std::vector<PathPoint> walk_around(const Surface& surface, double z_mm, double radius_mm, double step_mm,
                                   double speed_mm_s);

}  // namespace cmm::sim::test
