// SPDX-License-Identifier: Apache-2.0
#include "web/server/page_server.hpp"

#include <charconv>
#include <utility>

#include "web/server/event_feed.hpp"
#include "web/server/guard.hpp"
#include "web/server/http_server.hpp"
#include "web/server/token.hpp"

namespace cmm::web {
namespace {

struct Place {
    std::string address;
    std::uint16_t port = 0;
};

core::Result<Place> parse_listen(const std::string& text) {
    const auto colon = text.rfind(':');
    Place place;
    std::string_view port = colon == std::string::npos ? std::string_view() : std::string_view(text).substr(colon + 1);
    const auto read = std::from_chars(port.data(), port.data() + port.size(), place.port);
    if (port.empty() || read.ec != std::errc() || read.ptr != port.data() + port.size()) {
        return core::fail(core::ErrorCode::usage, "'" + text + "' is no ADDRESS:PORT, e.g. 127.0.0.1:8686");
    }
    place.address = text.substr(0, colon);
    if (place.address == "localhost") place.address = "127.0.0.1";
    if (place.address.size() > 2 && place.address.front() == '[' && place.address.back() == ']')
        place.address = place.address.substr(1, place.address.size() - 2);
    return place;
}

bool of_this_machine(const std::string& address) {
    return address.starts_with("127.") || address == "::1";
}

}  // namespace

struct PageServer::Parts {
    Parts(const PageOptions& options, std::optional<LiveJob> job, std::string the_token, bool token_to_read,
          ServiceView view)
        : token(std::move(the_token)),
          feed(std::make_shared<EventFeed>()),
          guard(token, token_to_read, options.hosts),
          api(options.runs_folder, std::move(job), options.version, std::move(view)) {}

    void listen(acquisition::EventHub& hub) const {
        hub.listen([to = feed, counts = api.metrics()](const acquisition::Event& event) {
            to->push(event);
            counts->hear(event);
        });
    }

    std::string token, url;
    std::shared_ptr<EventFeed> feed;  // the hub keeps its listener
    Guard guard;
    Api api;
    std::unique_ptr<HttpServer> server;
};

PageServer::PageServer(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}
PageServer::~PageServer() = default;

core::Result<std::unique_ptr<PageServer>> PageServer::start(const PageOptions& options, std::optional<LiveJob> job,
                                                            acquisition::EventHub* hub, ServiceView view) {
    const auto place = parse_listen(options.listen);
    if (!place) return tl::unexpected(place.error());
    const bool open = !of_this_machine(place->address);
    if (open && options.token_file.empty()) {
        return core::fail(core::ErrorCode::usage,
                          options.listen +
                              ": other machines reach this address, so give --token-file FILE; without it the page "
                              "is for this machine alone, e.g. 127.0.0.1:8686");
    }
    const auto token = options.token_file.empty() ? new_token() : read_token_file(options.token_file);
    if (!token) return tl::unexpected(token.error());
    auto parts = std::make_unique<Parts>(options, std::move(job), *token, open, std::move(view));
    auto server = HttpServer::start(place->address, place->port, parts->guard, parts->api, *parts->feed);
    if (!server) return tl::unexpected(server.error());
    parts->server = std::move(*server);
    if (hub != nullptr) parts->listen(*hub);
    const bool bracketed = place->address.find(':') != std::string::npos;
    parts->url = "http://" + (bracketed ? "[" + place->address + "]" : place->address) + ":" +
                 std::to_string(parts->server->port()) + "/#token=" + *token;
    return std::unique_ptr<PageServer>(new PageServer(std::move(parts)));
}

const std::string& PageServer::url() const {
    return parts_->url;
}

void PageServer::begin_job(LiveJob job, acquisition::EventHub& hub) {
    parts_->server->on_desk([&] {
        parts_->api.begin_job(std::move(job));
        parts_->feed->begin_job();
    });
    parts_->listen(hub);
}

acquisition::OperatorChoice PageServer::end_job() {
    acquisition::OperatorChoice choice;
    parts_->server->on_desk([&] { choice = parts_->api.end_job(); });
    return choice;
}

}  // namespace cmm::web
