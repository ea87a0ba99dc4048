// SPDX-License-Identifier: Apache-2.0
#include "core/toml_text.hpp"

namespace cmm::core {
namespace {

constexpr std::string_view byte_order_mark = "\xEF\xBB\xBF";

/// Where a string that begins at `at` ends: behind its last mark, or at the end of its line (of the text, where it may
/// go over lines) when it is not closed.
std::size_t behind_string(std::string_view text, std::size_t at) noexcept {
    const char mark = text[at];
    const std::string_view three = mark == '"' ? R"(""")" : "'''";
    const bool over_lines = text.substr(at, 3) == three;
    at += over_lines ? 3 : 1;
    while (at < text.size()) {
        if (mark == '"' && text[at] == '\\') {
            at += 2;
        } else if (over_lines && text.substr(at, 3) == three) {
            at += 3;
            while (at < text.size() && text[at] == mark)  // up to two more marks belong to the string
                ++at;
            return at;
        } else if (!over_lines && (text[at] == mark || text[at] == '\n')) {
            return text[at] == mark ? at + 1 : at;
        } else {
            ++at;
        }
    }
    return text.size();
}

TextPlace place_of(std::string_view text, std::size_t at) noexcept {
    TextPlace place;
    for (std::size_t k = 0; k < at; ++k) {
        ++place.column;
        if (text[k] == '\n') place = {place.line + 1, 1};
    }
    return place;
}

}  // namespace

std::optional<TextPlace> first_foreign_letter(std::string_view toml) noexcept {
    std::size_t at = toml.starts_with(byte_order_mark) ? byte_order_mark.size() : 0;
    while (at < toml.size()) {
        const char c = toml[at];
        if (c == '#') {
            at = toml.find('\n', at);
        } else if (c == '"' || c == '\'') {
            at = behind_string(toml, at);
        } else if (static_cast<unsigned char>(c) >= 0x80) {
            return place_of(toml, at);
        } else {
            ++at;
        }
    }
    return std::nullopt;
}

}  // namespace cmm::core
