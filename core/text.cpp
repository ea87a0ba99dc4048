// SPDX-License-Identifier: Apache-2.0
#include "core/text.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <numeric>
#include <sstream>

namespace cmm::core {

std::optional<double> parse_number(std::string_view text) noexcept {
    text = trim(text);
    if (!text.empty() && text.front() == '+') text.remove_prefix(1);
    if (text.empty()) return std::nullopt;
    double value = 0.0;
    const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (code != std::errc{} || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
    return value;
}

std::string fixed(double value, int digits) {
    std::array<char, 400> buffer{};
    const auto [end, code] =
        std::to_chars(buffer.data(), buffer.data() + buffer.size(), value, std::chars_format::fixed, digits);
    std::string text = code == std::errc{} ? std::string(buffer.data(), end) : std::string("?");
    const bool negative_zero = text.starts_with('-') && text.find_first_not_of("-0.") == std::string::npos;
    return negative_zero ? text.substr(1) : text;
}

std::string signed_fixed(double value, int digits) {
    const std::string text = fixed(value, digits);
    return text.starts_with('-') ? text : "+" + text;
}

std::string length_text(double mm) {
    return std::abs(mm) >= 0.1 ? fixed(mm, 3) + " mm" : fixed(mm * 1e3, 1) + " um";
}

std::string_view trim(std::string_view text) noexcept {
    constexpr std::string_view blank = " \t\r\n";
    const auto first = text.find_first_not_of(blank);
    if (first == std::string_view::npos) return {};
    return text.substr(first, text.find_last_not_of(blank) - first + 1);
}

std::string in_small_letters(std::string_view text) {
    std::string small(text);
    std::transform(small.begin(), small.end(), small.begin(),
                   [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
    return small;
}

std::vector<std::string_view> split(std::string_view line, char separator) {
    std::vector<std::string_view> fields;
    if (separator != ' ') {
        while (true) {
            const auto at = line.find(separator);
            fields.push_back(trim(line.substr(0, at)));
            if (at == std::string_view::npos) return fields;
            line.remove_prefix(at + 1);
        }
    }
    for (line = trim(line); !line.empty(); line = trim(line)) {
        const auto at = line.find_first_of(" \t");
        fields.push_back(line.substr(0, at));
        if (at == std::string_view::npos) break;
        line.remove_prefix(at);
    }
    return fields;
}

std::optional<std::string> nearest_word(std::string_view word, std::span<const std::string_view> candidates) {
    std::optional<std::string> best;
    std::size_t best_distance = std::max<std::size_t>(1, word.size() / 3) + 1;
    for (const auto candidate : candidates) {
        std::vector<std::size_t> row(candidate.size() + 1);
        std::iota(row.begin(), row.end(), std::size_t{0});
        for (std::size_t i = 0; i < word.size(); ++i) {
            std::size_t diagonal = row[0];
            row[0] = i + 1;
            for (std::size_t j = 0; j < candidate.size(); ++j) {
                const std::size_t substitution = diagonal + (word[i] == candidate[j] ? 0 : 1);
                diagonal = row[j + 1];
                row[j + 1] = std::min({substitution, diagonal + 1, row[j] + 1});
            }
        }
        if (row.back() < best_distance) {
            best_distance = row.back();
            best = std::string(candidate);
        }
    }
    return best;
}

Result<std::string> read_file(const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    std::ostringstream content;
    if (!in || !(content << in.rdbuf())) {
        // An empty file sets failbit on the insertion but is no error.
        if (in && in.peek() == std::ifstream::traits_type::eof()) return std::string{};
        return fail(ErrorCode::input_missing, path + ": cannot be read: " + std::strerror(errno));
    }
    return std::move(content).str();
}

Status write_file(const std::string& path, std::string_view content) {
    const std::string beside = path + ".part";
    const auto failed = [&](int code) {
        ::unlink(beside.c_str());
        return fail(code == ENOSPC || code == EDQUOT || code == EFBIG ? ErrorCode::journal_full : ErrorCode::journal_io,
                    path + ": cannot be written: " + std::strerror(code));
    };
    const int fd = ::open(beside.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
    if (fd < 0) return failed(errno);
    while (!content.empty()) {
        const auto written = ::write(fd, content.data(), content.size());
        if (written < 0 && errno == EINTR) continue;
        if (written <= 0) {
            const int code = written < 0 ? errno : ENOSPC;
            ::close(fd);
            return failed(code);
        }
        content.remove_prefix(static_cast<std::size_t>(written));
    }
    if (::close(fd) != 0 || ::rename(beside.c_str(), path.c_str()) != 0) return failed(errno);
    return {};
}

}  // namespace cmm::core
