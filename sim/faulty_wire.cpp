// SPDX-License-Identifier: Apache-2.0
#include "sim/faulty_wire.hpp"

#include <algorithm>
#include <utility>

#include "sim/modbus_codec.hpp"
#include "sim/modbus_wire.hpp"

namespace cmm::sim {

namespace {

using enum FaultKind;

}  // namespace

FaultyWire::FaultyWire(Kind kind, std::unique_ptr<WireProtocol> behind, FaultPlay& play)
    : kind_(kind), behind_(std::move(behind)), play_(play), generation_(play.generation()) {}

/// Serial bytes get lost as they come; TCP delivers each or ends.
void FaultyWire::arrived(Bytes& bytes) {
    if (!serial()) return;
    if (play_.silent()) return bytes.clear();
    play_.spoil(bytes);
    const Fault* fault = bytes.empty() ? nullptr : play_.next_arrival();
    if (fault == nullptr) return;
    if (fault->kind == lost_request) return bytes.clear();
    const auto lost = std::min(bytes.size(), static_cast<std::size_t>(fault->amount));
    const auto at = bytes.begin() + static_cast<std::ptrdiff_t>(play_.rng().below(bytes.size() - lost + 1));
    bytes.erase(at, at + static_cast<std::ptrdiff_t>(lost));
}

WireProtocol::Progress FaultyWire::answer(std::span<const std::uint8_t> in, core::Duration silent_for, Bytes& out) {
    const bool dead = generation_ != play_.generation();
    if (dead && !serial()) return {0, false};
    if (forgotten_) return {in.size(), true};
    if (play_.silent()) return {0, true};
    Bytes reply;
    Progress progress = behind_->answer(in, silent_for, reply);
    if (reply.empty()) return progress;
    const Fault* fault = play_.next_reply();
    if (play_.silent()) {  // struck by this very request: TCP delivers the reply when it can
        if (!serial()) send(std::move(reply));
        return progress;
    }
    if (fault == nullptr) {
        send_with_kept(std::move(reply));
    } else {
        progress = meet(*fault, std::move(reply), progress.used);
    }
    flush(out);
    return progress;
}

WireProtocol::Progress FaultyWire::meet(const Fault& fault, Bytes reply, std::size_t used) {
    const auto half = reply.begin() + static_cast<std::ptrdiff_t>(reply.size() / 2);
    switch (fault.kind) {
        case lost_reply:
            break;
        case delay:
            send(std::move(reply), fault.amount);
            break;
        case bad_crc:
            *half ^= 0x55U;
            send(std::move(reply));
            break;
        case split:
            send(Bytes(reply.begin(), half));
            send(Bytes(half, reply.end()), fault.amount);
            break;
        case merged:
        case reordered:
            kept_goes_last_ = fault.kind == reordered;
            std::swap(kept_, reply);
            break;
        case duplicated:
            send(reply);
            send(std::move(reply));
            break;
        case stale:
            send(last_reply_.empty() ? reply : last_reply_);
            last_reply_ = std::move(reply);
            break;
        case truncated:
            send(Bytes(reply.begin(), half));
            break;
        case wrong_unit:
            rename(reply);
            send(std::move(reply));
            break;
        case half_open:
            forgotten_ = !serial();
            break;
        case closed:
            return {used, false, core::from_ms(1e3 * fault.for_s)};
        default:
            send(std::move(reply));
            break;
    }
    return {used, true};
}

void FaultyWire::rename(Bytes& reply) const {
    if (kind_ == Kind::line) return;  // there is one device on it, without a name
    std::uint8_t& unit = reply[kind_ == Kind::rtu ? 0 : mbap::header - 1];
    unit = static_cast<std::uint8_t>(unit == 77 ? 78 : 77);
    if (kind_ == Kind::tcp) return;
    const std::uint16_t crc = rtu_crc(std::span<const std::uint8_t>(reply).first(reply.size() - 2));
    reply[reply.size() - 2] = static_cast<std::uint8_t>(crc & 0xFFU);
    reply[reply.size() - 1] = static_cast<std::uint8_t>(crc >> 8U);
}

void FaultyWire::send_with_kept(Bytes reply) {
    last_reply_ = reply;
    Bytes kept = std::exchange(kept_, {});
    Bytes& first = kept_goes_last_ ? reply : kept;
    const Bytes& second = kept_goes_last_ ? kept : reply;
    first.insert(first.end(), second.begin(), second.end());
    send(std::move(first));
}

/// What is sent later goes behind it: a wire does not overtake itself.
void FaultyWire::send(Bytes bytes, double after_ms) {
    auto due = play_.now() + core::from_ms(after_ms);
    if (!under_way_.empty()) due = std::max(due, under_way_.back().due);
    play_.spoil(bytes);
    under_way_.push_back({due, std::move(bytes)});
}

void FaultyWire::flush(Bytes& out) {
    for (; !under_way_.empty() && under_way_.front().due <= play_.now(); under_way_.pop_front())
        out.insert(out.end(), under_way_.front().bytes.begin(), under_way_.front().bytes.end());
}

WireProtocol::Progress FaultyWire::idle(Bytes& out) {
    if (generation_ != play_.generation() && !serial()) return {0, false};
    if (play_.silent() && serial()) under_way_.clear();
    if (!play_.silent()) flush(out);
    return {};
}

}  // namespace cmm::sim
