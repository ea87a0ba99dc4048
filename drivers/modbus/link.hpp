// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

namespace cmm::drivers::modbus {

/// What a link found when it was asked what has arrived. The spans live until the next call of the link.
struct Arrival {
    enum class Kind : std::uint8_t {
        nothing,  ///< no whole reply yet
        reply,
        garbled,  ///< bytes that are no reply: the link needs resync()
        broken,   ///< the link is gone
    };
    Kind kind = Kind::nothing;
    std::uint16_t id = 0;                 ///< of the request that a reply belongs to, as far as the framing tells
    std::span<const std::uint8_t> pdu;    ///< of a reply, from the function code on
    std::span<const std::uint8_t> bytes;  ///< as they came over the wire
};

/// One connection to a Modbus device: opening, framing, closing. Nothing about what the frames mean. One thread.
class Link {
  public:
    Link() = default;
    virtual ~Link() = default;
    Link(const Link&) = delete;
    Link& operator=(const Link&) = delete;

    /// Blocks for the timeout at most (and for the name service). Returns why it failed; empty: it is open.
    virtual std::string open(double timeout_ms) = 0;
    virtual void close() noexcept = 0;
    virtual bool is_open() const noexcept = 0;
    /// To wait for; valid while open.
    virtual int fd() const noexcept = 0;
    /// Frames a request and puts it on the wire; returns its bytes, none when the link broke. `more` follow at once: a
    /// link may keep the bytes until the last of them.
    virtual std::span<const std::uint8_t> send(std::uint16_t id, std::span<const std::uint8_t> pdu, bool more) = 0;
    /// Takes what has arrived, one reply at a call; call it when fd() is readable, while has_part(), or when waiting
    /// for the rest of a reply took too long.
    virtual Arrival receive() = 0;
    /// Bytes have arrived that were not handed out yet. Of a part of a reply the rest must follow within
    /// `rest_timeout_ms`; where requests overlap, within the time of the reply (TCP repeats lost bytes by itself).
    virtual bool has_part() const noexcept = 0;
    /// After garbled bytes: true when the next request can be sent, false when only a new connection helps.
    virtual bool resync() = 0;

    /// Whether a request may follow another one that is not answered yet: replies carry the id of their request.
    virtual bool overlaps() const noexcept = 0;
    /// How long that many bytes take on the line; 0 where the line is no bottleneck.
    virtual double wire_ms(std::size_t bytes) const noexcept = 0;

    /// A reply comes in one piece but for rare splits (a USB adapter holds bytes back for up to 16 ms). Below 50 ms,
    /// because a stop waits for the reply being received.
    static constexpr int rest_timeout_ms = 40;
};

}  // namespace cmm::drivers::modbus
