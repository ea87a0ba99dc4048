// SPDX-License-Identifier: Apache-2.0
// Files that say what is measured and how it is judged: part files, gates, plans. The first byte chooses.
#include <cstdlib>

#include "acquisition/part_file.hpp"
#include "acquisition/plan.hpp"
#include "fuzz/work_file.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace cmm::acquisition;
    if (size == 0) return 0;
    static const WorkFile work(".toml");
    const std::span<const std::uint8_t> content(data + 1, size - 1);
    const std::string text(content.begin(), content.end());
    switch (data[0] % 3) {
        case 0:
            static_cast<void>(parse_part_file(text, "part.toml"));
            break;
        case 1:
            static_cast<void>(load_gate_file(work.holds(content)));
            break;
        default:
            // A plan that was read is written and read as the same plan.
            if (const auto plan = parse_plan(text, "plan.json")) {
                const auto again = parse_plan(plan_to_text(*plan), "plan.json");
                if (!again || plan_hash(*again) != plan_hash(*plan)) std::abort();
            }
    }
    return 0;
}
