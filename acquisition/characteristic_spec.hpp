// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "acquisition/section_result.hpp"
#include "acquisition/zone_set.hpp"
#include "core/config.hpp"
#include "fitting/chord_method.hpp"
#include "fitting/edge_radius.hpp"
#include "fitting/thickness_measures.hpp"

namespace cmm::acquisition {

/// What a part file may ask of a section, docs/part-file.md.
enum class CharacteristicKind : std::uint8_t {
    chord,
    axial_chord,
    stagger,
    max_thickness,
    max_thickness_position,
    le_thickness,
    te_thickness,
    le_angle,
    te_angle,
    le_radius,
    te_radius,
    area,
    centroid_x,
    centroid_y,
    throat,
    points_out,
    least_curvature,
    greatest_curvature,
    displacement_x,
    displacement_y,
    twist,
    profile_form_le,
    profile_form_suction,
    profile_form_te,
    profile_form_pressure,
    curvature_deviation,
    lean_x,
    lean_y,
    bow_x,
    bow_y,
    bow_true_position,
    relative_twist,
    generatrix,
};
std::string_view to_string(CharacteristicKind kind) noexcept;
/// By our name or a keyword of the field (CHORD, CHDANG, MAXTHK, LETHCK, TWIST, CCCONT, ...), in capitals or not.
std::optional<CharacteristicKind> characteristic_kind_from(std::string_view name);
Unit unit_of(CharacteristicKind kind) noexcept;
/// Forms after the best fit to the nominal: displacement, twist, profile_form_*, curvature_deviation; what needs
/// several sections.
bool needs_best_fit(CharacteristicKind kind) noexcept;
bool is_profile_form(CharacteristicKind kind) noexcept;
/// Of the curvature over a window of arc length.
bool is_curvature(CharacteristicKind kind) noexcept;
/// Needs several sections (part_characteristics.hpp).
bool is_of_part(CharacteristicKind kind) noexcept;
/// The tolerance is the full width of a zone about nought: profile_form_*, bow_true_position, generatrix.
bool is_zone_width(CharacteristicKind kind) noexcept;
struct CharacteristicSpec;
/// Whether the number changes when the whole section is moved: displacement, centroid, angles and lengths by the axes.
bool is_position(const CharacteristicSpec& spec) noexcept;

/// One [[characteristic]] of a part file. Lengths in mm, angles in rad.
struct CharacteristicSpec {
    CharacteristicKind kind = CharacteristicKind::chord;
    std::string label;  ///< what it is called in the results
    fitting::ChordMethod chord = fitting::ChordMethod::nose_tail;
    fitting::StaggerMethod stagger = fitting::StaggerMethod::nose_tail;
    fitting::PositionMethod position = fitting::PositionMethod::on_chord;
    fitting::AngleReference reference = fitting::AngleReference::x_axis;
    double direction_rad = 0.0;
    double distance_mm = 0.0, near_mm = 0.0, far_mm = 0.0;
    double pitch_mm = 0.0;                                    ///< of a throat, along `direction_rad`
    std::optional<std::size_t> root, tip, reference_section;  ///< absent: the lowest, the highest, the root
    fitting::Zone side = fitting::Zone::suction;              ///< of a generatrix
    std::optional<fitting::Zone> zone;                        ///< of points_out, absent: all of them; of a curvature
    double window_mm = 0.0;                                   ///< of a curvature
    fitting::RadiusWindow radius;                             ///< of an edge's radius; neither: as always reported
    /// Of profile_form_*: how far from its nose LE and TE reach; absent: as far as the contour's edges do.
    std::optional<double> le_change_mm, te_change_mm;
    ZoneSet fit_zones = all_zones;       ///< that take part in the best fit which it follows
    std::optional<double> width_mm;      ///< of its tolerance zone; absent: that of the gate
    double share = 0.0;                  ///< of the side's length, from the LE
    std::optional<double> nominal;       ///< absent: that of the nominal section, by the same method
    std::optional<double> below, above;  ///< tolerance: lowest and highest deviation from the nominal
    std::vector<std::size_t> sections;   ///< by index; empty: all

    bool has_tolerance() const { return below || above; }
    bool has_radius_window() const { return radius.arc_rad || radius.reach_mm; }
    bool is_of(std::size_t section) const;
    bool operator==(const CharacteristicSpec&) const = default;
};

/// What it is called where nobody says otherwise: name, method (a word of the field) unless it is the usual one, zone,
/// distances.
std::string label_of(const CharacteristicSpec& spec, std::string_view method_word);
/// Whether there is a section that both are of.
bool share_a_section(const CharacteristicSpec& a, const CharacteristicSpec& b);

/// Reads the list. Complains of unknown names and methods, of missing distances, of two of one label for one section.
std::vector<CharacteristicSpec> read_characteristics(const std::vector<core::ConfigTable>& tables);

}  // namespace cmm::acquisition
