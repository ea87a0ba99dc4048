// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "core/error.hpp"

namespace cmm::acquisition {

/// A field of a row and its column in the line (1-based), for messages.
struct DelimitedCell {
    std::string_view text;
    std::size_t column = 1;
};

struct DelimitedRow {
    std::size_t line = 0;
    std::vector<DelimitedCell> cells;
};

/// Rows of fields separated by ',' ';' tab or white space (the first row decides). The views point into the text that
/// was read: it must outlive the table.
struct DelimitedTable {
    std::vector<std::string> header;         ///< lower case, "x [mm]" and "x_mm" both as "x_mm"; empty: no header line
    std::vector<std::string_view> comments;  ///< what follows '#' or '//', in order
    std::vector<DelimitedRow> rows;
    char separator = ',';
};

/// "file:line:column: what".
std::string place(const std::string& name, std::size_t line, std::size_t column);
/// A whole line without its comment and line end; `comment` receives the comment if there is one.
std::string_view without_comment(std::string_view line, std::string_view& comment);
/// The lines of a text without byte-order mark, whatever its line ends (LF, CRLF, CR).
std::vector<std::string_view> text_lines(std::string_view content);
/// input_invalid when the content is no text (NUL or control bytes) or empty.
core::Status require_text(std::string_view content, const std::string& name);
/// Errors: input_invalid (not a text, empty, rows of different length).
core::Result<DelimitedTable> read_delimited(std::string_view content, const std::string& name);
/// The cell as a finite number; input_invalid says which column, and recognises nan, inf and a decimal comma.
core::Result<double> cell_number(const DelimitedCell& cell, std::string_view what, const std::string& name,
                                 std::size_t line);

}  // namespace cmm::acquisition
