// SPDX-License-Identifier: Apache-2.0
#include "drivers/modbus/register_map.hpp"

#include <algorithm>

#include "core/config.hpp"
#include "core/units.hpp"
#include "drivers/modbus/crc16.hpp"

namespace cmm::drivers::modbus {
namespace {

/// Reads one block of the map: every key is required, every field must lie inside the block.
class BlockReader {
  public:
    BlockReader(const core::ConfigTable& root, std::string_view name) : table_(root.table(name)), length_(max_read) {}

    BlockReader& address(std::uint16_t& target) { return number("address", target, 0xFFFF); }
    BlockReader& length(std::uint16_t& target, std::size_t least, std::size_t most) {
        number("length", target, most);
        if (target < least) table_.complain("length", "must be at least " + std::to_string(least));
        length_ = target;
        return *this;
    }
    /// For blocks whose length is not a key of the file.
    BlockReader& fixed_length(std::size_t registers) {
        length_ = registers;
        return *this;
    }
    /// A length that the protocol fixes; the file may state it.
    BlockReader& stated_length(std::size_t registers) {
        const auto value = static_cast<double>(registers);
        table_.integer("length", static_cast<std::int64_t>(registers), {value, value});
        return fixed_length(registers);
    }
    BlockReader& field(std::string_view key, std::uint16_t& target, std::size_t registers = 1) {
        number(key, target, 0xFFFF);
        if (target + registers > length_) {
            table_.complain(key, "reaches beyond the block's " + std::to_string(length_) + " registers");
        }
        return *this;
    }
    /// An offset, or { at, words, bit, bits } for a number that shares its register with others.
    BlockReader& field(std::string_view key, Field& target, std::uint16_t most_words = 1) {
        if (!table_.has_table(key)) {
            target.words = most_words;
            target.bits = static_cast<std::uint16_t>(16 * most_words);
            return field(key, target.at, most_words);
        }
        const core::ConfigTable part = table_.table(key);
        const auto read = [&part](std::string_view name, std::int64_t fallback, double low, double high) {
            return static_cast<std::uint16_t>(part.integer(name, fallback, {low, high}));
        };
        target.at = static_cast<std::uint16_t>(part.required_integer("at", {0.0, 65535.0}));
        target.words = read("words", 1, 1.0, most_words);
        target.shift = read("bit", 0, 0.0, 15.0);
        const int left = 16 * target.words - target.shift;
        target.bits = read("bits", left, 1.0, left);
        if (target.at + std::size_t{target.words} > length_) {
            table_.complain(key, "reaches beyond the block's " + std::to_string(length_) + " registers");
        }
        return *this;
    }
    /// A register of a point, in a table of its own that need not be there.
    void in_point(std::string_view point, std::string_view key, std::uint16_t& target, std::size_t registers,
                  std::size_t point_length) const {
        const core::ConfigTable of_point = table_.table(point);
        target = static_cast<std::uint16_t>(of_point.integer(key, target, {0.0, 65535.0}));
        if (target + registers > point_length) of_point.complain(key, "lies behind the end of the point");
    }
    BlockReader& number(std::string_view key, std::uint16_t& target, std::size_t most, std::size_t least = 0) {
        const core::Bounds bounds{static_cast<double>(least), static_cast<double>(most)};
        target = static_cast<std::uint16_t>(table_.required_integer(key, bounds));
        return *this;
    }

  private:
    core::ConfigTable table_;
    std::size_t length_;
};

void read_identity(const core::ConfigTable& root, RegisterMap::Identity& at) {
    BlockReader(root, "identity")
        .address(at.address)
        .length(at.length, 1, max_read)
        .field("magic", at.magic, 2)
        .field("map_version", at.map_version)
        .field("firmware", at.firmware)
        .field("model", at.model, 8)
        .field("serial", at.serial, 8)
        .field("lsb_nm", at.lsb_nm)
        .field("sample_rate_hz", at.sample_rate_hz)
        .field("fifo_depth", at.fifo_depth)
        .field("path_capacity", at.path_capacity)
        .field("path_window", at.path_window)
        .field("watchdog_ms", at.watchdog_ms)
        .field("capabilities", at.capabilities)
        .field("deflection_lsb_um", at.deflection_lsb_um)
        .field("limit_min", at.limit_min, 6)
        .field("limit_max", at.limit_max, 6)
        .field("max_speed_um_s", at.max_speed_um_s, 2)
        .field("max_accel_um_s2", at.max_accel_um_s2, 2)
        .field("boot_id", at.boot_id)
        .field("crc", at.crc);
}

void read_status(const core::ConfigTable& root, RegisterMap::Status& at) {
    BlockReader(root, "status")
        .address(at.address)
        .length(at.length, 1, max_read)
        .field("state", at.state)
        .field("heartbeat", at.heartbeat)
        .field("flags", at.flags)
        .field("fault", at.fault)
        .field("command_seq", at.command_seq)
        .field("command_state", at.command_state)
        .field("result", at.result)
        .field("values", at.values, 8)
        .field("active_path", at.active_path)
        .field("path_recorded", at.path_recorded, std::uint16_t{2})
        .field("path_received", at.path_received, std::uint16_t{2})
        .field("newest_seq", at.newest_seq, 2)
        .field("acked_seq", at.acked_seq, 2)
        .field("position", at.position, 6)
        .field("fifo_level", at.fifo_level)
        .field("time_us", at.time_us, 3)
        .field("owner", at.owner, 2)
        .field("crc", at.crc);
}

void read_written_blocks(const core::ConfigTable& root, RegisterMap& map) {
    BlockReader(root, "command")
        .address(map.command.address)
        .length(map.command.length, 1, max_write)
        .field("seq", map.command.seq)
        .field("opcode", map.command.opcode)
        .field("owner", map.command.owner, 2)
        .field("args", map.command.args, 16)
        .field("crc", map.command.crc);
    BlockReader(root, "stop").address(map.stop.address);
    BlockReader path(root, "path");
    path.address(map.path.address).number("header", map.path.header, 32, 1);
    path.fixed_length(map.path.header)
        .field("path", map.path.path)
        .field("first_index", map.path.first_index, 2)
        .field("count", map.path.count)
        .field("crc", map.path.crc)
        .field("reserved", map.path.reserved)
        .number("point_length", map.path.point_length, max_write - 32, 11);
    path.in_point("point", "position", map.path.position, 6, map.path.point_length);
    path.in_point("point", "normal", map.path.normal, 3, map.path.point_length);
    path.in_point("point", "speed", map.path.speed, 1, map.path.point_length);
    path.in_point("point", "flags", map.path.flags, 1, map.path.point_length);
    BlockReader(root, "exchange")
        .stated_length(exchange_length)
        .address(map.exchange.address)
        .field("watchdog", map.exchange.watchdog)
        .field("ack_seq", map.exchange.ack_seq, 2)
        .field("from_seq", map.exchange.from_seq, 2);
}

void read_fifo(const core::ConfigTable& root, RegisterMap::Fifo& at) {
    BlockReader fifo(root, "fifo");
    fifo.address(at.address)
        .length(at.length, 1, max_read)
        .field("state", at.state)
        .field("heartbeat", at.heartbeat)
        .field("path", at.path)
        .field("first_seq", at.first_seq, 2)
        .field("newest_seq", at.newest_seq, 2)
        .field("count", at.count)
        .field("flags", at.flags)
        .field("time_us", at.time_us, 3)
        .field("crc", at.crc)
        .field("points", at.points)
        .number("point_length", at.point_length, max_read, 8);
    fifo.in_point("point", "position", at.position, 6, at.point_length);
    fifo.in_point("point", "dt", at.dt, 1, at.point_length);
    fifo.in_point("point", "quality", at.quality, 1, at.point_length);
}

void read_scale(const core::ConfigTable& table, RegisterMap::Scale& scale) {
    scale.count_mm = table.number("count_nm", 0.0, {0.0, 1e6}) * 1e-6;
    scale.speed_mm_s = core::mm_from_um(table.number("speed_um_s", core::um_from_mm(scale.speed_mm_s), {1e-3, 1e6}));
    scale.normal = table.number("normal", scale.normal, {100.0, 32767.0});
    scale.dt_us = table.integer("dt_us", scale.dt_us, {1.0, 1e6});
}

}  // namespace

std::uint16_t crc16(std::span<const std::uint16_t> registers, std::size_t skip) noexcept {
    Crc16 crc;
    for (std::size_t k = 0; k < registers.size(); ++k) {
        if (k == skip) continue;
        crc.feed(static_cast<std::uint8_t>(registers[k] >> 8U));
        crc.feed(static_cast<std::uint8_t>(registers[k] & 0xFFU));
    }
    return crc.value();
}

core::Result<RegisterMap> RegisterMap::load(const std::string& file) {
    const auto root = core::ConfigTable::load(file);
    if (!root) return tl::unexpected(root.error());
    RegisterMap map;
    const auto header = root->table("map");
    map.name = header.required_text("name");
    map.version = static_cast<std::uint16_t>(header.required_integer("version", {1, 0xFFFF}));
    map.high_word_first = header.word("word_order", "big", {"big", "little"}) == "big";
    read_identity(*root, map.identity);
    read_status(*root, map.status);
    read_written_blocks(*root, map);
    read_fifo(*root, map.fifo);
    read_scale(root->table("scale"), map.scale);
    if (auto done = root->finish(); !done) return tl::unexpected(done.error());
    return map;
}

std::uint32_t RegisterMap::value(std::span<const std::uint16_t> block, const Field& field) const noexcept {
    const std::uint32_t registers = field.words == 2 ? u32(block, field.at) : block[field.at];
    return field.bits == 32 ? registers : (registers >> field.shift) & ((1U << field.bits) - 1U);
}

std::uint32_t RegisterMap::unwrapped(const Field& field, std::uint32_t value, std::uint32_t near) noexcept {
    if (field.bits == 32) return value;
    const std::int64_t round = std::int64_t{1} << field.bits;
    std::int64_t ahead = (std::int64_t{value} - std::int64_t{near}) % round;
    if (ahead > round / 2) ahead -= round;
    if (ahead < -round / 2) ahead += round;
    return static_cast<std::uint32_t>(std::max<std::int64_t>(0, std::int64_t{near} + ahead));
}

std::uint32_t RegisterMap::u32(std::span<const std::uint16_t> block, std::size_t at) const noexcept {
    const std::uint32_t first = block[at];
    const std::uint32_t second = block[at + 1];
    return high_word_first ? (first << 16U) | second : (second << 16U) | first;
}

std::int32_t RegisterMap::i32(std::span<const std::uint16_t> block, std::size_t at) const noexcept {
    return static_cast<std::int32_t>(u32(block, at));
}

std::int64_t RegisterMap::u48(std::span<const std::uint16_t> block, std::size_t at) const noexcept {
    const std::int64_t first = block[at];
    const std::int64_t middle = block[at + 1];
    const std::int64_t last = block[at + 2];
    return high_word_first ? (first << 32) | (middle << 16) | last : (last << 32) | (middle << 16) | first;
}

void RegisterMap::put_u32(std::span<std::uint16_t> block, std::size_t at, std::uint32_t value) const noexcept {
    const auto high = static_cast<std::uint16_t>(value >> 16U);
    const auto low = static_cast<std::uint16_t>(value & 0xFFFFU);
    block[at] = high_word_first ? high : low;
    block[at + 1] = high_word_first ? low : high;
}

void RegisterMap::put_i32(std::span<std::uint16_t> block, std::size_t at, std::int32_t value) const noexcept {
    put_u32(block, at, static_cast<std::uint32_t>(value));
}

}  // namespace cmm::drivers::modbus
