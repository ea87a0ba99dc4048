// SPDX-License-Identifier: Apache-2.0
#include <cstdio>

#include "acquisition/json_text.hpp"
#include "acquisition/nominal.hpp"
#include "acquisition/part_file.hpp"
#include "app/commands.hpp"
#include "app/config_keys.hpp"
#include "app/console.hpp"
#include "core/config.hpp"
#include "core/text.hpp"
#include "core/units.hpp"
#include "drivers/machine_file.hpp"
#include "sim/fault_plan.hpp"

namespace cmm::app {
namespace {

std::string kind_text(acquisition::NominalKind kind) {
    switch (kind) {
        case acquisition::NominalKind::sections:
            return "sections";
        case acquisition::NominalKind::parametric:
            return "parametric";
        case acquisition::NominalKind::mesh:
            return "mesh";
        case acquisition::NominalKind::step:
            return "step";
        case acquisition::NominalKind::nom:
            return "nom";
        case acquisition::NominalKind::none:
            return "none";
    }
    return "none";
}

std::string shown(const acquisition::PartFile& part) {
    acquisition::JsonFields fields;
    fields.add("name", part.name).add("serial", part.serial).add("nominal", kind_text(part.nominal.kind));
    std::string files;
    for (const auto& file : part.nominal.files)
        files += (files.empty() ? "" : ",") + acquisition::json_string(file);
    fields.raw("files", "[" + files + "]");
    fields.add("stylus_radius_mm", part.stylus.radius_mm, 4).add("shank_radius_mm", part.stylus.shank_radius_mm, 4);
    std::string heights;
    for (const double z : part.scan.heights_mm)
        heights += (heights.empty() ? "" : ",") + core::fixed(z, 4);
    fields.raw("heights_mm", "[" + heights + "]");
    fields.add("pitch_mm", part.scan.pitch_mm, 4).add("edge_density", part.scan.edge_density, 3);
    fields.add("max_speed_mm_s", part.scan.max_speed_mm_s, 3).add("clearance_mm", part.scan.clearance_mm, 3);
    fields.add("profile_mm", part.gate.profile_mm, 4).add("edge_profile_mm", part.gate.edge_profile_mm, 4);
    return "{" + fields.text() + "}";
}

core::Result<std::string> checked_faults(const std::string& file) {
    const auto plan = sim::load_fault_plan(file);
    if (!plan) return tl::unexpected(plan.error());
    std::string kinds;
    for (const sim::Fault& fault : plan->faults)
        kinds += (kinds.empty() ? "" : ",") + acquisition::json_string(sim::to_string(fault.kind));
    return "{\"faults\":[" + kinds + "]}";
}

/// A machine file has [link] or [controller], a fault plan [[fault]]; anything else is taken for a part file.
core::Result<std::string> checked(const std::string& file) {
    const auto root = core::ConfigTable::load(file);
    if (!root) return tl::unexpected(root.error());
    if (root->has("fault")) return checked_faults(file);
    if (root->has("link") || root->has("controller")) {
        const auto link = drivers::load_link_settings(file);
        if (!link) return tl::unexpected(link.error());
        return "{" +
               acquisition::JsonFields()
                   .add("url", link->endpoint.text())
                   .add("map", link->map_file)
                   .add("response_timeout_ms", link->response_timeout_ms, 1)
                   .text() +
               "}";
    }
    const auto part = acquisition::load_part_to_measure(file);
    if (!part) return tl::unexpected(part.error());
    const auto nominal = acquisition::load_nominal(part->nominal);
    if (!nominal) return tl::unexpected(nominal.error());
    return shown(*part);
}

}  // namespace

int run_config(const ConfigOptions& options) {
    if (options.action == "explain") {
        if (options.json) {
            std::printf("{%s}\n", acquisition::JsonFields().add("keys", config_keys).text().c_str());
        } else {
            std::printf("%s", config_keys);
        }
        return 0;
    }
    if (options.file.empty()) {
        return report(
            {core::ErrorCode::usage, "config " + options.action + " needs a file", {}, core::Motion::not_concerned},
            options.json);
    }
    const auto content = checked(options.file);
    if (!content) return report(content.error(), options.json);
    if (options.json || options.action == "show") {
        std::printf("%s\n", content->c_str());
    } else {
        std::printf("%s: right\n", options.file.c_str());
    }
    return 0;
}

}  // namespace cmm::app
