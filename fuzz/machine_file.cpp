// SPDX-License-Identifier: Apache-2.0
// Files that say how a machine is reached: machine files, register maps, endpoints. The first byte chooses.
#include <cstdlib>

#include "drivers/endpoint.hpp"
#include "drivers/machine_file.hpp"
#include "drivers/modbus/register_map.hpp"
#include "fuzz/work_file.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    if (size == 0) return 0;
    static const WorkFile work(".toml");
    const std::span<const std::uint8_t> content(data + 1, size - 1);
    const auto said = [](const auto& result) {
        if (!result && result.error().message.empty()) std::abort();
    };
    switch (data[0] % 3) {
        case 0:
            said(cmm::drivers::load_link_settings(work.holds(content)));
            break;
        case 1:
            said(cmm::drivers::modbus::RegisterMap::load(work.holds(content)));
            break;
        default:
            said(cmm::drivers::Endpoint::parse(std::string(content.begin(), content.end())));
    }
    return 0;
}
