// SPDX-License-Identifier: Apache-2.0
#include "drivers/endpoint.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdlib>
#include <optional>
#include <span>
#include <vector>

#include "core/text.hpp"

namespace cmm::drivers {
namespace {

enum class Form : std::uint8_t { network, device, file, nothing };

struct OptionForm {
    std::string_view name;
    std::int64_t low = 0, high = 0;  // whole number, unless there are words
    std::array<std::string_view, 3> words{};
};

/// What serial ports and libraries have a setting for. libmodbus takes 9600 for any other, without a word.
constexpr std::array<std::int64_t, 20> line_speeds{
    300,     600,     1200,    2400,    4800,    9600,      19'200,    38'400,    57'600,    115'200,
    230'400, 460'800, 500'000, 576'000, 921'600, 1'000'000, 1'152'000, 3'000'000, 3'500'000, 4'000'000};

constexpr OptionForm unit_option{"unit", 0, 255, {}};
constexpr OptionForm in_flight_option{"in_flight", 1, 64, {}};
constexpr OptionForm rtu_unit_option{"unit", 1, 247, {}};  // 0 is a broadcast: nobody answers
constexpr OptionForm baud_option{"baud", line_speeds.front(), line_speeds.back(), {}};
constexpr OptionForm parity_option{"parity", 0, 0, {"none", "even", "odd"}};
constexpr OptionForm stop_bits_option{"stop_bits", 1, 2, {}};
constexpr OptionForm data_bits_option{"data_bits", 7, 8, {}};
constexpr OptionForm rts_option{"rts", 0, 0, {"none", "up", "down"}};
constexpr OptionForm rts_delay_option{"rts_delay_us", 0, 100'000, {}};
constexpr OptionForm turnaround_option{"turnaround_ms", 0, 100, {}};
constexpr OptionForm gap_option{"gap_us", 0, 100'000, {}};
constexpr OptionForm replay_speed_option{"speed", 0, 1000, {}};
constexpr OptionForm pty_option{"pty", 0, 0, {"no", "yes"}};

struct SchemeForm {
    std::string_view name;
    Form form;
    std::uint16_t default_port;
    std::string_view example;
    std::span<const OptionForm> options;
};

constexpr std::array tcp_options{unit_option, in_flight_option};
constexpr std::array rtu_options{rtu_unit_option,  baud_option,       parity_option, stop_bits_option, rts_option,
                                 rts_delay_option, turnaround_option, gap_option,    pty_option};
constexpr std::array gateway_options{rtu_unit_option,  baud_option,       parity_option,
                                     stop_bits_option, turnaround_option, gap_option};
constexpr std::array line_options{baud_option, parity_option, stop_bits_option, pty_option};

constexpr std::array dro_options{baud_option, parity_option, stop_bits_option, data_bits_option, pty_option};
constexpr std::array replay_options{replay_speed_option};

constexpr std::array schemes{
    SchemeForm{"modbus+tcp", Form::network, 502, "modbus+tcp://host:502?unit=1", tcp_options},
    SchemeForm{"modbus+rtu", Form::device, 0, "modbus+rtu:///dev/ttyUSB0?baud=115200&parity=even", rtu_options},
    SchemeForm{"modbus+rtu+tcp", Form::network, 502, "modbus+rtu+tcp://gateway:502?unit=1", gateway_options},
    SchemeForm{"line+serial", Form::device, 0, "line+serial:///dev/ttyUSB0?baud=115200", line_options},
    SchemeForm{"dro+serial", Form::device, 0, "dro+serial:///dev/ttyUSB0?baud=9600", dro_options},
    SchemeForm{"linuxcnc", Form::network, 5007, "linuxcnc://host:5007", {}},
    SchemeForm{"ipp", Form::network, 1294, "ipp://host:1294", {}},
    SchemeForm{"replay", Form::file, 0, "replay:run.cmmrun?speed=1", replay_options},
    SchemeForm{"demo", Form::nothing, 0, "demo:", {}},
};

const SchemeForm* form_of(std::string_view scheme) {
    const auto* found = std::find_if(schemes.begin(), schemes.end(), [&](const auto& s) { return s.name == scheme; });
    return found == schemes.end() ? nullptr : found;
}

std::optional<std::int64_t> whole_number(std::string_view text) {
    std::int64_t value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
    return value;
}

/// Carries the URL along, so that every error shows it.
class Parser {
  public:
    explicit Parser(std::string_view url) : url_(url) {}

    core::Result<Endpoint> run() {
        const auto colon = url_.find(':');
        if (colon == std::string_view::npos || colon == 0) {
            return error("it has no scheme; write for example " + std::string(schemes.front().example));
        }
        endpoint_.scheme = std::string(url_.substr(0, colon));
        form_ = form_of(endpoint_.scheme);
        std::string_view rest = url_.substr(colon + 1);
        const auto question = rest.find('?');
        if (question != std::string_view::npos) {
            if (auto options = read_options(rest.substr(question + 1)); !options)
                return tl::unexpected(options.error());
            rest = rest.substr(0, question);
        }
        if (auto place = read_place(rest); !place) return tl::unexpected(place.error());
        return endpoint_;
    }

  private:
    tl::unexpected<core::Error> error(const std::string& what) const {
        return core::fail(core::ErrorCode::usage, "endpoint \"" + std::string(url_) + "\": " + what);
    }
    tl::unexpected<core::Error> error_with_form(const std::string& what) const {
        return error(what + "; the form is " + std::string(form_->example));
    }

    core::Status read_place(std::string_view rest) {
        const bool slashes = rest.starts_with("//");
        if (form_ == nullptr) {
            endpoint_.path = std::string(rest);
            return {};
        }
        switch (form_->form) {
            case Form::network:
                if (!slashes) return error_with_form("'//' is missing after the scheme");
                return read_host(rest.substr(2));
            case Form::device:
                if (!slashes || rest.size() < 4 || rest[2] != '/')
                    return error_with_form("the device's path is missing");
                endpoint_.path = std::string(rest.substr(2));
                return {};
            case Form::file:
                if (rest.empty()) return error_with_form("the file's name is missing");
                endpoint_.path = std::string(rest);
                return {};
            case Form::nothing:
                if (!rest.empty()) return error_with_form("nothing may follow");
                return {};
        }
        return {};
    }

    core::Status read_host(std::string_view authority) {
        if (authority.ends_with('/')) authority.remove_suffix(1);
        if (authority.find('/') != std::string_view::npos) return error_with_form("a path cannot follow the host");
        std::string_view port;
        if (authority.starts_with('[')) {  // IPv6
            const auto close = authority.find(']');
            if (close == std::string_view::npos) return error("']' is missing after the IPv6 address");
            endpoint_.host = std::string(authority.substr(1, close - 1));
            port = authority.substr(close + 1);
            if (!port.empty() && port.front() != ':') return error("only ':port' may follow the address");
            if (port == ":") return error("the port is missing after ':'");
            if (!port.empty()) port.remove_prefix(1);
        } else {
            const auto colon = authority.rfind(':');
            endpoint_.host = std::string(authority.substr(0, colon));
            if (endpoint_.host.find(':') != std::string::npos)
                return error("an IPv6 address is written in brackets: [::1]");
            if (colon != std::string_view::npos) {
                port = authority.substr(colon + 1);
                if (port.empty()) return error("the port is missing after ':'");
            }
        }
        if (endpoint_.host.empty()) return error_with_form("the host is missing");
        return read_port(port);
    }

    core::Status read_port(std::string_view text) {
        endpoint_.port = form_->default_port;
        if (text.empty()) return {};
        const auto port = whole_number(text);
        // 0 is for listeners: any free port.
        if (!port || *port < 0 || *port > 65535) {
            return error("the port \"" + std::string(text) + "\" is not a number from 0 to 65535");
        }
        endpoint_.port = static_cast<std::uint16_t>(*port);
        return {};
    }

    core::Status read_options(std::string_view text) {
        for (const std::string_view field : core::split(text, '&')) {
            const auto equals = field.find('=');
            if (equals == std::string_view::npos || equals == 0) {
                return error("the option \"" + std::string(field) + "\" is not of the form name=value");
            }
            const std::string_view name = field.substr(0, equals);
            const std::string_view value = field.substr(equals + 1);
            if (auto known = check_option(name, value); !known) return known;
            if (!endpoint_.options.emplace(name, value).second)
                return error("the option " + std::string(name) + " comes twice");
        }
        return {};
    }

    core::Status check_option(std::string_view name, std::string_view value) const {
        if (form_ == nullptr) return {};
        std::vector<std::string_view> names;
        for (const OptionForm& option : form_->options) {
            names.push_back(option.name);
            if (option.name == name) return check_value(option, value);
        }
        std::string what = std::string(form_->name) + " has no option \"" + std::string(name) + "\"";
        if (const auto near = core::nearest_word(name, names)) what += "; did you mean \"" + *near + "\"?";
        return error(what);
    }

    core::Status check_value(const OptionForm& option, std::string_view value) const {
        if (!option.words.front().empty()) {
            const auto* const found = std::find(option.words.begin(), option.words.end(), value);
            if (found != option.words.end() && !value.empty()) return {};
            return error(std::string(option.name) + " must be " + choice(option.words) + ", not \"" +
                         std::string(value) + "\"");
        }
        const auto number = whole_number(value);
        if (number && *number >= option.low && *number <= option.high) return check_speed(option, *number);
        return error(std::string(option.name) + " must be a whole number from " + std::to_string(option.low) + " to " +
                     std::to_string(option.high) + ", not \"" + std::string(value) + "\"");
    }

    /// "none, even or odd"
    static std::string choice(std::span<const std::string_view> words) {
        std::string text;
        for (std::size_t k = 0; k < words.size() && !words[k].empty(); ++k) {
            const bool last = k + 1 == words.size() || words[k + 1].empty();
            text += (k == 0 ? "" : last ? " or " : ", ") + std::string(words[k]);
        }
        return text;
    }

    core::Status check_speed(const OptionForm& option, std::int64_t value) const {
        if (option.name != baud_option.name ||
            std::find(line_speeds.begin(), line_speeds.end(), value) != line_speeds.end())
            return {};
        const auto nearest = *std::min_element(line_speeds.begin(), line_speeds.end(), [value](auto a, auto b) {
            return std::abs(a - value) < std::abs(b - value);
        });
        return error(std::to_string(value) + " is no speed that serial ports have; the nearest is " +
                     std::to_string(nearest));
    }

    std::string_view url_;
    const SchemeForm* form_ = nullptr;
    Endpoint endpoint_;
};

}  // namespace

core::Result<Endpoint> Endpoint::parse(std::string_view url) {
    return Parser(url).run();
}

std::string Endpoint::text() const {
    const SchemeForm* form = form_of(scheme);
    std::string url = scheme + ":";
    if (form != nullptr && form->form == Form::network) {
        url += "//" + place();
    } else if (form != nullptr && form->form == Form::device) {
        url += "//" + path;
    } else {
        url += path;
    }
    char separator = '?';
    for (const auto& [name, value] : options) {
        url += separator + name + "=" + value;
        separator = '&';
    }
    return url;
}

std::int64_t Endpoint::integer(const std::string& option, std::int64_t fallback) const {
    const auto found = options.find(option);
    if (found == options.end()) return fallback;
    return whole_number(found->second).value_or(fallback);
}

std::string Endpoint::word(const std::string& option, const std::string& fallback) const {
    const auto found = options.find(option);
    return found == options.end() ? fallback : found->second;
}

std::string Endpoint::place() const {
    if (host.empty()) return path;
    const bool ipv6 = host.find(':') != std::string::npos;
    return (ipv6 ? "[" + host + "]" : host) + ":" + std::to_string(port);
}

}  // namespace cmm::drivers
