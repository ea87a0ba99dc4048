// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "sim/controller.hpp"
#include "sim/line_codec.hpp"
#include "sim/wire_protocol.hpp"

namespace cmm::sim {

/// The controller behind the line protocol (docs/protocol-line.md). A line that is no command, or whose CRC does not
/// fit, is not answered. Lives on the controller's thread and not longer than it.
class LineProtocol final : public WireProtocol {
  public:
    static constexpr std::size_t points_per_line = 10;
    static constexpr std::size_t most_samples = 64;  ///< of one frame

    explicit LineProtocol(Controller& controller) : controller_(controller) {}
    Progress answer(std::span<const std::uint8_t> in, core::Duration silent_for,
                    std::vector<std::uint8_t>& out) override;

  private:
    using Numbers = std::vector<std::int64_t>;
    /// What goes back: values with '=', or a code with '!'.
    struct Outcome {
        char mark = '=';
        std::string text;
    };
    void carry_out(const LineCommand& command, std::vector<std::uint8_t>& out);
    Outcome reply_to(const LineCommand& command);
    Outcome give_command(const LineCommand& command);
    Outcome take_points(const Numbers& numbers);
    bool exchange(const LineCommand& command, std::vector<std::uint8_t>& out);
    std::string identity() const;
    std::string status() const;
    std::vector<std::uint8_t> frame(std::uint16_t tag, std::uint32_t from, std::size_t most) const;

    Controller& controller_;
};

}  // namespace cmm::sim
