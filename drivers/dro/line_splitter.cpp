// SPDX-License-Identifier: Apache-2.0
#include "drivers/dro/line_splitter.hpp"

#include <utility>

namespace cmm::drivers::dro {

void LineSplitter::restart(bool whole) {
    line_ = Line{{}, whole};
    overlong_ = false;
}

void LineSplitter::feed(std::span<const std::uint8_t> bytes, std::vector<Line>& lines) {
    for (const std::uint8_t byte : bytes) {
        if (byte == '\r' || byte == '\n') {
            if (!line_.text.empty() && !overlong_) lines.push_back(std::move(line_));
            restart(true);
        } else if (line_.text.size() < longest) {
            line_.text += static_cast<char>(byte);
        } else if (!overlong_) {
            line_.whole = false;
            overlong_ = true;
            lines.push_back(line_);
        }
    }
}

}  // namespace cmm::drivers::dro
