// SPDX-License-Identifier: Apache-2.0
// Files that the simulator reads: meshes, sections, fault plans, its machine. The first byte chooses.
#include "fuzz/work_file.hpp"
#include "sim/fault_plan.hpp"
#include "sim/machine_file.hpp"
#include "sim/mesh_file.hpp"
#include "sim/section_file.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace cmm::sim;
    if (size == 0) return 0;
    static const WorkFile work(".toml");
    const std::span<const std::uint8_t> content(data + 1, size - 1);
    const std::string text(content.begin(), content.end());
    switch (data[0] % 5) {
        case 0:
            static_cast<void>(parse_ply(text, "part.ply"));
            break;
        case 1:
            static_cast<void>(parse_stl(text, "part.stl"));
            break;
        case 2:
            static_cast<void>(parse_sections(text, "part.crv"));
            break;
        case 3:
            static_cast<void>(load_fault_plan(work.holds(content)));
            break;
        default:
            static_cast<void>(load_machine_settings(work.holds(content)));
    }
    return 0;
}
