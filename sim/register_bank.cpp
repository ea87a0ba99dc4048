// SPDX-License-Identifier: Apache-2.0
#include "sim/register_bank.hpp"

#include <algorithm>
#include <cmath>

#include "core/units.hpp"
#include "sim/registers.hpp"

namespace cmm::sim {
namespace {

constexpr std::uint16_t firmware = 1 * 256 + 0;

std::uint16_t u16(double value) {
    return static_cast<std::uint16_t>(std::llround(value));
}
std::uint32_t u32(double value) {
    return static_cast<std::uint32_t>(std::llround(value));
}
template <class Enum>
std::uint16_t code(Enum value) {
    return static_cast<std::uint16_t>(value);
}
std::uint16_t capped(std::size_t value) {
    return static_cast<std::uint16_t>(std::min<std::size_t>(value, 65535));
}

std::span<const std::uint16_t> part_of(const std::vector<std::uint16_t>& image, std::size_t offset, std::size_t count) {
    return std::span<const std::uint16_t>(image).subspan(offset, count);
}

void put(RegisterWriter& out, const RegisterMap::Place& place, std::uint32_t value) {
    out.put_bits(place.at, place.words, place.bit, place.bits, value);
}

}  // namespace

RegisterBank::RegisterBank(Controller& controller, const RegisterMap& map)
    : controller_(controller),
      map_(map),
      command_(map.command.length),
      stop_(map.stop.length),
      path_(map.path.length),
      exchange_(map.exchange.length) {}

RegisterBank::Image RegisterBank::identity() const {
    Image image(map_.identity.length);
    RegisterWriter out(image, map_.big_words);
    const RegisterMap::Identity& at = map_.identity;
    const ControllerOptions& options = controller_.options();
    const MachineSettings& machine = options.machine;
    out.put16(at.magic, 0x434D);
    out.put16(at.magic + 1, 0x4D31);
    out.put16(at.map_version, map_.version);
    out.put16(at.firmware, firmware);
    out.put_text(at.model, 8, machine.model);
    out.put_text(at.serial, 8, machine.serial);
    out.put16(at.lsb_nm, u16(machine.lsb_mm * 1e6));
    out.put16(at.sample_rate_hz, u16(machine.sample_rate_hz));
    out.put16(at.fifo_depth, capped(machine.fifo_depth));
    out.put16(at.path_capacity, capped(machine.path_capacity));
    out.put16(at.path_window, capped(map_.path_window));
    out.put16(at.watchdog_ms, u16(machine.watchdog_ms));
    out.put16(at.capabilities, capability_bits);
    out.put16(at.deflection_lsb_um, 1);
    for (int axis = 0; axis < 3; ++axis) {
        const auto place = static_cast<std::size_t>(2 * axis);
        const auto counts = [&](double mm) {
            return static_cast<std::uint32_t>(core::counts_from_mm(mm, machine.lsb_mm));
        };
        out.put32(at.limit_min + place, counts(machine.limit_min_mm[axis]));
        out.put32(at.limit_max + place, counts(machine.limit_max_mm[axis]));
    }
    out.put32(at.max_speed_um_s, u32(core::um_from_mm(machine.max_speed_mm_s)));
    out.put32(at.max_accel_um_s2, u32(core::um_from_mm(machine.max_accel_mm_s2)));
    out.put16(at.boot_id, options.boot_id);
    out.put16(at.crc, block_crc(image, at.crc));
    return image;
}

void RegisterBank::fill_status(std::span<std::uint16_t> to) const {
    RegisterWriter out(to, map_.big_words);
    const RegisterMap::Status& at = map_.status;
    const Controller& controller = controller_;
    const CommandStatus& command = controller.command_status();
    put(out, at.state, code(controller.state()));
    out.put16(at.heartbeat, controller.heartbeat());
    put(out, at.flags, controller.flags());
    put(out, at.fault, code(controller.fault()));
    out.put16(at.command_seq, command.seq);
    put(out, at.command_state, code(command.state));
    put(out, at.result, code(command.result));
    for (std::size_t i = 0; i < command.values.size(); ++i)
        out.put32(at.values + 2 * i, static_cast<std::uint32_t>(command.values[i]));
    out.put16(at.active_path, controller.path().id());
    put(out, at.path_recorded, controller.path_passed());
    put(out, at.path_received, controller.path().received());
    out.put32(at.newest_seq, controller.fifo().newest());
    out.put32(at.acked_seq, controller.fifo().acknowledged());
    const Eigen::Vector3d position = controller.position_mm();
    for (int axis = 0; axis < 3; ++axis)
        out.put32(
            at.position + static_cast<std::size_t>(2 * axis),
            static_cast<std::uint32_t>(core::counts_from_mm(position[axis], controller.options().machine.lsb_mm)));
    put(out, at.fifo_level, capped(controller.fifo().level()));
    out.put48(at.time_us, static_cast<std::uint64_t>(controller.time_us()));
    out.put32(at.owner, controller.owner());
    out.put16(at.crc, block_crc(to, at.crc));
}

void RegisterBank::fill_fifo(std::span<std::uint16_t> to) const {
    RegisterWriter out(to, map_.big_words);
    const RegisterMap::Fifo& at = map_.fifo;
    const SampleFifo& fifo = controller_.fifo();
    const std::uint32_t asked = get32(exchange_, map_.exchange.from_seq, map_.big_words);
    const std::uint32_t first = std::clamp(asked, fifo.acknowledged() + 1, fifo.newest() + 1);
    const std::uint16_t path = fifo.holds(first) ? fifo.at(first).path : controller_.path().id();
    std::uint32_t next = first;
    std::int64_t units = 0;  // since the first point; dt is a difference of these, so rounding does not add up
    for (std::size_t i = 0; i < map_.fifo_window && fifo.holds(next); ++i, ++next) {
        const FifoSample& sample = fifo.at(next);
        const std::int64_t since = (sample.time_us - fifo.at(first).time_us) / map_.dt_us;
        if (sample.path != path || since < units || since - units > 65535) break;
        const std::size_t place = at.points + i * at.point_length;
        for (std::size_t axis = 0; axis < 3; ++axis)
            out.put32(place + at.position + 2 * axis, static_cast<std::uint32_t>(sample.counts[axis]));
        out.put16(place + at.dt, static_cast<std::uint16_t>(since - units));
        out.put16(place + at.quality, sample.quality);
        units = since;
    }
    put(out, at.state, code(controller_.state()));
    out.put16(at.heartbeat, controller_.heartbeat());
    out.put16(at.path, path);
    out.put32(at.first_seq, first);
    out.put32(at.newest_seq, fifo.newest());
    out.put16(at.count, static_cast<std::uint16_t>(next - first));
    put(out, at.flags, controller_.sample_flags(path, next));
    out.put48(at.time_us, static_cast<std::uint64_t>(next > first ? fifo.at(first).time_us : controller_.time_us()));
    out.put16(at.crc, block_crc(to.first(at.points + (next - first) * at.point_length), at.crc));
}

ModbusException RegisterBank::read(std::size_t address, std::span<std::uint16_t> to) {
    if (const std::uint8_t refusal = controller_.take_refusal(); refusal != 0) return ModbusException{refusal};
    const auto copy = [&](const RegisterMap::Block& block, const Image& image) {
        const auto from = part_of(image, address - block.address, to.size());
        std::copy(from.begin(), from.end(), to.begin());
        return ModbusException::none;
    };
    if (map_.fifo.holds(address, to.size())) {
        Image image(map_.fifo.length);
        fill_fifo(image);
        return copy(map_.fifo, image);
    }
    if (map_.status.holds(address, to.size())) {
        Image image(map_.status.length);
        fill_status(image);
        return copy(map_.status, image);
    }
    if (map_.identity.holds(address, to.size())) return copy(map_.identity, identity());
    if (map_.command.holds(address, to.size())) return copy(map_.command, command_);
    if (map_.stop.holds(address, to.size())) return copy(map_.stop, stop_);
    if (map_.path.holds(address, to.size())) return copy(map_.path, path_);
    if (map_.exchange.holds(address, to.size())) return copy(map_.exchange, exchange_);
    return ModbusException::illegal_address;
}

ModbusException RegisterBank::write(std::size_t address, std::span<const std::uint16_t> from) {
    if (const std::uint8_t refusal = controller_.take_refusal(); refusal != 0) return ModbusException{refusal};
    if (map_.exchange.holds(address, from.size())) return write_exchange(address - map_.exchange.address, from);
    if (map_.command.holds(address, from.size()))
        return from.size() == map_.command.length ? write_command(from) : ModbusException::illegal_value;
    if (map_.stop.holds(address, from.size())) return write_stop(from[0]);
    if (map_.path.holds(address, from.size()))
        return address == map_.path.address ? write_path(from) : ModbusException::illegal_value;
    return ModbusException::illegal_address;
}

ModbusException RegisterBank::write_command(std::span<const std::uint16_t> from) {
    const RegisterMap::Command& at = map_.command;
    if (block_crc(from, at.crc) != from[at.crc] || from[at.seq] == 0) return ModbusException::illegal_value;
    command_.assign(from.begin(), from.end());
    Command command;
    command.seq = from[at.seq];
    command.opcode = from[at.opcode];
    command.owner = get32(from, at.owner, map_.big_words);
    for (std::size_t i = 0; i < command.args.size(); ++i)
        command.args[i] = static_cast<std::int32_t>(get32(from, at.args + 2 * i, map_.big_words));
    controller_.command(command);
    return ModbusException::none;
}

ModbusException RegisterBank::write_stop(std::uint16_t kind) {
    if (kind != code(StopKind::controlled) && kind != code(StopKind::emergency)) return ModbusException::illegal_value;
    stop_[0] = kind;
    controller_.stop(static_cast<StopKind>(kind));
    return ModbusException::none;
}

PathPoint RegisterBank::path_point(std::span<const std::uint16_t> registers) const {
    const RegisterMap::Path& at = map_.path;
    PathPoint point;
    for (int axis = 0; axis < 3; ++axis) {
        const auto i = static_cast<std::size_t>(axis);
        const auto counts = static_cast<std::int32_t>(get32(registers, at.position + 2 * i, map_.big_words));
        point.position[axis] = counts * controller_.options().machine.lsb_mm;
        point.normal[axis] = static_cast<std::int16_t>(registers[at.normal + i]) / map_.normal;
    }
    point.speed_mm_s = registers[at.speed] * map_.speed_mm_s;
    point.record = (registers[at.flags] & 1U) != 0;
    point.last = (registers[at.flags] & 2U) != 0;
    return point;
}

ModbusException RegisterBank::write_path(std::span<const std::uint16_t> from) {
    const RegisterMap::Path& at = map_.path;
    if (from.size() < at.header) return ModbusException::illegal_value;
    const std::size_t count = from[at.count];
    if (count < 1 || count > map_.path_window || from.size() != at.header + count * at.point_length)
        return ModbusException::illegal_value;
    if (block_crc(from, at.crc) != from[at.crc]) return ModbusException::illegal_value;
    std::vector<PathPoint> points;
    for (std::size_t i = 0; i < count; ++i)
        points.push_back(path_point(from.subspan(at.header + i * at.point_length, at.point_length)));
    switch (controller_.append_path(from[at.path], get32(from, at.first_index, map_.big_words), points)) {
        case ScanPath::Append::invalid:
            return ModbusException::illegal_value;
        case ScanPath::Append::full:
            return ModbusException::busy;
        default:
            break;
    }
    std::copy(from.begin(), from.end(), path_.begin());
    return ModbusException::none;
}

ModbusException RegisterBank::write_exchange(std::size_t offset, std::span<const std::uint16_t> from) {
    const RegisterMap::Exchange& at = map_.exchange;
    const bool whole = from.size() == at.length;
    if (!whole && !(from.size() == 1 && offset == at.watchdog)) return ModbusException::illegal_value;
    Image changed = exchange_;
    std::copy(from.begin(), from.end(), changed.begin() + static_cast<std::ptrdiff_t>(offset));
    if (whole && !controller_.acknowledge(get32(changed, at.ack_seq, map_.big_words)))
        return ModbusException::illegal_value;
    exchange_ = changed;
    controller_.feed_watchdog(exchange_[at.watchdog]);
    return ModbusException::none;
}

}  // namespace cmm::sim
