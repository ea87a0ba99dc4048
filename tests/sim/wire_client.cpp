// SPDX-License-Identifier: Apache-2.0
#include "tests/sim/wire_client.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>

#include "sim/contact.hpp"
#include "sim/registers.hpp"

namespace cmm::sim::test {
namespace {

using Bytes = std::vector<std::uint8_t>;
using Registers = std::vector<std::uint16_t>;

void add(Bytes& to, std::uint32_t word) {
    to.push_back(static_cast<std::uint8_t>(word >> 8U & 0xFFU));
    to.push_back(static_cast<std::uint8_t>(word & 0xFFU));
}

void add_wide(Registers& to, std::uint32_t value) {
    to.push_back(static_cast<std::uint16_t>(value >> 16U));
    to.push_back(static_cast<std::uint16_t>(value & 0xFFFFU));
}

Registers registers_of(const Bytes& reply, std::size_t first_byte) {
    Registers registers;
    for (std::size_t i = first_byte; i + 1 < reply.size(); i += 2)
        registers.push_back(static_cast<std::uint16_t>(reply[i] << 8U | reply[i + 1]));
    return registers;
}

}  // namespace

Bytes WireClient::ask(const Bytes& pdu, std::size_t reply_size) {
    Bytes request;
    add(request, ++transaction_);
    add(request, 0);
    add(request, static_cast<std::uint32_t>(pdu.size() + 1));
    request.push_back(1);
    request.insert(request.end(), pdu.begin(), pdu.end());
    raw_.send(request);
    Bytes reply = raw_.receive(9);
    if (reply.size() < 9) throw std::runtime_error("no reply");
    if (reply[7] == pdu[0]) {
        const Bytes rest = raw_.receive(7 + reply_size - 9);
        reply.insert(reply.end(), rest.begin(), rest.end());
    }
    return {reply.begin() + 7, reply.end()};
}

Registers WireClient::read(std::uint16_t address, std::uint16_t count) {
    Bytes pdu{3};
    add(pdu, address);
    add(pdu, count);
    return registers_of(ask(pdu, 2U + 2U * count), 2);
}

int WireClient::write(std::uint16_t address, const Registers& registers) {
    Bytes pdu{16};
    add(pdu, address);
    add(pdu, static_cast<std::uint32_t>(registers.size()));
    pdu.push_back(static_cast<std::uint8_t>(2 * registers.size()));
    for (const std::uint16_t value : registers)
        add(pdu, value);
    const Bytes reply = ask(pdu, 5);
    return reply[0] == 16 ? 0 : reply[1];
}

Registers WireClient::exchange(std::uint32_t ack, std::uint32_t from) {
    Bytes pdu{23};
    for (const std::uint32_t word : {400U, 125U, 384U, 5U})
        add(pdu, word);
    pdu.push_back(10);
    Registers written{++watchdog_};
    add_wide(written, ack);
    add_wide(written, from);
    for (const std::uint16_t value : written)
        add(pdu, value);
    return registers_of(ask(pdu, 252), 2);
}

void WireClient::start(std::uint16_t opcode, std::initializer_list<std::int32_t> args) {
    Registers block{++seq_, opcode, 0, 7};
    for (const std::int32_t arg : args)
        add_wide(block, static_cast<std::uint32_t>(arg));
    block.resize(21);
    block[20] = block_crc(block, 20);
    ASSERT_EQ(write(128, block), 0);
}

int WireClient::finish() {
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    while (std::chrono::steady_clock::now() < deadline) {
        exchange(0);
        const Registers status = read(68, 3);
        if (status[0] == seq_ && status[1] != 1) return status[2];
    }
    throw std::runtime_error("the command does not end");
}

int WireClient::run(std::uint16_t opcode, std::initializer_list<std::int32_t> args) {
    start(opcode, args);
    return finish();
}

void WireClient::prepare(double ball_mm) {
    seq_ = read(68, 1)[0];
    ASSERT_EQ(run(opcode::claim), 0);
    ASSERT_EQ(run(opcode::home), 0);
    ASSERT_EQ(run(opcode::qualify, {static_cast<std::int32_t>(std::lround(ball_mm * 1e4))}), 0);
}

int WireClient::send_window(std::uint16_t id, std::uint32_t first, std::span<const PathPoint> points) {
    Registers block{id};
    add_wide(block, first);
    block.insert(block.end(), {static_cast<std::uint16_t>(points.size()), 0, 0});
    for (const PathPoint& point : points) {
        for (int axis = 0; axis < 3; ++axis)
            add_wide(block, static_cast<std::uint32_t>(std::lround(point.position[axis] * 1e4)));
        for (int axis = 0; axis < 3; ++axis)
            block.push_back(static_cast<std::uint16_t>(std::lround(point.normal[axis] * 32767)));
        block.push_back(static_cast<std::uint16_t>(std::lround(point.speed_mm_s * 100)));
        block.push_back(static_cast<std::uint16_t>((point.record ? 1 : 0) | (point.last ? 2 : 0)));
    }
    block[4] = block_crc(block, 4);
    return write(256, block);
}

std::vector<PathPoint> walk_around(const Surface& surface, double z_mm, double radius_mm, double step_mm,
                                   double speed_mm_s) {
    std::size_t warm = 0;
    const Box box = surface.box();
    const Eigen::Vector3d from((box.low.x() + box.high.x()) / 2, box.high.y() + 10.0, z_mm);
    auto ball =
        touch_along(surface, from, -Eigen::Vector3d::UnitY(), 0.0, box.high.y() - box.low.y() + 20.0, radius_mm, warm);
    if (!ball) throw std::runtime_error("the walk finds no start");
    std::vector<PathPoint> path;
    const Eigen::Vector3d start = ball->centre;
    for (int i = 0; i < 1000000; ++i) {
        const Eigen::Vector3d normal = Eigen::Vector3d(ball->normal.x(), ball->normal.y(), 0.0).normalized();
        path.push_back({ball->centre, normal, speed_mm_s, true, false});
        if (i > 10 && (ball->centre - start).norm() < step_mm) break;
        const Eigen::Vector3d ahead = ball->centre + step_mm * Eigen::Vector3d::UnitZ().cross(normal);
        ball = touch_along(surface, ahead, -normal, -radius_mm, radius_mm, radius_mm, warm);
        if (!ball) throw std::runtime_error("the walk loses the part");
    }
    path.back().last = true;
    return path;
}

}  // namespace cmm::sim::test
