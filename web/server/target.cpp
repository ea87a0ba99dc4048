// SPDX-License-Identifier: Apache-2.0
#include "web/server/target.hpp"

#include <algorithm>
#include <charconv>

namespace cmm::web {
namespace {

constexpr std::size_t longest_target = 1024;

std::optional<std::string> decoded(std::string_view text) {
    std::string out;
    out.reserve(text.size());
    for (std::size_t i = 0; i < text.size(); ++i) {
        unsigned byte = static_cast<unsigned char>(text[i]);
        if (text[i] == '%') {
            if (text.size() - i < 3) return {};
            const char* const end = text.data() + i + 3;
            const auto read = std::from_chars(text.data() + i + 1, end, byte, 16);
            if (read.ec != std::errc() || read.ptr != end) return {};
            i += 2;
        }
        if (byte < 0x20 || byte == 0x7F) return {};
        out.push_back(static_cast<char>(byte));
    }
    return out;
}

bool harmless(const std::string& segment) {
    return !segment.empty() && segment != "." && segment != ".." && segment.find_first_of("/\\") == std::string::npos;
}

/// Calls `take` with each piece between separators; false as soon as it does.
template <class Take>
bool each_piece(std::string_view text, char separator, const Take& take) {
    while (true) {
        const auto at = text.find(separator);
        if (!take(text.substr(0, at))) return false;
        if (at == std::string_view::npos) return true;
        text.remove_prefix(at + 1);
    }
}

}  // namespace

std::optional<std::uint64_t> Target::number(const std::string& name) const {
    const auto found = query.find(name);
    if (found == query.end()) return {};
    const std::string& text = found->second;
    std::uint64_t value = 0;
    const auto read = std::from_chars(text.data(), text.data() + text.size(), value);
    if (read.ec != std::errc() || read.ptr != text.data() + text.size()) return {};
    return value;
}

std::optional<Target> parse_target(std::string_view text) {
    if (text.empty() || text.front() != '/' || text.size() > longest_target) return {};
    Target target;
    const auto question = text.find('?');
    const std::string_view path = text.substr(1, question == std::string_view::npos ? question : question - 1);
    const auto take_segment = [&](std::string_view piece) {
        auto segment = decoded(piece);
        if (!segment || !harmless(*segment)) return false;
        target.path.push_back(std::move(*segment));
        return true;
    };
    if (!path.empty() && !each_piece(path, '/', take_segment)) return {};
    if (question == std::string_view::npos) return target;
    const auto take_parameter = [&](std::string_view piece) {
        const auto equals = piece.find('=');
        auto name = decoded(piece.substr(0, equals));
        auto value = decoded(equals == std::string_view::npos ? std::string_view() : piece.substr(equals + 1));
        return name && value && !name->empty() && target.query.emplace(std::move(*name), std::move(*value)).second;
    };
    if (!each_piece(text.substr(question + 1), '&', take_parameter)) return {};
    return target;
}

}  // namespace cmm::web
