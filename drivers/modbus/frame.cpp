// SPDX-License-Identifier: Apache-2.0
#include "drivers/modbus/frame.hpp"

#include <algorithm>

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
    explicit ByteWriter(std::span<std::uint8_t, max_pdu> pdu) : pdu_(pdu) {}
    void byte(std::uint8_t value) { pdu_[used_++] = value; }
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
    std::span<std::uint8_t, max_pdu> pdu_;
    std::size_t used_ = 0;
};

std::uint16_t word_at(std::span<const std::uint8_t> bytes, std::size_t at) noexcept {
    return static_cast<std::uint16_t>((bytes[at] << 8U) | bytes[at + 1]);
}

bool reads(const Transaction& request) noexcept {
    return request.kind == Transaction::Kind::read || request.kind == Transaction::Kind::exchange;
}

bool take_registers(std::span<const std::uint8_t> pdu, Transaction& request) noexcept {
    const std::size_t bytes = std::size_t{2} * request.read_count;
    if (pdu.size() != 2 + bytes || pdu[1] != bytes) return false;
    for (std::size_t k = 0; k < request.read_count; ++k)
        request.read[k] = word_at(pdu, 2 + 2 * k);
    return true;
}

/// Writes are answered by an echo of the address and the count (FC 16) or value (FC 6).
bool echo_fits(std::span<const std::uint8_t> pdu, const Transaction& request) noexcept {
    const bool single = request.kind == Transaction::Kind::write_single;
    return pdu.size() == 5 && word_at(pdu, 1) == request.write_address &&
           word_at(pdu, 3) == (single ? request.written[0] : request.write_count);
}

}  // namespace

std::size_t encode_pdu(const Transaction& request, std::span<std::uint8_t, max_pdu> pdu) noexcept {
    ByteWriter out(pdu);
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
    return out.used();
}

std::size_t reply_size(const Transaction& request) noexcept {
    return reads(request) ? 2 + std::size_t{2} * request.read_count : 5;
}

void take_reply(std::span<const std::uint8_t> pdu, Transaction& request) noexcept {
    request.outcome = Transaction::Outcome::invalid;
    if (pdu.size() < 2) return;
    const std::uint8_t expected = function_of(request.kind);
    if (pdu[0] == (expected | 0x80U) && pdu.size() == 2) {
        request.exception = pdu[1];
        request.outcome = Transaction::Outcome::exception;
        return;
    }
    const bool fits = pdu[0] == expected && (reads(request) ? take_registers(pdu, request) : echo_fits(pdu, request));
    if (fits) request.outcome = Transaction::Outcome::ok;
}

std::size_t tcp_frame(std::uint16_t id, std::uint8_t unit, std::span<const std::uint8_t> pdu,
                      std::span<std::uint8_t, max_frame> frame) noexcept {
    const std::size_t following = 1 + pdu.size();
    frame[0] = static_cast<std::uint8_t>(id >> 8U);
    frame[1] = static_cast<std::uint8_t>(id & 0xFFU);
    frame[2] = frame[3] = 0;
    frame[4] = static_cast<std::uint8_t>(following >> 8U);
    frame[5] = static_cast<std::uint8_t>(following & 0xFFU);
    frame[6] = unit;
    std::copy(pdu.begin(), pdu.end(), frame.begin() + header_bytes);
    return header_bytes + pdu.size();
}

TcpCut cut_tcp(std::span<const std::uint8_t> bytes) noexcept {
    constexpr std::size_t counted_from =
        6;  // the length counts what follows it: unit, function, at least one byte more
    constexpr std::size_t shortest = 3, longest = 1 + max_pdu;
    if (bytes.size() >= 4 && word_at(bytes, 2) != 0) return {TcpCut::Kind::garbled, 0};
    if (bytes.size() < counted_from) return {};
    const std::size_t following = word_at(bytes, 4);
    if (following < shortest || following > longest) return {TcpCut::Kind::garbled, 0};
    if (bytes.size() < counted_from + following) return {};
    return {TcpCut::Kind::frame, counted_from + following};
}

std::uint16_t tcp_id(std::span<const std::uint8_t> frame) noexcept {
    return word_at(frame, 0);
}

std::span<const std::uint8_t> tcp_pdu(std::span<const std::uint8_t> frame) noexcept {
    return frame.subspan(header_bytes);
}

}  // namespace cmm::drivers::modbus
