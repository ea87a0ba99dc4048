// SPDX-License-Identifier: Apache-2.0
#pragma once

/// What `cmmlive config explain` prints: every table and key of the files that people write. A test compares it with
/// what the readers ask for.
namespace cmm::app {

inline constexpr const char* config_keys = R"(part file (docs/part-file.md):
  [part]    name, kind = "blade", serial
  [nominal] kind = "sections" | "parametric" | "mesh" | "step" | "nom" | "none", files, solid (of a STEP file),
            skip (of a .NOM file), span = "auto" | "x" | "y" | "z", le_hint_mm
  [nominal.blade] chord_root_mm, chord_tip_mm, thickness_root_mm, thickness_tip_mm, camber_deg, stagger_root_deg,
            stagger_tip_deg, le_radius_mm, te_radius_mm, lean_x_deg, lean_y_deg, z_root_mm, z_tip_mm
  [stylus]  radius_mm, shank_radius_mm, length_mm
  [scan]    heights_mm or from_mm, to_mm, count; pitch_mm, edge_density, max_speed_mm_s, clearance_mm, approach_mm,
            search_mm, wait_s, stop_when_rejected, until_decided, extra_passes, extra_s;
            without a nominal: start_mm, toward_mm, box_mm
  [fitting] le_model, te_model = "auto" | "arc" | "ellipse" | "double_arc" | "parabola" | "free",
            compensation = "3d" | "2d" | those of docs/compensation.md, fairing_mm,
            side_filter, edge_filter = "none" | "gaussian" | "spline" | "robust_gaussian", side_cutoff_mm, edge_cutoff_mm
  [alignment] kind = "none" | "six_points" | "rps" | "section" | "blade";
            of a best fit: objective = "least_squares" | "min_max" | "into_tolerance", translation = "xy" | "x" | "y" | "none",
            rotation = "free" | "fixed", zones; of datum points: residual_mm, moved_mm, most_rounds, touch_standard_mm,
            largest_condition, approach_mm, search_mm
  [[alignment.point]] at_mm, direction; of a middle also: opposite_mm, opposite_direction
  [gate]    profile_mm, edge_profile_mm, decision_rule = "iso_14253_1" | "simple" | "stringent" | "relaxed", risk
  [tolerance] file (.TOL), skip
  [uncertainty] part_temperature_c, temperature_standard_k, expansion_um_m_k, expansion_standard_um_m_k,
            expansion_correction = "none" | "applied" | "by_machine", fixed_at_mm; and the keys of a machine file
  [[characteristic]] name, method, label, sections, nominal_*, tolerance_* or lower_* and upper_* (mm, deg, mm2, per_mm), of
            a number without a unit nominal, tolerance or lower and upper; what belongs to a name: distance_mm, near_mm, far_mm,
            reference = "x" | "chord", direction_deg, pitch_mm, zone, width_mm, window_mm, arc_deg, reach_mm, fit_zones, le_change_mm, te_change_mm,
            root_section, tip_section, reference_section, side = "suction" | "pressure", share
  [actual]  (simulation) kind = "nominal" | "parametric" | "sections" | "mesh", files, span, noise_um, bad_points_percent,
            thicken_mm, twist_deg, shift_mm, stands_at_mm, stands_turned_deg, growth_um_m, ball_error_um,
            lobes_um, lobes, lobes_from_deg, scale_um_m, squareness_um_m
  [actual.blade] the keys of [nominal.blade]
machine file (config/machines/*.toml):
  [link]    url, map, connect_timeout_ms, response_timeout_ms, reconnect_ms, poll_ms
  [dro]     (dro+serial, docs/dro.md) format, numbers = "decimal" | "integer", unit = "mm" | "inch", count, decimals,
            decimal_comma, point_tags, end, request, request_every_ms
  [linuxcnc] (linuxcnc, docs/linuxcnc.md) connect_password, enable_password, joints, reset_estop, limit_min_mm,
            limit_max_mm, max_speed_mm_s, max_acceleration_mm_s2, latch_delay_us, home_patience_s
  [uncertainty] length_um, length_k_mm_per_um, probing_form_um, probing_size_um, ball_radius_standard_um
  [controller] (simulation) model, serial, lsb_nm, limit_min_mm, limit_max_mm, home_mm, max_speed_mm_s, max_accel_mm_s2,
            sample_rate_hz, fifo_depth, path_capacity, watchdog_ms
register map (config/maps/*.toml): docs/protocol-modbus.md
fault plan (config/faults/*.toml, docs/reliability.md):
  seed, [[fault]] what; samples, requests or seconds; again, for_s, times and what belongs to the kind
)";

}  // namespace cmm::app
