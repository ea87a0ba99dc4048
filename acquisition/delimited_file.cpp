// SPDX-License-Identifier: Apache-2.0
#include "acquisition/delimited_file.hpp"

#include <algorithm>

#include "core/text.hpp"

namespace cmm::acquisition {
namespace {

using core::ErrorCode;

std::string_view unquoted(std::string_view text) {
    if (text.size() >= 2 && text.front() == text.back() && (text.front() == '"' || text.front() == '\'')) {
        return core::trim(text.substr(1, text.size() - 2));
    }
    return text;
}

/// "X [mm]", "x(mm)", "X mm" and "x_mm" are one name.
std::string header_name(std::string_view text) {
    std::string name;
    for (const char c : core::in_small_letters(unquoted(text))) {
        if (c == ']' || c == ')') continue;
        const bool gap = c == ' ' || c == '[' || c == '(' || c == '_';
        if (!gap) {
            name += c;
        } else if (!name.empty() && name.back() != '_') {
            name += '_';
        }
    }
    return name;
}

char separator_of(std::string_view line) {
    for (const char candidate : {';', ','}) {
        if (line.find(candidate) != std::string_view::npos) return candidate;
    }
    return ' ';
}

std::vector<DelimitedCell> cells_of(std::string_view line, char separator) {
    std::vector<DelimitedCell> cells;
    for (const auto field : core::split(line, separator)) {
        // An empty field has no place of its own in the line.
        const std::size_t column =
            field.empty() ? line.size() : static_cast<std::size_t>(field.data() - line.data()) + 1;
        cells.push_back({unquoted(field), column});
    }
    return cells;
}

bool is_word_for_no_number(std::string_view text) {
    std::string word = core::in_small_letters(text);
    if (!word.empty() && (word.front() == '-' || word.front() == '+')) word.erase(0, 1);
    return word == "nan" || word == "inf" || word == "infinity";
}

/// A header has no field that is a number or stands for one.
bool is_header(const std::vector<DelimitedCell>& cells) {
    return std::none_of(cells.begin(), cells.end(), [](const DelimitedCell& cell) {
        return core::parse_number(cell.text).has_value() || is_word_for_no_number(cell.text);
    });
}

bool has_decimal_comma(std::string_view text) {
    std::string mended(text);
    const auto comma = mended.find(',');
    if (comma == std::string::npos) return false;
    mended[comma] = '.';
    return core::parse_number(mended).has_value();
}

}  // namespace

std::string place(const std::string& name, std::size_t line, std::size_t column) {
    return name + ":" + std::to_string(line) + ":" + std::to_string(column) + ": ";
}

std::string_view without_comment(std::string_view line, std::string_view& comment) {
    const auto at = std::min(line.find('#'), line.find("//"));
    if (at == std::string_view::npos) return core::trim(line).empty() ? std::string_view{} : line;
    comment = core::trim(line.substr(
        line.find_first_not_of("#/", at) == std::string_view::npos ? line.size() : line.find_first_not_of("#/", at)));
    line = line.substr(0, at);
    return core::trim(line).empty() ? std::string_view{} : line;
}

std::vector<std::string_view> text_lines(std::string_view content) {
    if (content.starts_with("\xEF\xBB\xBF")) content.remove_prefix(3);
    const char end = content.find('\n') == std::string_view::npos ? '\r' : '\n';
    std::vector<std::string_view> lines;
    while (!content.empty()) {
        const auto at = content.find(end);
        auto line = content.substr(0, at);
        if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
        lines.push_back(line);
        content.remove_prefix(at == std::string_view::npos ? content.size() : at + 1);
    }
    return lines;
}

core::Status require_text(std::string_view content, const std::string& name) {
    if (core::trim(content).empty()) return core::fail(ErrorCode::input_invalid, name + ": the file is empty");
    const bool utf16 = content.starts_with("\xFF\xFE") || content.starts_with("\xFE\xFF");
    const auto strange = std::find_if(content.begin(), content.end(), [](char c) {
        const auto byte = static_cast<unsigned char>(c);
        return byte < 0x20 && c != '\n' && c != '\r' && c != '\t' && c != '\f';
    });
    if (utf16) return core::fail(ErrorCode::input_invalid, name + ": the file is UTF-16; save it as UTF-8");
    if (strange == content.end()) return {};
    return core::fail(ErrorCode::input_invalid, name + ": not a text file (byte " +
                                                    std::to_string(static_cast<unsigned char>(*strange)) +
                                                    " at offset " + std::to_string(strange - content.begin()) + ")");
}

core::Result<DelimitedTable> read_delimited(std::string_view content, const std::string& name) {
    if (auto status = require_text(content, name); !status) return tl::unexpected(status.error());
    DelimitedTable table;
    const auto lines = text_lines(content);
    std::size_t width = 0;
    for (std::size_t i = 0; i < lines.size(); ++i) {
        std::string_view comment;
        const auto line = without_comment(lines[i], comment);
        if (!comment.empty()) table.comments.push_back(comment);
        if (line.empty()) continue;
        const bool first = width == 0;
        if (first) table.separator = separator_of(line);
        auto cells = cells_of(line, table.separator);
        if (first) width = cells.size();
        if (cells.size() == width + 1 && cells.back().text.empty()) cells.pop_back();
        if (cells.size() != width) {
            std::string text = place(name, i + 1, 1) + std::to_string(cells.size()) +
                               " fields where the first row has " + std::to_string(width);
            if (table.separator == ',' && cells.size() == 2 * width) {
                text += "; decimal commas? Numbers are written with a point: 1.5";
            }
            return core::fail(ErrorCode::input_invalid, std::move(text));
        }
        if (first && is_header(cells)) {
            for (const auto& cell : cells)
                table.header.push_back(header_name(cell.text));
        } else {
            table.rows.push_back({i + 1, std::move(cells)});
        }
    }
    return table;
}

core::Result<double> cell_number(const DelimitedCell& cell, std::string_view what, const std::string& name,
                                 std::size_t line) {
    if (const auto value = core::parse_number(cell.text)) return *value;
    std::string text = place(name, line, cell.column) + std::string(what);
    if (cell.text.empty()) {
        text += " is empty";
    } else if (is_word_for_no_number(cell.text)) {
        text += " is not a finite number: '" + std::string(cell.text) + "'";
    } else {
        text += " is not a number: '" + std::string(cell.text.substr(0, 40)) + "'";
        if (has_decimal_comma(cell.text)) text += "; decimal comma? Numbers are written with a point: 1.5";
    }
    return core::fail(ErrorCode::input_invalid, std::move(text));
}

}  // namespace cmm::acquisition
