// SPDX-License-Identifier: Apache-2.0
#include <cstdio>

#include "acquisition/json_text.hpp"
#include "acquisition/nominal.hpp"
#include "acquisition/part_file.hpp"
#include "app/commands.hpp"
#include "app/console.hpp"
#include "core/config.hpp"
#include "core/text.hpp"
#include "core/units.hpp"
#include "drivers/machine_file.hpp"
#include "sim/fault_plan.hpp"

namespace cmm::app {
namespace {

constexpr const char* part_keys = R"(part file (docs/part-file.md):
  [part]    name, kind = "blade", serial
  [nominal] kind = "sections" | "parametric" | "mesh" | "step" | "nom" | "none", files, solid (of a STEP file),
            skip (of a .NOM file), span = "auto" | "x" | "y" | "z", le_hint_mm
  [nominal.blade] chord_root_mm, chord_tip_mm, thickness_root_mm, thickness_tip_mm, camber_deg, stagger_root_deg,
            stagger_tip_deg, le_radius_mm, te_radius_mm, lean_x_deg, lean_y_deg, z_root_mm, z_tip_mm
  [stylus]  radius_mm, shank_radius_mm, length_mm
  [scan]    heights_mm or from_mm, to_mm, count; pitch_mm, edge_density, max_speed_mm_s, clearance_mm, approach_mm,
            search_mm, wait_s, stop_when_rejected; without a nominal: start_mm, toward_mm, box_mm
  [gate]    profile_mm, edge_profile_mm
  [tolerance] file (.TOL), skip
  [uncertainty] part_temperature_c, temperature_standard_k, expansion_um_m_k, expansion_standard_um_m_k,
            expansion_correction = "none" | "applied" | "by_machine", fixed_at_mm, and those of a machine file
  [[characteristic]] name, method, label, sections, nominal_*, tolerance_* or lower_* and upper_* (mm, deg, mm2, per_mm or nothing);
            distance_mm, near_mm, far_mm, reference, direction_deg, zone, window_mm
  [actual]  (simulation) kind, files, span, noise_um, bad_points_percent, thicken_mm, twist_deg, shift_mm, growth_um_m,
            ball_error_um, lobes_um, lobes, lobes_from_deg, scale_um_m, squareness_um_m; [actual.blade]
machine file (config/machines/*.toml):
  [link]    url, map, timeouts
  [dro]     (dro+serial, docs/dro.md) format, numbers = "decimal" | "integer", unit = "mm" | "inch", count, decimals,
            decimal_comma, point_tags, end, request, request_every_ms
  [linuxcnc] (linuxcnc, docs/linuxcnc.md) connect_password, enable_password, joints, reset_estop, limit_min_mm,
            limit_max_mm, max_speed_mm_s, max_acceleration_mm_s2, latch_delay_us, home_patience_s
  [uncertainty] length_um, length_k_mm_per_um, probing_form_um, probing_size_um, ball_radius_standard_um
  [controller] (simulation) limits, speeds, sample clock
register map (config/maps/*.toml): docs/protocol-modbus.md
fault plan (config/faults/*.toml, docs/reliability.md):
  seed, [[fault]] what; samples, requests or seconds; again, for_s, times and what belongs to the kind
)";

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
    const auto part = acquisition::load_part_file(file);
    if (!part) return tl::unexpected(part.error());
    const auto nominal = acquisition::load_nominal(part->nominal);
    if (!nominal) return tl::unexpected(nominal.error());
    return shown(*part);
}

}  // namespace

int run_config(const ConfigOptions& options) {
    if (options.action == "explain") {
        if (options.json) {
            std::printf("{%s}\n", acquisition::JsonFields().add("keys", part_keys).text().c_str());
        } else {
            std::printf("%s", part_keys);
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
