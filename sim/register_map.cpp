// SPDX-License-Identifier: Apache-2.0
#include "sim/register_map.hpp"

#include <algorithm>
#include <array>

#include "core/config.hpp"

namespace cmm::sim {
namespace {

using core::ConfigTable;

constexpr std::size_t most_write_registers = 123;  // of FC 16 (Modbus application protocol 1.1b3, 6.12)
constexpr std::size_t point_registers = 11;
constexpr std::size_t sample_registers = 8;

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
};

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
    to.state = in.field("state");
    to.heartbeat = in.field("heartbeat");
    to.flags = in.field("flags");
    to.fault = in.field("fault");
    to.command_seq = in.field("command_seq");
    to.command_state = in.field("command_state");
    to.result = in.field("result");
    to.values = in.field("values", 8);
    to.active_path = in.field("active_path");
    to.path_recorded = in.field("path_recorded", 2);
    to.path_received = in.field("path_received", 2);
    to.newest_seq = in.field("newest_seq", 2);
    to.acked_seq = in.field("acked_seq", 2);
    to.position = in.field("position", 6);
    to.fifo_level = in.field("fifo_level");
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
    if (map.path.point_length != point_registers) path.complain("point_length", "must be 11");
    const std::size_t room = most_write_registers - std::min(most_write_registers, map.path.header);
    map.path_window = room / point_registers;
    map.path.length = map.path.header + map.path_window * point_registers;

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
    to.state = in.field("state");
    to.heartbeat = in.field("heartbeat");
    to.path = in.field("path");
    to.first_seq = in.field("first_seq", 2);
    to.newest_seq = in.field("newest_seq", 2);
    to.count = in.field("count");
    to.flags = in.field("flags");
    to.time_us = in.field("time_us", 3);
    to.crc = in.field("crc");
    to.points = in.field("points", sample_registers);
    to.point_length = whole(in.table, "point_length", 125);
    if (to.point_length != sample_registers) in.table.complain("point_length", "must be 8");
    map.fifo_window = (to.length - std::min(to.length, to.points)) / sample_registers;
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
