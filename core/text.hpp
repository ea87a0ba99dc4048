// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/error.hpp"

/// Text in and out, the same everywhere and independent of the locale.
namespace cmm::core {

/// The whole of `text` as a finite number, or nothing. Leading '+' is allowed; 'nan', 'inf' and hex are not.
std::optional<double> parse_number(std::string_view text) noexcept;
/// Fixed notation with `digits` decimals, never "-0.000".
std::string fixed(double value, int digits);
/// The same with a sign before it, also of what is not negative.
std::string signed_fixed(double value, int digits);
/// A length for people: "12.345 mm" from a tenth of a millimetre up, "3.2 um" below. Takes millimetres.
std::string length_text(double mm);

std::string_view trim(std::string_view text) noexcept;
/// A to Z as a to z; every other byte as it is, whatever the locale.
std::string in_small_letters(std::string_view text);
/// Splits at `separator` (',' ';' '\t') or, for ' ', at runs of white space. Fields are trimmed.
std::vector<std::string_view> split(std::string_view line, char separator);
/// The candidate nearest to `word` by edit distance (at most a third of its length), for "did you mean ...?".
std::optional<std::string> nearest_word(std::string_view word, std::span<const std::string_view> candidates);

/// The whole file; errors: input_missing.
Result<std::string> read_file(const std::string& path);
/// Writes beside and renames, so that a reader never sees half a file; errors: journal_io, journal_full.
Status write_file(const std::string& path, std::string_view content);

}  // namespace cmm::core
