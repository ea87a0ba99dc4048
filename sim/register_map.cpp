// SPDX-License-Identifier: Apache-2.0
#include "sim/register_map.hpp"

#include <algorithm>
#include <array>

#include "core/config.hpp"

namespace cmm::sim {
namespace {

using core::ConfigTable;

constexpr std::size_t most_write_registers = 123;  // of FC 16 (Modbus application protocol 1.1b3, 6.12)
constexpr std::size_t point_registers = 11;        // position 6, normal 3, speed, flags
constexpr std::size_t sample_registers = 8;        // position 6, time, quality

std::size_t whole(const ConfigTable& table, const char* key, double high) {
    return static_cast<std::size_t>(std::max<std::int64_t>(0, table.required_integer(key, {0, high})));
}

/// One table of the map: reads offsets and checks that each field of `width` registers lies inside the block.
struct BlockReader {
    ConfigTable table;
    std::size_t length = 0;

    BlockReader(const ConfigTable& root, const char* name, RegisterMap::Block& block) : table(root.table(name)) {
        block.address = whole(table, "address", 65535);
        block.length = length = whole(table, "length", 125);
    }
    std::size_t field(const char* key, std::size_t width = 1) const {
        const std::size_t at = whole(table, key, 65535);
        if (at + width > length) table.complain(key, "does not fit into its block");
        return at;
    }
    /// An offset, or { at, words, bit, bits }.
    RegisterMap::Place place(const char* key, std::size_t width = 1) const {
        RegisterMap::Place to{0, width, 0, static_cast<unsigned>(16 * width)};
        if (!table.has_table(key)) {
            to.at = field(key, width);
            return to;
        }
        const ConfigTable in = table.table(key);
        to.at = whole(in, "at", 65535);
        to.words = static_cast<std::size_t>(in.integer("words", 1, {1, static_cast<double>(width)}));
        to.bit = static_cast<unsigned>(in.integer("bit", 0, {0, 15}));
        const auto left = static_cast<std::int64_t>(16 * to.words - to.bit);
        to.bits = static_cast<unsigned>(in.integer("bits", left, {1, static_cast<double>(left)}));
        if (to.at + to.words > length) table.complain(key, "does not fit into its block");
        return to;
    }
};

/// A register of a point; [block.point] may be absent, as in version 1.
std::size_t in_point(const ConfigTable& block, const char* key, std::size_t fallback, std::size_t width,
                     std::size_t length) {
    const ConfigTable point = block.table("point");
    const auto at = static_cast<std::size_t>(point.integer(key, static_cast<std::int64_t>(fallback), {0, 125}));
    if (at + width > length) point.complain(key, "does not fit into the point");
    return at;
}

void read_identity(const ConfigTable& root, RegisterMap::Identity& to) {
    const BlockReader in(root, "identity", to);
    to.magic = in.field("magic", 2);
    to.map_version = in.field("map_version");
    to.firmware = in.field("firmware");
    to.model = in.field("model", 8);
    to.serial = in.field("serial", 8);
    to.lsb_nm = in.field("lsb_nm");
    to.sample_rate_hz = in.field("sample_rate_hz");
    to.fifo_depth = in.field("fifo_depth");
    to.path_capacity = in.field("path_capacity");
    to.path_window = in.field("path_window");
    to.watchdog_ms = in.field("watchdog_ms");
    to.capabilities = in.field("capabilities");
    to.deflection_lsb_um = in.field("deflection_lsb_um");
    to.limit_min = in.field("limit_min", 6);
    to.limit_max = in.field("limit_max", 6);
    to.max_speed_um_s = in.field("max_speed_um_s", 2);
    to.max_accel_um_s2 = in.field("max_accel_um_s2", 2);
    to.boot_id = in.field("boot_id");
    to.crc = in.field("crc");
}

void read_status(const ConfigTable& root, RegisterMap::Status& to) {
    const BlockReader in(root, "status", to);
    to.state = in.place("state");
    to.heartbeat = in.field("heartbeat");
    to.flags = in.place("flags");
    to.fault = in.place("fault");
    to.command_seq = in.field("command_seq");
    to.command_state = in.place("command_state");
    to.result = in.place("result");
    to.values = in.field("values", 8);
    to.active_path = in.field("active_path");
    to.path_recorded = in.place("path_recorded", 2);
    to.path_received = in.place("path_received", 2);
    to.newest_seq = in.field("newest_seq", 2);
    to.acked_seq = in.field("acked_seq", 2);
    to.position = in.field("position", 6);
    to.fifo_level = in.place("fifo_level");
    to.time_us = in.field("time_us", 3);
    to.owner = in.field("owner", 2);
    to.crc = in.field("crc");
}

void read_written_blocks(const ConfigTable& root, RegisterMap& map) {
    const BlockReader command(root, "command", map.command);
    map.command.seq = command.field("seq");
    map.command.opcode = command.field("opcode");
    map.command.owner = command.field("owner", 2);
    map.command.args = command.field("args", 16);
    map.command.crc = command.field("crc");

    map.stop = {whole(root.table("stop"), "address", 65535), 1};

    const ConfigTable path = root.table("path");
    map.path.address = whole(path, "address", 65535);
    map.path.header = whole(path, "header", 64);
    map.path.path = whole(path, "path", 64);
    map.path.first_index = whole(path, "first_index", 64);
    map.path.count = whole(path, "count", 64);
    map.path.crc = whole(path, "crc", 64);
    map.path.point_length = whole(path, "point_length", 64);
    whole(path, "reserved", 64);
    if (std::max({map.path.path, map.path.first_index + 1, map.path.count, map.path.crc}) >= map.path.header)
        path.complain("header", "is too short for its fields");
    if (map.path.point_length < point_registers) path.complain("point_length", "must be 11 or more");
    map.path.position = in_point(path, "position", 0, 6, map.path.point_length);
    map.path.normal = in_point(path, "normal", 6, 3, map.path.point_length);
    map.path.speed = in_point(path, "speed", 9, 1, map.path.point_length);
    map.path.flags = in_point(path, "flags", 10, 1, map.path.point_length);
    const std::size_t room = most_write_registers - std::min(most_write_registers, map.path.header);
    map.path_window = room / std::max(point_registers, map.path.point_length);
    map.path.length = map.path.header + map.path_window * map.path.point_length;

    const ConfigTable exchange = root.table("exchange");
    RegisterMap::Exchange& to = map.exchange;
    to.address = whole(exchange, "address", 65535);
    to.watchdog = whole(exchange, "watchdog", 64);
    to.ack_seq = whole(exchange, "ack_seq", 64);
    to.from_seq = whole(exchange, "from_seq", 64);
    to.length = std::max({to.watchdog + 1, to.ack_seq + 2, to.from_seq + 2});
}

void read_fifo(const ConfigTable& root, RegisterMap& map) {
    const BlockReader in(root, "fifo", map.fifo);
    RegisterMap::Fifo& to = map.fifo;
    to.state = in.place("state");
    to.heartbeat = in.field("heartbeat");
    to.path = in.field("path");
    to.first_seq = in.field("first_seq", 2);
    to.newest_seq = in.field("newest_seq", 2);
    to.count = in.field("count");
    to.flags = in.place("flags");
    to.time_us = in.field("time_us", 3);
    to.crc = in.field("crc");
    to.points = in.field("points", sample_registers);
    to.point_length = whole(in.table, "point_length", 125);
    if (to.point_length < sample_registers) in.table.complain("point_length", "must be 8 or more");
    to.position = in_point(in.table, "position", 0, 6, to.point_length);
    to.dt = in_point(in.table, "dt", 6, 1, to.point_length);
    to.quality = in_point(in.table, "quality", 7, 1, to.point_length);
    map.fifo_window = (to.length - std::min(to.length, to.points)) / std::max(sample_registers, to.point_length);
}

}  // namespace

core::Result<RegisterMap> load_register_map(const std::string& file) {
    const auto root = ConfigTable::load(file);
    if (!root) return tl::unexpected(root.error());
    RegisterMap map;
    const ConfigTable header = root->table("map");
    header.required_text("name");
    map.version = static_cast<std::uint16_t>(header.required_integer("version", {1, 65535}));
    map.big_words = header.word("word_order", "big", {"big", "little"}) == "big";
    read_identity(*root, map.identity);
    read_status(*root, map.status);
    read_written_blocks(*root, map);
    read_fifo(*root, map);
    const ConfigTable scale = root->table("scale");
    map.count_mm = scale.number("count_nm", 0, {0, 1e6}) * 1e-6;
    map.speed_mm_s = scale.number("speed_um_s", 10, {1e-3, 1e6}) * 1e-3;
    map.normal = scale.number("normal", map.normal, {100, 32767});
    map.dt_us = scale.integer("dt_us", map.dt_us, {1, 1e6});
    std::array<RegisterMap::Block, 7> blocks{map.identity, map.status,   map.command, map.stop,
                                             map.path,     map.exchange, map.fifo};
    std::sort(blocks.begin(), blocks.end(), [](const auto& a, const auto& b) { return a.address < b.address; });
    for (std::size_t i = 0; i + 1 < blocks.size(); ++i)
        if (blocks[i].address + blocks[i].length > blocks[i + 1].address)
            root->complain("map", "the blocks at " + std::to_string(blocks[i].address) + " and " +
                                      std::to_string(blocks[i + 1].address) + " overlap");
    if (const auto status = root->finish(); !status) return tl::unexpected(status.error());
    return map;
}

}  // namespace cmm::sim
