// SPDX-License-Identifier: Apache-2.0
#include "web/server/metrics_text.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>

namespace cmm::web {
namespace {

std::string number_text(double number) {
    if (std::isnan(number)) return "NaN";
    if (std::isinf(number)) return number > 0.0 ? "+Inf" : "-Inf";
    std::array<char, 32> digits{};
    const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), number).ptr;
    return {digits.data(), end};
}

/// Backslash, quote and line feed, as the format has it.
std::string escaped(std::string_view text, bool quote) {
    std::string out;
    for (const char letter : text) {
        if (letter == '\n') {
            out += "\\n";
            continue;
        }
        if (letter == '\\' || (quote && letter == '"')) out += '\\';
        out += letter;
    }
    return out;
}

}  // namespace

MetricsText& MetricsText::family(std::string_view name, std::string_view type, std::string_view help) {
    family_ = name;
    text_ += "# HELP " + family_ + " " + escaped(help, false) + "\n# TYPE " + family_ + " " + std::string(type) + "\n";
    return *this;
}

void MetricsText::line(std::string_view name, const Labels& labels, double number) {
    text_ += name;
    const char* separator = "{";
    for (const auto& [label, content] : labels) {
        text_ += separator;
        text_ += std::string(label) + "=\"" + escaped(content, true) + "\"";
        separator = ",";
    }
    text_ += (labels.empty() ? " " : "} ") + number_text(number) + "\n";
}

MetricsText& MetricsText::value(double number, const Labels& labels) {
    line(family_, labels, number);
    return *this;
}

MetricsText& MetricsText::one(std::string_view name, std::string_view type, std::string_view help, double number) {
    return family(name, type, help).value(number);
}

MetricsText& MetricsText::histogram(std::string_view name, std::string_view help, std::span<const double> bounds,
                                    std::span<const std::uint64_t> counts, double sum) {
    family(name, "histogram", help);
    std::uint64_t below = 0;
    for (std::size_t i = 0; i < counts.size(); ++i) {
        below += counts[i];
        const std::string bound = i < bounds.size() ? number_text(bounds[i]) : "+Inf";
        line(family_ + "_bucket", {{"le", bound}}, static_cast<double>(below));
    }
    line(family_ + "_sum", {}, sum);
    line(family_ + "_count", {}, static_cast<double>(below));
    return *this;
}

void LatencyHistogram::add(double seconds) noexcept {
    // A bucket holds what is not larger than its bound.
    const auto* const bound = std::lower_bound(bounds_s.begin(), bounds_s.end(), seconds);
    ++counts_[static_cast<std::size_t>(bound - bounds_s.begin())];
    sum_s_ += seconds;
}

void LatencyHistogram::print(MetricsText& text, std::string_view name, std::string_view help) const {
    text.histogram(name, help, bounds_s, counts_, sum_s_);
}

}  // namespace cmm::web
