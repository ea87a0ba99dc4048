// SPDX-License-Identifier: Apache-2.0
#include "cell/peers.hpp"

#include <algorithm>
#include <boost/asio/ip/address_v4.hpp>
#include <boost/asio/ip/address_v6.hpp>
#include <charconv>

namespace cmm::cell {
namespace {

using boost::asio::ip::address;

address plain(const address& any) {
    if (any.is_v6() && any.to_v6().is_v4_mapped())
        return boost::asio::ip::make_address_v4(boost::asio::ip::v4_mapped, any.to_v6());
    return any;
}

template <class Bytes>
bool same_bits(const Bytes& a, const Bytes& b, unsigned bits) {
    for (unsigned i = 0; i < bits; ++i) {
        const unsigned shift = 7U - i % 8U;
        if ((a[i / 8U] >> shift & 1U) != (b[i / 8U] >> shift & 1U)) return false;
    }
    return true;
}

}  // namespace

core::Status Peers::add(const std::string& text) {
    const auto slash = text.find('/');
    boost::system::error_code wrong;
    Network network;
    network.address = plain(boost::asio::ip::make_address(text.substr(0, slash), wrong));
    const unsigned longest = network.address.is_v4() ? 32 : 128;
    network.bits = longest;
    bool good = !wrong;
    if (slash != std::string::npos) {
        const char* const end = text.data() + text.size();
        const auto read = std::from_chars(text.data() + slash + 1, end, network.bits);
        good = good && read.ec == std::errc() && read.ptr == end && network.bits <= longest;
    }
    if (!good) {
        return core::fail(core::ErrorCode::usage,
                          "'" + text + "' is no address and no network: 192.168.0.17, 10.1.0.0/16 or fd00::/8");
    }
    networks_.push_back(network);
    return {};
}

bool Peers::contain(const address& any) const {
    const address peer = plain(any);
    return std::any_of(networks_.begin(), networks_.end(), [&](const Network& network) {
        if (peer.is_v4() != network.address.is_v4()) return false;
        return peer.is_v4() ? same_bits(peer.to_v4().to_bytes(), network.address.to_v4().to_bytes(), network.bits)
                            : same_bits(peer.to_v6().to_bytes(), network.address.to_v6().to_bytes(), network.bits);
    });
}

}  // namespace cmm::cell
