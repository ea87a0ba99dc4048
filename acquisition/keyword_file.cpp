// SPDX-License-Identifier: Apache-2.0
#include "acquisition/keyword_file.hpp"

#include <algorithm>
#include <cmath>

#include "core/text.hpp"

namespace cmm::acquisition {
namespace {

constexpr std::string_view between_fields = " \t\f,;";

std::vector<DelimitedCell> fields_of(std::string_view line) {
    std::vector<DelimitedCell> fields;
    std::size_t at = line.find_first_not_of(between_fields);
    while (at != std::string_view::npos) {
        const std::size_t end = std::min(line.find_first_of(between_fields, at), line.size());
        fields.push_back({line.substr(at, end - at), at + 1});
        at = line.find_first_not_of(between_fields, end);
    }
    return fields;
}

}  // namespace

std::string in_capitals(std::string_view text) {
    std::string out(text);
    std::transform(out.begin(), out.end(), out.begin(),
                   [](char c) { return c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c; });
    return out;
}

bool lists_word(std::span<const std::string> words, std::string_view word) {
    return std::any_of(words.begin(), words.end(),
                       [&](const std::string& one) { return in_capitals(one) == in_capitals(word); });
}

std::string KeywordLine::keyword() const {
    return in_capitals(cells.front().text);
}

core::Result<KeywordFile> KeywordFile::read(std::string_view content, const std::string& name) {
    if (auto status = require_text(content, name); !status) return tl::unexpected(status.error());
    KeywordFile file;
    file.name_ = name;
    const auto lines = text_lines(content);
    for (std::size_t i = 0; i < lines.size(); ++i) {
        const auto line = lines[i].substr(0, lines[i].find('!'));
        const auto words = core::trim(line);
        if (words.starts_with('#') || words.starts_with("//")) continue;
        auto fields = fields_of(line);
        if (!fields.empty()) file.lines_.push_back({i + 1, std::move(fields)});
    }
    if (file.lines_.empty())
        return core::fail(core::ErrorCode::input_invalid, name + ": there is nothing but comments in it");
    return file;
}

tl::unexpected<core::Error> KeywordFile::wrong(const KeywordLine& line, std::size_t field,
                                               const std::string& what) const {
    const auto& cell = line.cells[std::min(field, line.cells.size() - 1)];
    return core::fail(core::ErrorCode::input_invalid, place(name_, line.number, cell.column) + what);
}

core::Result<double> KeywordFile::number(const KeywordLine& line, std::size_t field, std::string_view what) const {
    if (field >= line.cells.size()) return wrong(line, field, std::string(what) + " is missing on this line");
    return cell_number(line.cells[field], what, name_, line.number);
}

core::Result<std::size_t> KeywordFile::count(const KeywordLine& line, std::size_t field, std::string_view what,
                                             std::size_t low, std::size_t high) const {
    const auto value = number(line, field, what);
    if (!value) return tl::unexpected(value.error());
    if (*value >= static_cast<double>(low) && *value <= static_cast<double>(high) && *value == std::floor(*value))
        return static_cast<std::size_t>(*value);
    return wrong(line, field,
                 std::string(what) + " must be a whole number from " + std::to_string(low) + " to " +
                     std::to_string(high) + ", not '" + std::string(line.cells[field].text.substr(0, 40)) + "'");
}

core::Result<bool> KeywordFile::inches(const KeywordLine& line) const {
    const std::string unit = line.cells.size() > 1 ? in_capitals(line.cells[1].text) : "";
    if (auto status = at_most(line, 2); !status) return tl::unexpected(status.error());
    if (unit == "INCH" || unit == "IN") return true;
    if (unit == "MM") return false;
    return wrong(line, 1, "UNITS must be INCH or MM");
}

core::Status KeywordFile::at_most(const KeywordLine& line, std::size_t most) const {
    if (line.cells.size() <= most) return {};
    return wrong(
        line, most,
        "'" + std::string(line.cells[most].text.substr(0, 40)) + "' is more than " + line.keyword() + " takes");
}

}  // namespace cmm::acquisition
