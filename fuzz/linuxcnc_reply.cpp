// SPDX-License-Identifier: Apache-2.0
// What linuxcncrsh may answer, whole and cut into pieces, read as everything that it could be the answer to.
#include <cmath>
#include <cstdlib>

#include "drivers/dro/line_splitter.hpp"
#include "drivers/linuxcnc/rsh_reply.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace cmm::drivers::linuxcnc;
    using cmm::drivers::dro::LineSplitter;
    const std::span<const std::uint8_t> bytes(data, size);
    std::vector<LineSplitter::Line> whole;
    std::vector<LineSplitter::Line> pieces;
    LineSplitter first;
    LineSplitter second;
    first.feed(bytes, whole);
    for (const std::uint8_t& byte : bytes)
        second.feed({&byte, 1}, pieces);
    if (whole.size() != pieces.size()) std::abort();
    for (const auto& line : whole) {
        const Reply reply = read_reply(line.text);
        if (reply.kind == Reply::Kind::value && reply.name.empty()) std::abort();
        for (const std::string& text : {line.text, reply.text}) {
            if (const auto position = read_position(text); position && !position->allFinite()) std::abort();
            if (const auto report = read_report(text))
                for (const double value : report->values)
                    if (!std::isfinite(value)) std::abort();
            static_cast<void>(read_homed(text, text.size() % 10));
            static_cast<void>(read_switch(text));
            static_cast<void>(read_unit_mm(text));
            if (error_of_text(text).message.empty()) std::abort();
        }
    }
    return 0;
}
