// SPDX-License-Identifier: Apache-2.0
#include "scripted_serial.hpp"

#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include <array>
#include <optional>
#include <stdexcept>

namespace cmm::drivers::test {
namespace {

std::optional<std::size_t> size_of_request(const Bytes& bytes) {
    if (bytes.size() < 2) return std::nullopt;
    if (bytes[1] == 3 || bytes[1] == 6) return 8;
    const std::size_t count_at = bytes[1] == 16 ? 6 : 10;
    if (bytes.size() <= count_at) return std::nullopt;
    return count_at + 3 + bytes[count_at];
}

}  // namespace

unsigned crc_of(const Bytes& bytes) {
    unsigned crc = 0xFFFF;
    for (const unsigned byte : bytes) {
        crc ^= byte;
        for (int bit = 0; bit < 8; ++bit)
            crc = (crc & 1U) != 0 ? (crc >> 1U) ^ 0xA001U : crc >> 1U;
    }
    return crc;
}

ScriptedSerial::ScriptedSerial(const std::string& port) : fd_(::open(port.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK)) {
    if (fd_ < 0) throw std::runtime_error("cannot open " + port);
    thread_ = std::thread([this] { serve(); });
}

ScriptedSerial::~ScriptedSerial() {
    quit_ = true;
    thread_.join();
    ::close(fd_);
}

void ScriptedSerial::on_request(std::function<Fault(const Request&)> rule) {
    const std::lock_guard lock(mutex_);
    rule_ = std::move(rule);
}

void ScriptedSerial::serve() {
    Bytes in;
    while (!quit_) {
        pollfd wait{fd_, POLLIN, 0};
        if (::poll(&wait, 1, 10) == 0) in.clear();  // a silence ends whatever it was
        std::array<std::uint8_t, 512> buffer;
        const auto got = ::read(fd_, buffer.data(), buffer.size());
        if (got > 0) in.insert(in.end(), buffer.begin(), buffer.begin() + got);
        const auto size = size_of_request(in);
        if (!size || in.size() < *size) continue;
        const Bytes request(in.begin(), in.begin() + static_cast<std::ptrdiff_t>(*size));
        in.erase(in.begin(), in.begin() + static_cast<std::ptrdiff_t>(*size));
        if (crc_of(request) != 0) {  // over a frame with its CRC: 0 when it fits
            ++crc_errors_;
            in.clear();
        } else {
            answer(request);
        }
    }
}

void ScriptedSerial::answer(const Bytes& request) {
    const Bytes pdu(request.begin() + 1, request.end() - 2);
    std::function<Fault(const Request&)> rule;
    {
        const std::lock_guard lock(mutex_);
        rule = rule_;
    }
    const Fault fault = rule ? rule(Request{pdu[0], word(pdu, 1), ++requests_}) : Fault::none;
    if (fault == Fault::silent) return;
    Bytes reply{request[0]};
    {
        const std::lock_guard lock(mutex_);
        const Bytes body = machine_.execute(pdu);
        reply.insert(reply.end(), body.begin(), body.end());
    }
    const unsigned crc = crc_of(reply);
    reply.push_back(static_cast<std::uint8_t>(crc & 0xFFU));
    reply.push_back(static_cast<std::uint8_t>(crc >> 8U));
    if (fault == Fault::lost_reply) return;
    if (fault == Fault::truncated) reply.resize(reply.size() / 2);
    if (fault == Fault::bad_crc) reply[reply.size() / 2] ^= 0x10;
    if (fault == Fault::garbage) reply.assign(12, 0xEE);
    if (fault == Fault::late_reply) std::this_thread::sleep_for(std::chrono::milliseconds(late_by_ms));
    [[maybe_unused]] const auto written = ::write(fd_, reply.data(), reply.size());
}

}  // namespace cmm::drivers::test
