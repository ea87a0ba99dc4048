// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <optional>

#include "acquisition/first_touch.hpp"
#include "acquisition/json_text.hpp"
#include "acquisition/plan.hpp"
#include "acquisition/plan_check.hpp"
#include "acquisition/plan_times.hpp"
#include "acquisition/touch_way.hpp"
#include "app/ask_machine.hpp"
#include "app/commands.hpp"
#include "app/console.hpp"
#include "core/text.hpp"

namespace cmm::app {
namespace {

using acquisition::JsonFields;

/// A plan and how it would be measured.
struct Planned {
    acquisition::Plan plan;
    bool by_touches = false;
    acquisition::PlanTimes times;
};

void print_plan(const Planned& planned, const std::vector<acquisition::Finding>& findings) {
    const auto& plan = planned.plan;
    std::printf("%s: %zu sections, %s mm to %s, about %s s; plan %s\n", plan.part_name.c_str(), plan.paths.size(),
                core::fixed(plan.length_mm, 1).c_str(), planned.by_touches ? "touch point by point" : "scan",
                core::fixed(planned.times.total_s, 1).c_str(), plan.hash.c_str());
    if (planned.times.alignment_s > 0.0)
        std::printf("six datum points first: %zu touches a round, %d rounds, about %s s of it\n",
                    plan.datum_touches.size(), acquisition::usual_datum_rounds,
                    core::fixed(planned.times.alignment_s, 1).c_str());
    std::printf("section         z   points   length  %s\n", planned.by_touches ? "touch" : " scan");
    for (std::size_t i = 0; i < plan.paths.size(); ++i) {
        const auto& path = plan.paths[i];
        const std::string points = path.points.empty() ? "?" : std::to_string(path.points.size());
        std::printf("%7zu %9s %8s %8s %6s\n", path.section, (core::fixed(path.z_mm, 3)).c_str(), points.c_str(),
                    (core::fixed(path.length_mm, 1) + " mm").c_str(),
                    (core::fixed(planned.times.sections_s[i], 1) + " s").c_str());
    }
    for (const auto& finding : findings) {
        std::printf("%s: %s\n", std::string(acquisition::to_string(finding.severity)).c_str(), finding.text.c_str());
    }
}

std::string plan_json(const Planned& planned, const std::vector<acquisition::Finding>& findings) {
    const auto& plan = planned.plan;
    std::string list;
    for (const auto& finding : findings) {
        list +=
            (list.empty() ? "{" : ",{") +
            JsonFields().add("severity", acquisition::to_string(finding.severity)).add("text", finding.text).text() +
            "}";
    }
    std::string paths;
    for (std::size_t i = 0; i < plan.paths.size(); ++i) {
        const auto& path = plan.paths[i];
        paths += (paths.empty() ? "{" : ",{") +
                 JsonFields()
                     .add("section", path.section)
                     .add("z_mm", path.z_mm, 4)
                     .add("points", path.points.size())
                     .add("length_mm", path.length_mm, 3)
                     .add("duration_s", planned.times.sections_s[i], 2)
                     .text() +
                 "}";
    }
    return "{" +
           JsonFields()
               .add("part", plan.part_name)
               .add("hash", plan.hash)
               .add("length_mm", plan.length_mm, 3)
               .add("by_touches", planned.by_touches)
               .add("duration_s", planned.times.total_s, 2)
               .add("alignment_s", planned.times.alignment_s, 2)
               .raw("paths", "[" + paths + "]")
               .raw("findings", "[" + list + "]")
               .text() +
           "}";
}

}  // namespace

/// With a machine, it is asked for its limits; nothing moves.
int run_plan(const PlanOptions& options) {
    auto part = acquisition::load_part_to_measure(options.part);
    if (!part) return report(part.error(), options.json);
    const auto nominal = acquisition::load_nominal(part->nominal);
    if (!nominal) return report(nominal.error(), options.json);
    std::optional<drivers::Capabilities> machine;
    if (!options.machine.empty()) {
        auto asked = ask_machine(options.machine);
        if (!asked) return report(asked.error(), options.json);
        machine = std::move(asked->capabilities);
    }
    if (*nominal == nullptr && machine) acquisition::bound_by_travel(*part, *machine);
    Planned planned;
    planned.by_touches = options.touch;
    if (machine) {
        const auto chosen = acquisition::measures_by_touches(*machine, options.touch);
        if (!chosen) return report(chosen.error(), options.json);
        planned.by_touches = *chosen;
    }
    const auto* const known = machine ? &*machine : nullptr;
    auto plan = acquisition::make_plan(*part, nominal->get(), known);
    if (!plan) return report(plan.error(), options.json);
    const auto findings = acquisition::check_plan(*plan, *part, nominal->get(), known, planned.by_touches);
    planned.times = acquisition::plan_times(*plan, planned.by_touches);
    planned.plan = std::move(*plan);
    if (!options.out.empty()) {
        if (auto status = core::write_file(options.out, acquisition::plan_to_text(planned.plan)); !status)
            return report(status.error(), options.json);
    }
    if (options.json) {
        std::printf("%s\n", plan_json(planned, findings).c_str());
    } else {
        print_plan(planned, findings);
    }
    if (auto sound = acquisition::require_sound(findings); !sound) return report(sound.error(), false);
    return 0;
}

}  // namespace cmm::app
