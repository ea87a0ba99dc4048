// SPDX-License-Identifier: Apache-2.0
#include "acquisition/file_pattern.hpp"

#include <fnmatch.h>

#include <algorithm>
#include <filesystem>

namespace cmm::acquisition {
namespace {

namespace fs = std::filesystem;

bool is_digit(char c) noexcept {
    return c >= '0' && c <= '9';
}

std::size_t digits_end(std::string_view text, std::size_t from) noexcept {
    while (from < text.size() && is_digit(text[from]))
        ++from;
    return from;
}

void expand(const fs::path& done, fs::path::const_iterator part, const fs::path::const_iterator& end,
            std::vector<std::string>& out) {
    std::error_code ignored;
    if (part == end) {
        if (fs::is_regular_file(done, ignored)) out.push_back(done.string());
        return;
    }
    const auto next = std::next(part);
    if (!is_file_pattern(part->native())) return expand(done / *part, next, end, out);
    for (const auto& entry : fs::directory_iterator(done.empty() ? fs::path(".") : done, ignored)) {
        const fs::path name = entry.path().filename();
        if (::fnmatch(part->c_str(), name.c_str(), FNM_PERIOD) == 0) expand(done / name, next, end, out);
    }
}

}  // namespace

bool is_file_pattern(std::string_view name) noexcept {
    return name.find_first_of("*?[") != std::string_view::npos;
}

std::vector<std::string> expand_file_pattern(const std::string& pattern) {
    std::vector<std::string> files;
    const fs::path path(pattern);
    expand({}, path.begin(), path.end(), files);
    std::sort(files.begin(), files.end(), natural_less);
    return files;
}

bool natural_less(std::string_view a, std::string_view b) noexcept {
    std::size_t i = 0, j = 0;
    while (i < a.size() && j < b.size()) {
        if (is_digit(a[i]) && is_digit(b[j])) {
            while (i < a.size() && a[i] == '0')
                ++i;
            while (j < b.size() && b[j] == '0')
                ++j;
            const auto first = a.substr(i, digits_end(a, i) - i);
            const auto second = b.substr(j, digits_end(b, j) - j);
            if (first.size() != second.size()) return first.size() < second.size();
            if (first != second) return first < second;
            i += first.size();
            j += second.size();
        } else {
            if (a[i] != b[j]) return a[i] < b[j];
            ++i;
            ++j;
        }
    }
    if (i == a.size() && j == b.size()) return a < b;  // equal but for leading zeros: any fixed order
    return i == a.size();
}

}  // namespace cmm::acquisition
