// SPDX-License-Identifier: Apache-2.0
#include "drivers/modbus/frame.hpp"

namespace cmm::drivers::modbus {
namespace {

constexpr std::size_t header_bytes = 7;  // transaction id, protocol 0, length, unit

std::uint8_t function_of(Transaction::Kind kind) noexcept {
    switch (kind) {
        case Transaction::Kind::read:
            return 3;
        case Transaction::Kind::write:
            return 16;
        case Transaction::Kind::write_single:
            return 6;
        case Transaction::Kind::exchange:
            return 23;
    }
    return 0;
}

class ByteWriter {
  public:
    explicit ByteWriter(std::span<std::uint8_t, max_frame> frame) : frame_(frame) {}
    void byte(std::uint8_t value) { frame_[used_++] = value; }
    void word(std::uint16_t value) {
        byte(static_cast<std::uint8_t>(value >> 8U));
        byte(static_cast<std::uint8_t>(value & 0xFFU));
    }
    void block(const Transaction& request) {
        word(request.write_address);
        word(request.write_count);
        byte(static_cast<std::uint8_t>(2 * request.write_count));
        for (std::size_t k = 0; k < request.write_count; ++k)
            word(request.written[k]);
    }
    std::size_t used() const { return used_; }

  private:
    std::span<std::uint8_t, max_frame> frame_;
    std::size_t used_ = 0;
};

std::uint16_t word_at(std::span<const std::uint8_t> frame, std::size_t at) noexcept {
    return static_cast<std::uint16_t>((frame[at] << 8U) | frame[at + 1]);
}

bool take_registers(std::span<const std::uint8_t> frame, Transaction& request) noexcept {
    const std::size_t bytes = std::size_t{2} * request.read_count;
    if (frame.size() != header_bytes + 2 + bytes || frame[header_bytes + 1] != bytes) return false;
    for (std::size_t k = 0; k < request.read_count; ++k)
        request.read[k] = word_at(frame, header_bytes + 2 + 2 * k);
    return true;
}

/// Writes are answered by an echo of the address and the count (FC 16) or value (FC 6).
bool echo_fits(std::span<const std::uint8_t> frame, const Transaction& request) noexcept {
    const bool single = request.kind == Transaction::Kind::write_single;
    return frame.size() == header_bytes + 5 && word_at(frame, header_bytes + 1) == request.write_address &&
           word_at(frame, header_bytes + 3) == (single ? request.written[0] : request.write_count);
}

}  // namespace

std::size_t encode_request(const Transaction& request, std::uint16_t id, std::uint8_t unit,
                           std::span<std::uint8_t, max_frame> frame) noexcept {
    ByteWriter out(frame);
    out.word(id);
    out.word(0);
    out.word(0);  // length, known at the end
    out.byte(unit);
    out.byte(function_of(request.kind));
    switch (request.kind) {
        case Transaction::Kind::read:
            out.word(request.read_address);
            out.word(request.read_count);
            break;
        case Transaction::Kind::write:
            out.block(request);
            break;
        case Transaction::Kind::write_single:
            out.word(request.write_address);
            out.word(request.written[0]);
            break;
        case Transaction::Kind::exchange:
            out.word(request.read_address);
            out.word(request.read_count);
            out.block(request);
            break;
    }
    const std::size_t following = out.used() - 6;
    frame[4] = static_cast<std::uint8_t>(following >> 8U);
    frame[5] = static_cast<std::uint8_t>(following & 0xFFU);
    return out.used();
}

std::uint16_t id_of(std::span<const std::uint8_t> frame) noexcept {
    return word_at(frame, 0);
}

bool header_fits(std::span<const std::uint8_t> frame) noexcept {
    return frame.size() >= header_bytes + 2 && word_at(frame, 2) == 0 && word_at(frame, 4) + 6U == frame.size();
}

void take_reply(std::span<const std::uint8_t> frame, Transaction& request) noexcept {
    const std::uint8_t function = frame[header_bytes];
    const std::uint8_t expected = function_of(request.kind);
    if (function == (expected | 0x80U)) {
        request.exception = frame[header_bytes + 1];
        request.outcome = Transaction::Outcome::exception;
        return;
    }
    const bool reads = request.kind == Transaction::Kind::read || request.kind == Transaction::Kind::exchange;
    const bool fits = function == expected && (reads ? take_registers(frame, request) : echo_fits(frame, request));
    request.outcome = fits ? Transaction::Outcome::ok : Transaction::Outcome::invalid;
}

}  // namespace cmm::drivers::modbus
