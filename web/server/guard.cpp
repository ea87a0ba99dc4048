// SPDX-License-Identifier: Apache-2.0
#include "web/server/guard.hpp"

#include <arpa/inet.h>

#include <algorithm>
#include <string_view>

#include "web/server/token.hpp"

namespace cmm::web {
namespace {

/// Without the port; an IPv6 address without its brackets. Empty when it is none of these.
std::string name_of(std::string_view host) {
    const bool bracketed = host.starts_with('[');
    const auto end = bracketed ? host.find(']') : host.find(':');
    std::string_view name =
        host.substr(bracketed ? 1 : 0, end == std::string_view::npos ? end : end - (bracketed ? 1 : 0));
    std::string_view rest = end == std::string_view::npos ? std::string_view() : host.substr(end + (bracketed ? 1 : 0));
    if (bracketed && end == std::string_view::npos) return {};
    if (!rest.empty() && (rest.front() != ':' || rest.size() < 2 || rest.size() > 6 ||
                          rest.find_first_not_of("0123456789", 1) != std::string_view::npos))
        return {};
    return std::string(name);
}

bool is_address(const std::string& name) {
    in6_addr place{};
    return ::inet_pton(AF_INET, name.c_str(), &place) == 1 || ::inet_pton(AF_INET6, name.c_str(), &place) == 1;
}

}  // namespace

bool Guard::known_host(const std::string& host) const {
    const std::string name = name_of(host);
    return !name.empty() &&
           (name == "localhost" || is_address(name) || std::find(hosts_.begin(), hosts_.end(), name) != hosts_.end());
}

std::optional<Response> Guard::refuse(const Request& request) const {
    const bool changes = request.method == "POST";
    if (!changes && request.method != "GET" && request.method != "HEAD") {
        auto refused = refusal(405, "only GET, HEAD and POST are known here");
        refused.headers.emplace_back("Allow", "GET, HEAD, POST");
        return refused;
    }
    if (!known_host(request.host))
        return refusal(403, "this server is not known by the name in Host (--allow-host NAME)");
    if (!request.origin.empty() && request.origin != "http://" + request.host &&
        request.origin != "https://" + request.host)
        return refusal(403, "the request comes from a page of another origin");
    if (!changes) return {};
    if (!request.content_type.starts_with("application/json"))
        return refusal(415, "the body of a POST is JSON (Content-Type: application/json)");
    return {};
}

std::optional<Response> Guard::refuse_api(const Request& request) const {
    if (request.method != "POST" && !token_to_read_) return {};
    if (same_token(token_, request.token)) return {};
    auto refused =
        refusal(401, "this needs the token that cmmlive printed when it started, or that of its --token-file");
    refused.headers.emplace_back("WWW-Authenticate", "Bearer");
    return refused;
}

}  // namespace cmm::web
