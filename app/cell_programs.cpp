// SPDX-License-Identifier: Apache-2.0
#include "app/cell_programs.hpp"

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <optional>
#include <string_view>
#include <vector>

#include "core/text.hpp"

namespace cmm::app {
namespace {

namespace fs = std::filesystem;

template <class Number>
std::optional<Number> leading_number(const std::string& name) {
    Number number = 0;
    const char* const end = name.data() + name.size();
    const auto read = std::from_chars(name.data(), end, number);
    const bool ends = read.ptr == end || std::string_view("-_. ").find(*read.ptr) != std::string_view::npos;
    if (read.ec != std::errc() || !ends) return {};
    return number;
}

/// `line` sets this key, or opens this table.
bool begins_with_key(std::string_view line, std::string_view key) {
    line = core::trim(line);
    if (!line.starts_with(key)) return false;
    return core::trim(line.substr(key.size())).starts_with('=');
}

std::string put_in(const std::string& text, const std::string& serial) {
    const std::string setting = "serial = \"" + serial + "\"";
    std::string out;
    bool inside = false;
    for (std::string_view left = text; !left.empty();) {
        const auto end = left.find('\n');
        const auto line = left.substr(0, end);
        left.remove_prefix(end == std::string_view::npos ? left.size() : end + 1);
        const auto trimmed = core::trim(line);
        if (trimmed.starts_with('[')) inside = false;
        if (inside && begins_with_key(line, "serial")) continue;
        out += std::string(line) + "\n";
        if (trimmed.starts_with("[part]")) {
            inside = true;
            out += setting + "\n";
        }
    }
    return out;
}

}  // namespace

core::Result<CellPrograms> find_programs(const std::string& folder) {
    std::error_code code;
    std::vector<std::string> files;
    for (fs::directory_iterator entry(folder, code), end; !code && entry != end; entry.increment(code))
        files.push_back(entry->path().string());
    if (code) return core::fail(core::ErrorCode::input_missing, folder + ": cannot be listed: " + code.message());
    std::sort(files.begin(), files.end());
    CellPrograms programs;
    for (const auto& file : files) {
        const fs::path path(file);
        const auto number = leading_number<std::uint16_t>(path.filename().string());
        if (!number || path.extension() != ".toml") continue;
        const auto [known, fresh] = programs.emplace(*number, file);
        if (!fresh) {
            return core::fail(core::ErrorCode::usage, "program " + std::to_string(*number) +
                                                          " is there twice: " + known->second + " and " + file);
        }
    }
    if (!programs.empty()) return programs;
    return core::fail(core::ErrorCode::input_missing,
                      folder + ": no part file begins with a program number, e.g. 7-rotor.toml");
}

core::Result<acquisition::PartFile> part_with_serial(const std::string& file, const std::string& serial) {
    const auto plain = acquisition::load_part_to_measure(file);
    if (!plain || plain->serial == serial) return plain;
    auto part = acquisition::parse_part_file(put_in(plain->text, serial), file);
    if (part && part->serial == serial && part->name == plain->name) return part;
    return core::fail(core::ErrorCode::config_invalid,
                      file + ": no serial number can be put in: it wants a table [part] on a line of its own");
}

std::uint32_t last_run_in(const std::string& folder) {
    std::uint32_t last = 0;
    std::error_code code;
    for (fs::directory_iterator entry(folder, code), end; !code && entry != end; entry.increment(code))
        last = std::max(last, leading_number<std::uint32_t>(entry->path().filename().string()).value_or(0));
    return last;
}

std::string run_folder_name(std::uint32_t run, const std::string& serial) {
    char number[16];
    std::snprintf(number, sizeof number, "%06u", run);
    std::string name = number;
    if (!serial.empty()) name += "-";
    constexpr std::string_view kept = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-";
    for (const char letter : serial)
        name += kept.find(letter) != std::string_view::npos ? letter : '_';
    return name;
}

}  // namespace cmm::app
