// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/clock.hpp"

namespace cmm::sim {

/// What is spoken over one connection: bytes in, bytes out. Made for each connection, used by the server's thread.
class WireProtocol {
  public:
    struct Progress {
        std::size_t used = 0;    ///< bytes taken off the front
        bool alive = true;       ///< false: the stream is lost, close the connection
        core::Duration away{0};  ///< a closed serial port is opened again after so long
    };
    WireProtocol() = default;
    virtual ~WireProtocol() = default;
    WireProtocol(const WireProtocol&) = delete;
    WireProtocol& operator=(const WireProtocol&) = delete;

    /// Answers the first request of `in`, if it is whole, by appending to `out`. `silent_for`: since the last byte
    /// came.
    virtual Progress answer(std::span<const std::uint8_t> in, core::Duration silent_for,
                            std::vector<std::uint8_t>& out) = 0;
    /// Sees the bytes that have come before they are put behind the others.
    virtual void arrived(std::vector<std::uint8_t>&) {}
    /// Called every round, with or without news; appends what is to be sent now.
    virtual Progress idle(std::vector<std::uint8_t>&) { return {}; }
};

}  // namespace cmm::sim
