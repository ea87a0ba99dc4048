// SPDX-License-Identifier: Apache-2.0
// What comes over a serial line to a host of the line protocol, cut into pieces, and what messages may say.
#include <cstdlib>

#include "drivers/line/line_codec.hpp"
#include "drivers/line/line_messages.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace cmm::drivers::line;
    const std::span<const std::uint8_t> bytes(data, size);
    const std::string text(bytes.begin(), bytes.end());
    static_cast<void>(decode_identity(text));
    static_cast<void>(decode_identity("CMM1 1 " + text));
    static_cast<void>(decode_status(text));
    const auto samples = decode_samples(bytes);
    if (samples && samples->samples.size() != samples->block.count) std::abort();
    static_cast<void>(cobs_decoded(bytes));

    std::vector<Message> whole;
    std::vector<Message> pieces;
    Parser first;
    Parser second;
    first.feed(bytes, whole);
    for (const std::uint8_t& byte : bytes)
        second.feed({&byte, 1}, pieces);
    if (whole.size() != pieces.size() || first.spoilt() != second.spoilt()) std::abort();
    for (const Message& message : whole)
        if (message.kind == Message::Kind::samples) static_cast<void>(decode_samples(message.payload));
    return 0;
}
