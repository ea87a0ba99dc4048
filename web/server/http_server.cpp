// SPDX-License-Identifier: Apache-2.0
#include "web/server/http_server.hpp"

#include <boost/asio/as_tuple.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <chrono>
#include <future>
#include <thread>
#include <unordered_set>
#include <utility>

#include "acquisition/workers.hpp"
#include "core/priority.hpp"
#include "web/server/assets.hpp"

namespace cmm::web {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using asio::ip::tcp;
using boost::system::error_code;

constexpr int niceness = 10;  // what measures goes first
constexpr std::size_t most_connections = 64;
constexpr std::size_t most_header_bytes = 8 * 1024;
constexpr std::size_t most_body_bytes = 64 * 1024;
constexpr std::size_t most_page_message_bytes = 1024;
constexpr std::size_t lines_a_message = 256;
constexpr auto request_time = std::chrono::seconds(10);
constexpr auto silence = std::chrono::seconds(30);
constexpr auto look_again = std::chrono::milliseconds(300);  // at a run file that another process writes
constexpr std::string_view token_protocol = "cmmlive.token.";

const auto no_throw = asio::as_tuple(asio::use_awaitable);

std::string text_of(beast::string_view text) {
    return {text.data(), text.size()};
}

/// The subprotocol that carries the token, if any; the answer must name it.
std::string offered_token_protocol(const http::request<http::string_body>& request) {
    for (const auto& protocol : http::token_list(request[http::field::sec_websocket_protocol])) {
        const std::string name = text_of(protocol);
        if (name.starts_with(token_protocol)) return name;
    }
    return {};
}

Request plain(const http::request<http::string_body>& from) {
    constexpr std::string_view bearer = "Bearer ";
    Request request;
    request.method = text_of(from.method_string());
    request.target = text_of(from.target());
    request.host = text_of(from[http::field::host]);
    request.origin = text_of(from[http::field::origin]);
    request.content_type = text_of(from[http::field::content_type]);
    request.body = from.body();
    const std::string authorization = text_of(from[http::field::authorization]);
    if (authorization.starts_with(bearer)) request.token = authorization.substr(bearer.size());
    if (request.token.empty()) {
        const std::string protocol = offered_token_protocol(from);
        if (!protocol.empty()) request.token = protocol.substr(token_protocol.size());
    }
    return request;
}

http::response<http::string_body> framed(Response answer, unsigned version, bool keep_alive, bool head) {
    http::response<http::string_body> response{static_cast<http::status>(answer.status), version};
    response.set(http::field::content_type, answer.content_type);
    response.set(http::field::cache_control, "no-store");
    response.set("Content-Security-Policy",
                 "default-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'; object-src 'none'");
    response.set("X-Content-Type-Options", "nosniff");
    response.set("Referrer-Policy", "no-referrer");
    response.set("Cross-Origin-Resource-Policy", "same-origin");
    response.set("Cross-Origin-Opener-Policy", "same-origin");
    for (const auto& [name, value] : answer.headers)
        response.set(name, value);
    response.keep_alive(keep_alive);
    const std::size_t length = answer.body.size();
    if (!head) response.body() = std::move(answer.body);
    response.content_length(length);
    return response;
}

/// What was wrong with a request that could not be read; nothing when the client just went away.
std::optional<Response> unreadable(const error_code& code) {
    if (code == http::error::header_limit) return refusal(431, "the header of the request is too long");
    if (code == http::error::body_limit) return refusal(413, "the body of the request is too long");
    if (code == beast::error::timeout || code == http::error::end_of_stream || code == http::error::partial_message ||
        code.category() != http::make_error_code(http::error::bad_method).category())
        return {};
    return refusal(400, "this is no HTTP request");
}

using Socket = beast::tcp_stream;

/// A page that hears events.
struct Listener {
    explicit Listener(Socket stream) : page(std::move(stream)), news(page.get_executor()) {}
    websocket::stream<Socket> page;
    asio::steady_timer news;
    bool gone = false;
};

}  // namespace

struct HttpServer::Impl {
    Impl(const Guard& the_guard, Api& the_api, EventFeed& the_feed)
        : guard(the_guard), api(the_api), feed(the_feed), context(1), acceptor(context) {}
    ~Impl() {
        feed.on_news({});
        context.stop();
        if (thread.joinable()) thread.join();
    }

    asio::awaitable<void> accept();
    asio::awaitable<void> serve(tcp::socket socket);
    asio::awaitable<bool> respond(Socket& stream, Response answer, const http::request<http::string_body>& request);
    asio::awaitable<Response> answer(Request request);
    asio::awaitable<void> upgrade(Socket& stream, http::request<http::string_body> request);
    asio::awaitable<void> listen(std::shared_ptr<Listener> listener);
    asio::awaitable<void> tell(Socket stream, http::request<http::string_body> request, Api::Subscription subscription);
    asio::awaitable<std::string> next_message(Api::Subscription& subscription);
    void wake();

    const Guard& guard;
    Api& api;
    EventFeed& feed;
    std::size_t connections = 0;
    std::unordered_set<Listener*> listeners;
    asio::io_context context;  // destroyed before what its coroutines use
    tcp::acceptor acceptor;
    acquisition::Workers desk{1, niceness};  // drained before the context, where its answers go
    std::thread thread;
};

asio::awaitable<void> HttpServer::Impl::accept() {
    while (true) {
        auto [code, socket] = co_await acceptor.async_accept(no_throw);
        if (code == asio::error::operation_aborted) co_return;
        if (code) {  // no descriptor left, for example: not at once again
            asio::steady_timer pause(context, look_again);
            co_await pause.async_wait(no_throw);
            continue;
        }
        if (connections >= most_connections) continue;  // closed at once
        ++connections;
        auto done = [this](const std::exception_ptr&) { --connections; };
        asio::co_spawn(context, serve(std::move(socket)), std::move(done));
    }
}

asio::awaitable<void> HttpServer::Impl::serve(tcp::socket socket) {
    error_code ignored;
    socket.set_option(tcp::no_delay(true), ignored);
    Socket stream(std::move(socket));
    beast::flat_buffer buffer;
    while (true) {
        http::request_parser<http::string_body> parser;
        parser.header_limit(most_header_bytes);
        parser.body_limit(most_body_bytes);
        stream.expires_after(request_time);
        auto [code, size] = co_await http::async_read(stream, buffer, parser, no_throw);
        if (code) {
            auto why = unreadable(code);
            if (why) {
                http::request<http::string_body> nothing;
                nothing.keep_alive(false);
                co_await respond(stream, std::move(*why), nothing);
            }
            break;
        }
        auto request = parser.release();
        if (websocket::is_upgrade(request)) {
            co_await upgrade(stream, std::move(request));
            break;
        }
        Request asked = plain(request);
        Response made = co_await answer(std::move(asked));
        const bool going_on = co_await respond(stream, std::move(made), request);
        if (!going_on) break;
    }
    stream.socket().shutdown(tcp::socket::shutdown_both, ignored);
}

asio::awaitable<bool> HttpServer::Impl::respond(Socket& stream, Response answer,
                                                const http::request<http::string_body>& request) {
    auto response =
        framed(std::move(answer), request.version(), request.keep_alive(), request.method() == http::verb::head);
    stream.expires_after(silence);
    auto [code, size] = co_await http::async_write(stream, response, no_throw);
    co_return !code && request.keep_alive();
}

asio::awaitable<Response> HttpServer::Impl::answer(Request request) {
    auto refused = guard.refuse(request);
    if (refused) co_return std::move(*refused);
    const auto path = std::string_view(request.target).substr(0, request.target.find('?'));
    if (!path.starts_with("/api/") && path != "/metrics") {
        const auto asset = find_asset(path);
        if (!asset || request.method == "POST") co_return refusal(404, "there is nothing under this address");
        Response response;
        response.content_type = asset->content_type;
        response.body = asset->content;
        co_return response;
    }
    refused = guard.refuse_api(request);
    if (refused) co_return std::move(*refused);
    auto work = [this, request = std::move(request)] { return api.answer(request); };
    co_return co_await desk.run(std::move(work));
}

asio::awaitable<void> HttpServer::Impl::upgrade(Socket& stream, http::request<http::string_body> request) {
    Request asked = plain(request);
    auto refused = guard.refuse(asked);
    if (!refused) refused = guard.refuse_api(asked);
    Api::Subscription subscription;
    subscription.job = feed.job();  // before it is found out which run is live
    if (!refused) {
        auto work = [this, &asked, &subscription] { return api.subscribe(asked, subscription); };
        refused = co_await desk.run(std::move(work));
    }
    if (refused) {
        request.keep_alive(false);
        co_await respond(stream, std::move(*refused), request);
        co_return;
    }
    co_await tell(std::move(stream), std::move(request), std::move(subscription));
}

asio::awaitable<std::string> HttpServer::Impl::next_message(Api::Subscription& subscription) {
    std::string message;
    std::optional<std::uint64_t> end;
    if (subscription.live) {
        const auto slice = feed.read(subscription.from, lines_a_message);
        subscription.live = slice.job == subscription.job;  // or the next has begun: the run file has the rest
        if (subscription.live && slice.first <= subscription.from) {
            for (const auto& line : slice.lines)
                message += (message.empty() ? "" : "\n") + *line;
            subscription.from += slice.lines.size();
            co_return message;
        }
        if (subscription.live) end = slice.first;
    }
    auto read = [this, &subscription, end] { return api.recorded_events(subscription.run, subscription.from, end); };
    const auto lines = co_await desk.run(std::move(read));
    for (const auto& line : lines)
        message += (message.empty() ? "" : "\n") + line;
    co_return message;
}

/// A page says nothing; reading answers its pings and notices when it goes.
asio::awaitable<void> HttpServer::Impl::listen(std::shared_ptr<Listener> listener) {
    beast::flat_buffer said;
    while (!listener->gone) {
        auto [code, size] = co_await listener->page.async_read(said, no_throw);
        said.clear();
        listener->gone = code.failed();
    }
    listener->news.cancel();
}

asio::awaitable<void> HttpServer::Impl::tell(Socket stream, http::request<http::string_body> request,
                                             Api::Subscription subscription) {
    stream.expires_never();
    auto listener = std::make_shared<Listener>(std::move(stream));
    auto& page = listener->page;
    page.read_message_max(most_page_message_bytes);
    page.auto_fragment(false);
    page.set_option(websocket::stream_base::timeout{request_time, silence, true});
    const std::string protocol = offered_token_protocol(request);
    auto name_it = [protocol](websocket::response_type& response) {
        if (!protocol.empty()) response.set(http::field::sec_websocket_protocol, protocol);
    };
    page.set_option(websocket::stream_base::decorator(std::move(name_it)));
    auto [refused] = co_await page.async_accept(request, no_throw);
    if (refused) co_return;
    asio::co_spawn(context, listen(listener), asio::detached);
    listeners.insert(listener.get());
    while (!listener->gone) {
        const std::string message = co_await next_message(subscription);
        if (message.empty()) {
            listener->news.expires_after(subscription.live ? silence : look_again);
            co_await listener->news.async_wait(no_throw);
            continue;
        }
        auto [code, size] = co_await page.async_write(asio::buffer(message), no_throw);
        listener->gone = listener->gone || code.failed();
    }
    listeners.erase(listener.get());
}

void HttpServer::Impl::wake() {
    for (auto* listener : listeners)
        listener->news.cancel();
}

HttpServer::HttpServer(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
HttpServer::~HttpServer() = default;

core::Result<std::unique_ptr<HttpServer>> HttpServer::start(const std::string& address, std::uint16_t port,
                                                            const Guard& guard, Api& api, EventFeed& feed) {
    auto impl = std::make_unique<Impl>(guard, api, feed);
    error_code code;
    const tcp::endpoint place(asio::ip::make_address(address, code), port);
    if (!code) impl->acceptor.open(place.protocol(), code);
    if (!code) impl->acceptor.set_option(tcp::acceptor::reuse_address(true), code);
    if (!code) impl->acceptor.bind(place, code);
    if (!code) impl->acceptor.listen(asio::socket_base::max_listen_connections, code);
    if (code) {
        return core::fail(core::ErrorCode::usage,
                          address + ":" + std::to_string(port) + ": cannot listen there: " + code.message());
    }
    asio::co_spawn(impl->context, impl->accept(), asio::detached);
    feed.on_news([at = impl.get()] { asio::post(at->context, [at] { at->wake(); }); });
    impl->thread = std::thread([at = impl.get()] {
        core::stand_back(niceness);
        at->context.run();
    });
    return std::unique_ptr<HttpServer>(new HttpServer(std::move(impl)));
}

std::uint16_t HttpServer::port() const {
    return impl_->acceptor.local_endpoint().port();
}

void HttpServer::on_desk(const std::function<void()>& work) {
    std::promise<void> done;
    impl_->desk.post([&] {
        work();
        done.set_value();
    });
    done.get_future().wait();
}

}  // namespace cmm::web
