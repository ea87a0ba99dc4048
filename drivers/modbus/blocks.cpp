// SPDX-License-Identifier: Apache-2.0
#include "drivers/modbus/blocks.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/text.hpp"
#include "core/units.hpp"

namespace cmm::drivers::modbus {
namespace {

constexpr std::uint32_t magic_number = 0x434D4D31;  // "CMM1"

/// ASCII, high byte first, padded with 0.
std::string text_of(std::span<const std::uint16_t> registers) {
    std::string text;
    for (const auto value : registers) {
        text.push_back(static_cast<char>(value >> 8U));
        text.push_back(static_cast<char>(value & 0xFFU));
    }
    text.resize(std::min(text.find('\0'), text.size()));
    return text;
}

core::Status check_crc(std::span<const std::uint16_t> registers, std::size_t crc_at, std::string_view block) {
    const std::uint16_t expected = crc16(registers, crc_at);
    if (registers[crc_at] == expected) return {};
    return core::fail(core::ErrorCode::protocol_invalid, "the CRC of the " + std::string(block) + " block is " +
                                                             std::to_string(registers[crc_at]) + ", not " +
                                                             std::to_string(expected));
}

Eigen::Vector3d vector_mm(const RegisterMap& map, std::span<const std::uint16_t> registers, std::size_t at,
                          double lsb) {
    return {map.i32(registers, at) * lsb, map.i32(registers, at + 2) * lsb, map.i32(registers, at + 4) * lsb};
}

core::Status check_values(const RegisterMap& map, const Capabilities& found) {
    const auto bad = [](const std::string& what) {
        return core::fail(core::ErrorCode::protocol_invalid, "the identity block says " + what);
    };
    if (!(found.lsb_mm > 0.0)) return bad("that a count is 0 nm");
    if (!(found.sample_rate_hz > 0.0)) return bad("that the sample clock is 0 Hz");
    if (found.path_window == 0) return bad("that a path window holds 0 points");
    if (found.path_window > window_points(map)) {
        return bad("that a path window holds " + std::to_string(found.path_window) + " points; one write carries " +
                   std::to_string(window_points(map)));
    }
    if (!((found.limit_max_mm - found.limit_min_mm).minCoeff() > 0.0)) return bad("that the travel limits are empty");
    return {};
}

}  // namespace

void encode(const RegisterMap& map, const CommandBlock& command, std::span<std::uint16_t> registers) {
    const auto& at = map.command;
    std::fill(registers.begin(), registers.end(), std::uint16_t{0});
    registers[at.seq] = command.sequence;
    registers[at.opcode] = static_cast<std::uint16_t>(command.opcode);
    map.put_u32(registers, at.owner, command.owner);
    for (std::size_t k = 0; k < command.args.size(); ++k)
        map.put_i32(registers, at.args + 2 * k, command.args[k]);
    registers[at.crc] = crc16(registers, at.crc);
}

core::Status check_status(const RegisterMap& map, std::span<const std::uint16_t> registers) {
    const std::uint32_t state = map.value(registers, map.status.state);
    if (auto crc = check_crc(registers, map.status.crc, "status"); !crc) return crc;
    if (state <= static_cast<std::uint16_t>(MachineState::qualifying)) return {};
    return core::fail(core::ErrorCode::protocol_invalid, "unknown machine state " + std::to_string(state));
}

StatusBlock decode_status(const RegisterMap& map, std::span<const std::uint16_t> registers) {
    const auto& at = map.status;
    StatusBlock status;
    status.state = static_cast<std::uint16_t>(map.value(registers, at.state));
    status.heartbeat = registers[at.heartbeat];
    status.flags = static_cast<std::uint16_t>(map.value(registers, at.flags));
    status.fault = static_cast<std::uint16_t>(map.value(registers, at.fault));
    status.command_sequence = registers[at.command_seq];
    status.command_state = static_cast<std::uint16_t>(map.value(registers, at.command_state));
    status.result = static_cast<std::uint16_t>(map.value(registers, at.result));
    for (std::size_t k = 0; k < status.values.size(); ++k)
        status.values[k] = map.i32(registers, at.values + 2 * k);
    status.path = registers[at.active_path];
    status.path_passed = map.value(registers, at.path_recorded);
    status.path_received = map.value(registers, at.path_received);
    status.newest = map.u32(registers, at.newest_seq);
    status.acknowledged = map.u32(registers, at.acked_seq);
    for (std::size_t k = 0; k < 3; ++k)
        status.position[k] = map.i32(registers, at.position + 2 * k);
    status.fifo_level = static_cast<std::uint16_t>(map.value(registers, at.fifo_level));
    status.time_us = map.u48(registers, at.time_us);
    status.owner = map.u32(registers, at.owner);
    return status;
}

core::Result<Capabilities> decode_identity(const RegisterMap& map, std::span<const std::uint16_t> registers) {
    const auto& at = map.identity;
    // Magic and version come before the CRC: a foreign device should be named as such, not as a broken one.
    const std::uint32_t magic = (std::uint32_t{registers[at.magic]} << 16U) | registers[at.magic + 1U];
    if (magic != magic_number) {
        return core::fail(core::ErrorCode::protocol_mismatch,
                          "the device that answers is no measuring machine of register map \"" + map.name +
                              "\": its identity does not begin with CMM1");
    }
    if (registers[at.map_version] != map.version) {
        return core::fail(core::ErrorCode::protocol_mismatch,
                          "the controller has register map version " + std::to_string(registers[at.map_version]) +
                              ", the map \"" + map.name + "\" is version " + std::to_string(map.version));
    }
    if (auto crc = check_crc(registers, at.crc, "identity"); !crc) return tl::unexpected(crc.error());
    Capabilities found;
    found.model = text_of(registers.subspan(at.model, 8));
    found.serial = text_of(registers.subspan(at.serial, 8));
    found.firmware =
        std::to_string(registers[at.firmware] >> 8U) + "." + std::to_string(registers[at.firmware] & 0xFFU);
    found.boot_id = registers[at.boot_id];
    const unsigned bits = registers[at.capabilities];
    found.scans_paths = (bits & 1U) != 0;
    found.touches = (bits & 2U) != 0;
    found.gives_deflection = (bits & 4U) != 0;
    found.appends_paths = (bits & 8U) != 0;
    found.sample_rate_hz = registers[at.sample_rate_hz];
    found.fifo_depth = registers[at.fifo_depth];
    found.path_capacity = registers[at.path_capacity];
    found.path_window = registers[at.path_window];
    found.lsb_mm = map.scale.count_mm > 0.0 ? map.scale.count_mm : registers[at.lsb_nm] * 1e-6;
    found.deflection_lsb_mm = core::mm_from_um(registers[at.deflection_lsb_um]);
    found.limit_min_mm = vector_mm(map, registers, at.limit_min, found.lsb_mm);
    found.limit_max_mm = vector_mm(map, registers, at.limit_max, found.lsb_mm);
    found.max_speed_mm_s = core::mm_from_um(map.u32(registers, at.max_speed_um_s));
    found.max_acceleration_mm_s2 = core::mm_from_um(map.u32(registers, at.max_accel_um_s2));
    found.watchdog_ms = registers[at.watchdog_ms];
    if (auto sane = check_values(map, found); !sane) return tl::unexpected(sane.error());
    return found;
}

core::Status check_fifo(const RegisterMap& map, std::span<const std::uint16_t> registers) {
    const auto& at = map.fifo;
    const std::size_t count = registers[at.count];
    const std::size_t used = at.points + count * at.point_length;
    if (used <= registers.size()) return check_crc(registers.first(used), at.crc, "sample");
    return core::fail(core::ErrorCode::protocol_invalid,
                      "a sample block claims " + std::to_string(count) + " points; it has room for " +
                          std::to_string((registers.size() - at.points) / at.point_length));
}

FifoBlock decode_fifo(const RegisterMap& map, std::span<const std::uint16_t> registers) {
    const auto& at = map.fifo;
    FifoBlock block;
    block.count = registers[at.count];
    block.state = static_cast<std::uint16_t>(map.value(registers, at.state));
    block.path = registers[at.path];
    block.flags = static_cast<std::uint16_t>(map.value(registers, at.flags));
    block.first = map.u32(registers, at.first_seq);
    block.newest = map.u32(registers, at.newest_seq);
    block.time_us = map.u48(registers, at.time_us);
    return block;
}

void decode_samples(const RegisterMap& map, std::span<const std::uint16_t> registers, const FifoBlock& block,
                    std::vector<core::Sample>& samples) {
    const auto& at = map.fifo;
    samples.resize(block.count);
    std::int64_t time_us = block.time_us;
    for (std::size_t k = 0; k < samples.size(); ++k) {
        const auto point = registers.subspan(at.points + k * at.point_length, at.point_length);
        if (k > 0) time_us += point[at.dt] * map.scale.dt_us;
        core::Sample& sample = samples[k];
        sample.sequence = std::uint64_t{block.first} + k;
        sample.machine_time_us = time_us;
        sample.host_time_ns = 0;
        sample.counts = {map.i32(point, at.position), map.i32(point, at.position + 2U),
                         map.i32(point, at.position + 4U)};
        sample.path = block.path;
        sample.flags = static_cast<std::uint16_t>(point[at.quality] & 0xFFU);
        sample.deflection_counts = point[at.quality] >> 8U;
    }
}

std::size_t window_points(const RegisterMap& map) noexcept {
    return (max_write - map.path.header) / map.path.point_length;
}

std::size_t block_samples(const RegisterMap& map) noexcept {
    return (map.fifo.length - map.fifo.points) / map.fifo.point_length;
}

std::size_t encode_window(const RegisterMap& map, const Window& from, double lsb_mm,
                          std::span<std::uint16_t> registers) {
    const auto& at = map.path;
    const auto points = from.points;
    const std::size_t used = at.header + points.size() * at.point_length;
    const auto window = registers.first(used);
    std::fill(window.begin(), window.end(), std::uint16_t{0});
    window[at.path] = from.path;
    map.put_u32(window, at.first_index, from.first_index);
    window[at.count] = static_cast<std::uint16_t>(points.size());
    for (std::size_t k = 0; k < points.size(); ++k) {
        const auto out = window.subspan(at.header + k * at.point_length, at.point_length);
        const PathPoint& point = points[k];
        for (Eigen::Index axis = 0; axis < 3; ++axis) {
            map.put_i32(out, at.position + static_cast<std::size_t>(2 * axis),
                        core::counts_from_mm(point.centre_mm[axis], lsb_mm));
            const auto scaled = static_cast<std::int16_t>(std::lround(point.normal[axis] * map.scale.normal));
            out[at.normal + static_cast<std::size_t>(axis)] = static_cast<std::uint16_t>(scaled);
        }
        out[at.speed] = static_cast<std::uint16_t>(std::lround(point.speed_mm_s / map.scale.speed_mm_s));
        const bool is_last = from.last && k + 1 == points.size();
        out[at.flags] = static_cast<std::uint16_t>((point.record ? 1U : 0U) | (is_last ? 2U : 0U));
    }
    window[at.crc] = crc16(window, at.crc);
    return used;
}

}  // namespace cmm::drivers::modbus
