// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <boost/asio/ip/address.hpp>
#include <string>
#include <vector>

#include "core/error.hpp"

namespace cmm::cell {

/// Addresses that may connect: single ones and networks ("192.168.0.17", "10.1.0.0/16", "fd00::/8"). A value.
class Peers {
  public:
    /// Errors: usage.
    core::Status add(const std::string& text);
    bool empty() const { return networks_.empty(); }
    /// An IPv4 address that came in over IPv6 counts as what it is.
    bool contain(const boost::asio::ip::address& peer) const;

  private:
    struct Network {
        boost::asio::ip::address address;
        unsigned bits = 0;
    };
    std::vector<Network> networks_;
};

}  // namespace cmm::cell
