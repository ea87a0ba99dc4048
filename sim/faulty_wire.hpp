// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <deque>
#include <memory>
#include <vector>

#include "sim/fault_play.hpp"
#include "sim/wire_protocol.hpp"

namespace cmm::sim {

/// A bad wire in front of a protocol: requests and replies pass through it, and what the fault plan says happens to
/// their bytes. It knows where a message ends from the protocol behind it, and its framing only where a fault is about
/// it. Lives not longer than `play`.
class FaultyWire final : public WireProtocol {
  public:
    enum class Kind : std::uint8_t { tcp, rtu, line };
    FaultyWire(Kind kind, std::unique_ptr<WireProtocol> behind, FaultPlay& play);

    Progress answer(std::span<const std::uint8_t> in, core::Duration silent_for,
                    std::vector<std::uint8_t>& out) override;
    void arrived(std::vector<std::uint8_t>& bytes) override;
    Progress idle(std::vector<std::uint8_t>& out) override;

  private:
    using Bytes = std::vector<std::uint8_t>;
    bool serial() const { return kind_ != Kind::tcp; }
    Progress meet(const Fault& fault, Bytes reply, std::size_t used);
    void send(Bytes bytes, double after_ms = 0.0);
    void send_with_kept(Bytes reply);
    /// Makes it the reply of another unit, where the framing has a name for one.
    void rename(Bytes& reply) const;
    void flush(Bytes& out);

    struct Sending {
        core::Duration due;
        Bytes bytes;
    };
    Kind kind_;
    std::unique_ptr<WireProtocol> behind_;
    FaultPlay& play_;
    unsigned generation_;
    std::deque<Sending> under_way_;
    Bytes last_reply_;
    Bytes kept_;  // for the reply after it
    bool kept_goes_last_ = false;
    bool forgotten_ = false;  // the device does not know this connection any more
};

}  // namespace cmm::sim
