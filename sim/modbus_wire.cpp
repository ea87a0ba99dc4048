// SPDX-License-Identifier: Apache-2.0
#include "sim/modbus_wire.hpp"

#include <optional>

namespace cmm::sim {
namespace {

constexpr std::size_t shortest_request = 4;  // unit, function, CRC

/// Length of the request that begins so, CRC included; nothing while that cannot be told.
std::optional<std::size_t> request_size(std::span<const std::uint8_t> in) {
    switch (in[1]) {
        case 3:
        case 4:
        case 6:
            return 8;
        case 16:
            if (in.size() < 7) return std::nullopt;
            return 9U + in[6];
        case 23:
            if (in.size() < 11) return std::nullopt;
            return 13U + in[10];
        default:
            return std::nullopt;
    }
}

bool crc_fits(std::span<const std::uint8_t> frame) {
    const std::size_t covered = frame.size() - 2;
    const unsigned crc = rtu_crc(frame.first(covered));
    return frame[covered] == (crc & 0xFFU) && frame[covered + 1] == crc >> 8U;
}

}  // namespace

std::uint16_t rtu_crc(std::span<const std::uint8_t> bytes) noexcept {
    unsigned crc = 0xFFFF;
    for (const unsigned byte : bytes) {
        crc ^= byte;
        for (int bit = 0; bit < 8; ++bit)
            crc = (crc & 1U) != 0 ? (crc >> 1U) ^ 0xA001U : crc >> 1U;
    }
    return static_cast<std::uint16_t>(crc);
}

WireProtocol::Progress MbapProtocol::answer(std::span<const std::uint8_t> in, core::Duration,
                                            std::vector<std::uint8_t>& out) {
    mbap::Frame frame;
    switch (mbap::next_frame(in, frame)) {
        case mbap::Parse::malformed:
            return {0, false};
        case mbap::Parse::partial:
            return {};
        case mbap::Parse::complete:
            break;
    }
    answer_frame(device_, frame, out);
    return {frame.size, true};
}

WireProtocol::Progress RtuProtocol::answer(std::span<const std::uint8_t> in, core::Duration silent_for,
                                           std::vector<std::uint8_t>& out) {
    const bool silent = silent_for >= silence;
    if (in.size() >= shortest_request) {
        const auto size = request_size(in);
        if (size && in.size() >= *size && crc_fits(in.first(*size))) {
            carry_out(in.first(*size), out);
            return {*size, true};
        }
        // A function that we do not know: the silence says where it ends.
        if (!size && silent && crc_fits(in)) carry_out(in, out);
    }
    return {silent ? in.size() : 0, true};
}

void RtuProtocol::carry_out(std::span<const std::uint8_t> request, std::vector<std::uint8_t>& out) {
    const bool broadcast = request[0] == 0;
    if (!broadcast && request[0] != unit_) return;
    std::vector<std::uint8_t> reply{request[0]};
    answer_pdu(device_, request.subspan(1, request.size() - 3), reply);
    if (broadcast) return;
    const std::uint16_t crc = rtu_crc(reply);
    reply.push_back(static_cast<std::uint8_t>(crc & 0xFFU));
    reply.push_back(static_cast<std::uint8_t>(crc >> 8U));
    out.insert(out.end(), reply.begin(), reply.end());
}

}  // namespace cmm::sim
