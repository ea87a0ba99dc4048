// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "core/error.hpp"
#include "web/server/api.hpp"
#include "web/server/event_feed.hpp"
#include "web/server/guard.hpp"

namespace cmm::web {

/// HTTP and WebSocket for the guard, the routes and the event feed: one thread for all connections, one for what the
/// routes read and compute, both with less priority than what measures. Bounded in everything: 64 connections, requests
/// of 8 KiB and a body of 64 KiB, 10 s for a request, 30 s of silence.
class HttpServer {
  public:
    /// Listens when it returns. Port 0: a free one. The arguments outlive the server, which uses `api` on its own
    /// thread only. Errors: usage (not an address of this machine, or in use).
    static core::Result<std::unique_ptr<HttpServer>> start(const std::string& address, std::uint16_t port,
                                                           const Guard& guard, Api& api, EventFeed& feed);
    ~HttpServer();
    HttpServer(const HttpServer&) = delete;
    HttpServer& operator=(const HttpServer&) = delete;

    std::uint16_t port() const;
    /// Runs `work` on the thread of the routes and waits for it.
    void on_desk(const std::function<void()>& work);

  private:
    struct Impl;
    explicit HttpServer(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> impl_;
};

}  // namespace cmm::web
