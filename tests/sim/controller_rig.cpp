// SPDX-License-Identifier: Apache-2.0
#include "tests/sim/controller_rig.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace cmm::sim::test {

Contact Bar::nearest(const Eigen::Vector3d& centre_mm, std::size_t& warm) const {
    warm = 0;
    const Eigen::Vector3d across(centre_mm.x(), centre_mm.y(), 0.0);
    const double distance = across.norm();
    const Eigen::Vector3d normal = distance > 0.0 ? Eigen::Vector3d(across / distance) : Eigen::Vector3d::UnitX();
    return {distance - radius_, radius_ * normal + Eigen::Vector3d(0, 0, centre_mm.z()), normal};
}

ControllerOptions bar_options() {
    ControllerOptions options;
    options.part.name = "bar";
    options.part.surface = std::make_shared<Bar>(bar_radius_mm);
    options.part.ball_radius_mm = ball_radius_mm;
    options.boot_id = 77;
    return options;
}

std::vector<PathPoint> arc_path(int count, double step_rad, double speed_mm_s, double z_mm, double from_rad) {
    std::vector<PathPoint> path;
    for (int i = 0; i < count; ++i) {
        const double angle = from_rad + i * step_rad;
        const Eigen::Vector3d normal(std::cos(angle), std::sin(angle), 0.0);
        path.push_back({circle_mm * normal + Eigen::Vector3d(0, 0, z_mm), normal, speed_mm_s, true, i + 1 == count});
    }
    return path;
}

namespace {
ControllerOptions recording(ControllerOptions options, std::vector<SampleTruth>& truth) {
    options.on_sample = [&truth](const SampleTruth& sample) { truth.push_back(sample); };
    return options;
}
}  // namespace

Rig::Rig(ControllerOptions options) : controller(recording(std::move(options), truth), clock) {}

CommandStatus Rig::send(std::uint16_t opcode, std::initializer_list<std::int32_t> args, std::uint32_t owner) {
    Command command{++seq, opcode, owner, {}};
    std::copy(args.begin(), args.end(), command.args.begin());
    controller.command(command);
    return controller.command_status();
}

void Rig::run_ms(int milliseconds) {
    for (int i = 0; i < milliseconds; ++i) {
        clock.advance(std::chrono::milliseconds(1));
        controller.feed_watchdog(++watchdog);
        while (controller.step()) {
        }
    }
}

CommandStatus Rig::finish() {
    for (int i = 0; i < 60000 && controller.command_status().state == CommandState::running; ++i)
        run_ms(1);
    EXPECT_NE(controller.command_status().state, CommandState::running);
    return controller.command_status();
}

CommandStatus Rig::finish(std::uint16_t opcode, std::initializer_list<std::int32_t> args) {
    send(opcode, args);
    return finish();
}

void Rig::prepare() {
    ASSERT_EQ(send(opcode::claim).state, CommandState::done);
    ASSERT_EQ(finish(opcode::home).result, ResultCode::ok);
    ASSERT_EQ(finish(opcode::qualify, {10000}).result, ResultCode::ok);
    ASSERT_EQ(finish(opcode::move, {500000, 0, 0, 400000}).result, ResultCode::ok);
}

void Rig::upload(std::uint16_t id, const std::vector<PathPoint>& path) {
    for (std::size_t first = 0; first < path.size(); first += 10) {
        const std::span<const PathPoint> window(path.data() + first, std::min<std::size_t>(10, path.size() - first));
        ASSERT_EQ(controller.append_path(id, static_cast<std::uint32_t>(first), window), ScanPath::Append::taken);
    }
}

void Rig::begin_scan(std::uint16_t id, const std::vector<PathPoint>& path) {
    EXPECT_EQ(send(opcode::path_begin, {id}).result, ResultCode::ok);
    upload(id, path);
    send(opcode::scan, {id, 10000, 10000, 10000});
}

CommandStatus Rig::scan(std::uint16_t id, const std::vector<PathPoint>& path) {
    begin_scan(id, path);
    return finish();
}

std::vector<FifoSample> Rig::samples() const {
    std::vector<FifoSample> all;
    for (std::uint32_t seq_no = controller.fifo().acknowledged() + 1; seq_no <= controller.fifo().newest(); ++seq_no)
        all.push_back(controller.fifo().at(seq_no));
    return all;
}

void expect_failed(const CommandStatus& status, ResultCode result) {
    EXPECT_EQ(status.state, CommandState::failed);
    EXPECT_EQ(status.result, result);
}

}  // namespace cmm::sim::test
