// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "acquisition/delimited_file.hpp"
#include "core/error.hpp"

/// What nominal files (.NOM) and tolerance files (.TOL) have in common: lines that begin with a keyword.
namespace cmm::acquisition {

constexpr double mm_of_inch = 25.4;

/// The fields of a line, at least one; the views point into the text that was read.
struct KeywordLine {
    std::size_t number = 0;
    std::vector<DelimitedCell> cells;

    /// The first field in capitals.
    std::string keyword() const;
};

/// A text of keywords with the name that its errors begin with. It must outlive its lines.
class KeywordFile {
  public:
    /// Lines without blanks and comments ('!' to the end of the line, lines that begin with '#' or "//"); fields are
    /// parted by blanks, tabs, ',' and ';'. Errors: input_invalid (no text, nothing in it).
    static core::Result<KeywordFile> read(std::string_view content, const std::string& name);

    const std::vector<KeywordLine>& lines() const { return lines_; }
    /// input_invalid "file:line:column: what" at a field (past the last: at the last).
    tl::unexpected<core::Error> wrong(const KeywordLine& line, std::size_t field, const std::string& what) const;
    /// The field as a number. Errors: input_invalid where it is none or not there.
    core::Result<double> number(const KeywordLine& line, std::size_t field, std::string_view what) const;
    /// A whole number within the bounds.
    core::Result<std::size_t> count(const KeywordLine& line, std::size_t field, std::string_view what, std::size_t low,
                                    std::size_t high) const;
    /// Whether a line "UNITS ..." says inches.
    core::Result<bool> inches(const KeywordLine& line) const;
    /// input_invalid where the line has more fields than `most`.
    core::Status at_most(const KeywordLine& line, std::size_t most) const;

  private:
    std::string name_;
    std::vector<KeywordLine> lines_;
};

std::string in_capitals(std::string_view text);
/// Whether the word is in the list, in capitals or not.
bool lists_word(std::span<const std::string> words, std::string_view word);

}  // namespace cmm::acquisition
