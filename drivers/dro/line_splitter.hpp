// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace cmm::drivers::dro {

/// Cuts bytes into lines: CR, LF and CR LF end one, empty lines do not count. A line of more than `longest` bytes comes
/// out cut, and with it what follows up to its end. One owner, no locking.
class LineSplitter {
  public:
    static constexpr std::size_t longest = 256;

    struct Line {
        std::string text;
        bool whole = true;  ///< false: too long, or its beginning may have been missed
    };

    /// After the port was opened: `whole` says whether the next byte begins a line.
    void restart(bool whole);
    void feed(std::span<const std::uint8_t> bytes, std::vector<Line>& lines);

  private:
    Line line_;
    bool overlong_ = false;
};

}  // namespace cmm::drivers::dro
