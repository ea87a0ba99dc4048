// SPDX-License-Identifier: Apache-2.0
// What comes over a serial line to a Modbus RTU host.
#include <cstdlib>

#include "drivers/modbus/rtu_frame.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace cmm::drivers::modbus;
    std::span<const std::uint8_t> bytes(data, size);
    while (!bytes.empty()) {
        const RtuCut cut = cut_rtu(bytes, 1);
        if (cut.kind == RtuCut::Kind::reply || cut.kind == RtuCut::Kind::foreign) {
            if (cut.size < 4 || cut.size > bytes.size() || cut.pdu.size() + 3 != cut.size) std::abort();
            Transaction request;
            request.read_count = static_cast<std::uint16_t>((cut.pdu.size() - 1) / 2);
            take_reply(cut.pdu, request);
            bytes = bytes.subspan(cut.size);
        } else {
            bytes = bytes.subspan(1);
        }
    }
    return 0;
}
