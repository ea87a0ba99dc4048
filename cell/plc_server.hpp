// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "cell/modbus_request.hpp"
#include "cell/peers.hpp"
#include "core/clock.hpp"
#include "core/error.hpp"

namespace cmm::cell {

struct PlcServerOptions {
    std::string address = "127.0.0.1";
    std::uint16_t port = 0;  ///< 0: a free one
    std::uint8_t unit = 1;
    Peers peers;  ///< who may connect; none: this machine alone
    core::Duration watchdog = std::chrono::seconds(2);
};

struct PlcServerCounts {
    std::size_t connections = 0;  ///< now
    std::uint64_t accepted = 0;
    std::uint64_t refused = 0;  ///< addresses that may not
    std::uint64_t requests = 0;
    std::uint64_t exceptions = 0;  ///< requests answered by one
    std::uint64_t garbled = 0;     ///< connections that spoke no Modbus
};

/// Modbus TCP on one executor (one thread), which also carries out the requests. Modbus has no password: it listens for
/// this machine or for addresses that were named, and one address writes at a time: whoever wrote last, until it has
/// written nothing for the watchdog's time. 8 connections; when another comes, the one that said nothing for longest
/// goes, as does one that says nothing for a minute.
class PlcServer {
  public:
    /// Listens when it returns. The registers and the clock outlive the server; it is destroyed on its executor, or
    /// when that runs no more. Errors: usage.
    static core::Result<std::unique_ptr<PlcServer>> start(boost::asio::any_io_executor executor,
                                                          const PlcServerOptions& options, RegisterAccess& registers,
                                                          const core::Clock& clock);
    ~PlcServer();
    PlcServer(const PlcServer&) = delete;
    PlcServer& operator=(const PlcServer&) = delete;

    std::uint16_t port() const;
    PlcServerCounts counts() const;

  private:
    struct Impl;
    explicit PlcServer(std::shared_ptr<Impl> impl);
    std::shared_ptr<Impl> impl_;
};

}  // namespace cmm::cell
