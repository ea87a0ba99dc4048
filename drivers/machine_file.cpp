// SPDX-License-Identifier: Apache-2.0
#include "drivers/machine_file.hpp"

#include <algorithm>
#include <cctype>

#include "core/config.hpp"

namespace cmm::drivers {
namespace {

/// "scheme:" with two letters at least, so that a drive letter is a file.
bool looks_like_url(const std::string& text) {
    const auto colon = text.find(':');
    if (colon == std::string::npos || colon < 2) return false;
    return std::all_of(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(colon),
                       [](unsigned char c) { return std::isalnum(c) != 0 || c == '+' || c == '-'; });
}

}  // namespace

core::Result<LinkSettings> load_link_settings(const std::string& path) {
    const auto root = core::ConfigTable::load(path);
    if (!root) return tl::unexpected(root.error());
    return read_link_settings(*root);
}

core::Result<LinkSettings> read_link_settings(const core::ConfigTable& root) {
    root.ignore("controller");
    LinkSettings settings;
    const auto link = root.table("link");
    const std::string url = link.required_text("url");
    const std::string map = link.text("map", "");
    if (!map.empty()) settings.map_file = link.resolve(map);
    settings.connect_timeout_ms = link.number("connect_timeout_ms", settings.connect_timeout_ms, {10.0, 60'000.0});
    settings.response_timeout_ms = link.number("response_timeout_ms", settings.response_timeout_ms, {10.0, 60'000.0});
    settings.reconnect_ms = link.number("reconnect_ms", settings.reconnect_ms, {0.0, 600'000.0});
    settings.poll_ms = link.number("poll_ms", settings.poll_ms, {0.2, 10.0});
    if (!url.empty()) {
        auto endpoint = Endpoint::parse(url);
        if (endpoint) {
            settings.endpoint = std::move(*endpoint);
        } else {
            link.complain("url", endpoint.error().message);
        }
    }
    settings.errors = read_machine_errors(root.table("uncertainty"));
    const bool listens = settings.endpoint.scheme == "dro+serial";
    if (root.has("dro") && !listens && !url.empty()) root.complain("dro", "belongs to a dro+serial:// url");
    if (listens) settings.dro = dro::read_dro_settings(root.table("dro"));
    const bool is_linuxcnc = settings.endpoint.scheme == "linuxcnc";
    if (root.has("linuxcnc") && !is_linuxcnc && !url.empty()) root.complain("linuxcnc", "belongs to a linuxcnc:// url");
    if (is_linuxcnc) settings.linuxcnc = linuxcnc::read_linuxcnc_settings(root.table("linuxcnc"));
    if (auto done = root.finish(); !done) return tl::unexpected(done.error());
    return settings;
}

core::Result<LinkSettings> link_settings_from(const std::string& url_or_file) {
    if (!looks_like_url(url_or_file)) return load_link_settings(url_or_file);
    auto endpoint = Endpoint::parse(url_or_file);
    if (!endpoint) return tl::unexpected(endpoint.error());
    LinkSettings settings;
    settings.endpoint = std::move(*endpoint);
    return settings;
}

}  // namespace cmm::drivers
