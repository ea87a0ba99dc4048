// SPDX-License-Identifier: Apache-2.0
#include "drivers/dro/line_format.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/text.hpp"

namespace cmm::drivers::dro {
namespace {

constexpr std::string_view axes = "xyz";

bool is_blank(char c) {
    return c == ' ' || c == '\t';
}
bool is_digit(char c) {
    return c >= '0' && c <= '9';
}

void skip_blanks(std::string_view& rest) {
    while (!rest.empty() && is_blank(rest.front()))
        rest.remove_prefix(1);
}

std::string_view without_outer_blanks(std::string_view text) {
    skip_blanks(text);
    while (!text.empty() && is_blank(text.back()))
        text.remove_suffix(1);
    return text;
}

void take_digits(std::string_view& rest, std::string& digits) {
    while (!rest.empty() && is_digit(rest.front())) {
        digits += rest.front();
        rest.remove_prefix(1);
    }
}

tl::unexpected<core::Error> bad_format(const std::string& what) {
    return core::fail(core::ErrorCode::config_invalid, what);
}

}  // namespace

core::Result<LineFormat> LineFormat::compile(const DroSettings& settings) {
    LineFormat format;
    format.settings_ = settings;
    std::string_view rest = without_outer_blanks(settings.format);
    while (!rest.empty()) {
        if (rest.front() == '{') {
            const auto close = rest.find('}');
            if (close == std::string_view::npos) return bad_format("'}' is missing");
            if (auto taken = format.take_field(rest.substr(1, close - 1)); !taken) return tl::unexpected(taken.error());
            rest.remove_prefix(close + 1);
        } else if (is_blank(rest.front())) {
            skip_blanks(rest);
            format.tokens_.push_back({Token::Kind::blank, ' ', -1});
        } else {
            format.tokens_.push_back({Token::Kind::text, rest.front(), -1});
            rest.remove_prefix(1);
        }
    }
    if (auto right = format.check(); !right) return tl::unexpected(right.error());
    return format;
}

core::Status LineFormat::take_field(std::string_view name) {
    if (!tokens_.empty() && (tokens_.back().kind == Token::Kind::number || tokens_.back().kind == Token::Kind::tag))
        return bad_format("{" + std::string(name) + "} needs something between it and the field before it");
    if (name == "tag") {
        tokens_.push_back({Token::Kind::tag, 0, -1});
        return {};
    }
    const auto axis = name.size() == 1 ? axes.find(name.front()) : std::string_view::npos;
    if (axis == std::string_view::npos && name != "w")
        return bad_format("{" + std::string(name) + "} is no field; there are {x}, {y}, {z}, {w} and {tag}");
    tokens_.push_back({Token::Kind::number, 0, axis == std::string_view::npos ? -1 : static_cast<int>(axis)});
    return {};
}

core::Status LineFormat::check() const {
    for (std::size_t axis = 0; axis < axes.size(); ++axis) {
        const auto count = std::count_if(tokens_.begin(), tokens_.end(), [&](const Token& token) {
            return token.kind == Token::Kind::number && token.axis == static_cast<int>(axis);
        });
        if (count != 1)
            return bad_format("{" + std::string(1, axes[axis]) + "} must be there once, not " + std::to_string(count) +
                              " times");
    }
    const bool tagged =
        std::any_of(tokens_.begin(), tokens_.end(), [](const Token& token) { return token.kind == Token::Kind::tag; });
    if (tagged == settings_.point_tags.empty())
        return bad_format("{tag} and point_tags go together: which characters mark a point");
    return {};
}

bool LineFormat::begins_with_text() const {
    return tokens_.front().kind == Token::Kind::text;
}

LineContent LineFormat::read(std::string_view line) const {
    LineContent content;
    std::string_view rest = without_outer_blanks(line);
    if (!settings_.end.empty() && rest == without_outer_blanks(settings_.end)) {
        content.kind = LineContent::Kind::end;
        return content;
    }
    bool point = true;
    const auto garbled = [&](std::string why) {
        content.kind = LineContent::Kind::garbled;
        content.why = std::move(why);
        const bool no_text =
            std::any_of(line.begin(), line.end(), [](char c) { return static_cast<signed char>(c) < 0; });
        if (no_text) content.why += "; there are bytes that are no text: do speed, parity and data bits agree?";
        return content;
    };
    for (const Token& token : tokens_) {
        switch (token.kind) {
            case Token::Kind::blank:
                skip_blanks(rest);
                break;
            case Token::Kind::text:
                if (rest.empty() || rest.front() != token.text)
                    return garbled("'" + std::string(1, token.text) + "' expected");
                rest.remove_prefix(1);
                break;
            case Token::Kind::tag:
                if (rest.empty() || is_blank(rest.front())) return garbled("the tag is missing");
                point = settings_.point_tags.find(rest.front()) != std::string::npos;
                rest.remove_prefix(1);
                break;
            case Token::Kind::number:
                if (!take_number(rest, token.axis, content)) return garbled(content.why);
                break;
        }
    }
    if (!rest.empty()) return garbled("something follows");
    content.kind = point ? LineContent::Kind::point : LineContent::Kind::no_point;
    return content;
}

/// [+-], blanks, digits, and for decimals a point and more digits.
bool LineFormat::take_number(std::string_view& rest, int axis, LineContent& content) const {
    skip_blanks(rest);
    std::string text;
    if (!rest.empty() && (rest.front() == '+' || rest.front() == '-')) {
        text = rest.front();
        rest.remove_prefix(1);
        skip_blanks(rest);
    }
    const std::size_t sign = text.size();
    take_digits(rest, text);
    const char mark = settings_.decimal_comma ? ',' : '.';
    const bool has_mark = !settings_.integers && !rest.empty() && rest.front() == mark;
    const std::size_t whole = text.size() - sign;
    std::size_t places = 0;
    if (has_mark) {
        rest.remove_prefix(1);
        text += '.';
        take_digits(rest, text);
        places = text.size() - sign - whole - 1;
    }
    const bool of_interest = axis >= 0;
    content.why = of_interest ? std::string("no number for ") + axes[static_cast<std::size_t>(axis)] : "no number";
    if (whole + places == 0) return false;
    if (!of_interest) return true;
    if (!settings_.integers && !has_mark) {
        content.why += " with a decimal point";
        return false;
    }
    if (settings_.decimals && places != static_cast<std::size_t>(*settings_.decimals)) {
        content.why += " with " + std::to_string(*settings_.decimals) + " decimals";
        return false;
    }
    const auto value = core::parse_number(text);
    const double counts = value ? std::round(settings_.integers ? *value : *value / settings_.count)
                                : std::numeric_limits<double>::infinity();
    if (std::abs(counts) > std::numeric_limits<std::int32_t>::max()) {
        content.why += " within reach";
        return false;
    }
    content.counts.at(static_cast<std::size_t>(axis)) = static_cast<std::int32_t>(counts);
    return true;
}

}  // namespace cmm::drivers::dro
