// SPDX-License-Identifier: Apache-2.0
#include "acquisition/characteristic_spec.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "acquisition/profile.hpp"
#include "core/text.hpp"
#include "core/units.hpp"

namespace cmm::acquisition {
namespace {

using core::ConfigTable;
using Kind = CharacteristicKind;

struct Row {
    Kind kind;
    std::string_view name, keyword;  // keyword: of the field, empty: none
    Unit unit;
};
constexpr std::array rows{Row{Kind::chord, "chord", "chord", Unit::mm},
                          Row{Kind::axial_chord, "axial_chord", "", Unit::mm},
                          Row{Kind::stagger, "stagger", "chdang", Unit::rad},
                          Row{Kind::max_thickness, "max_thickness", "maxthk", Unit::mm},
                          Row{Kind::max_thickness_position, "max_thickness_position", "", Unit::share},
                          Row{Kind::le_thickness, "le_thickness", "lethck", Unit::mm},
                          Row{Kind::te_thickness, "te_thickness", "tethck", Unit::mm},
                          Row{Kind::le_angle, "le_angle", "leangle", Unit::rad},
                          Row{Kind::te_angle, "te_angle", "teangle", Unit::rad},
                          Row{Kind::le_radius, "le_radius", "", Unit::mm},
                          Row{Kind::te_radius, "te_radius", "", Unit::mm},
                          Row{Kind::area, "area", "", Unit::mm2},
                          Row{Kind::centroid_x, "centroid_x", "", Unit::mm},
                          Row{Kind::centroid_y, "centroid_y", "", Unit::mm},
                          Row{Kind::throat, "throat", "", Unit::mm},
                          Row{Kind::points_out, "points_out", "", Unit::count},
                          Row{Kind::least_curvature, "least_curvature", "", Unit::per_mm},
                          Row{Kind::greatest_curvature, "greatest_curvature", "", Unit::per_mm},
                          Row{Kind::displacement_x, "displacement_x", "", Unit::mm},
                          Row{Kind::displacement_y, "displacement_y", "", Unit::mm},
                          Row{Kind::twist, "twist", "twist", Unit::rad},
                          Row{Kind::profile_form_le, "profile_form_le", "lecont", Unit::mm},
                          Row{Kind::profile_form_suction, "profile_form_suction", "cvcont", Unit::mm},
                          Row{Kind::profile_form_te, "profile_form_te", "tecont", Unit::mm},
                          Row{Kind::profile_form_pressure, "profile_form_pressure", "cccont", Unit::mm},
                          Row{Kind::curvature_deviation, "curvature_deviation", "", Unit::per_mm},
                          Row{Kind::lean_x, "lean_x", "", Unit::mm},
                          Row{Kind::lean_y, "lean_y", "", Unit::mm},
                          Row{Kind::bow_x, "bow_x", "", Unit::mm},
                          Row{Kind::bow_y, "bow_y", "", Unit::mm},
                          Row{Kind::bow_true_position, "bow_true_position", "bowt", Unit::mm},
                          Row{Kind::relative_twist, "relative_twist", "reltwist", Unit::rad},
                          Row{Kind::generatrix, "generatrix", "", Unit::mm}};

const Row& row_of(Kind kind) {
    return rows[static_cast<std::size_t>(kind)];
}

/// 2.5 for 2.500.
std::string short_number(double value) {
    std::string text = core::fixed(value, 3);
    while (text.back() == '0')
        text.pop_back();
    if (text.back() == '.') text.pop_back();
    return text;
}

/// A number whose key carries the unit of the characteristic: nominal_mm, nominal_deg, nominal_mm2, nominal.
class UnitReader {
  public:
    UnitReader(const ConfigTable& table, Unit unit) : table_(table), unit_(unit) {}

    std::string key(std::string_view stem) const { return std::string(stem).append(column_suffix(unit_)); }
    std::optional<double> number(std::string_view stem, core::Bounds bounds) const {
        const double value = table_.number(key(stem), 0.0, bounds);
        if (!table_.has(key(stem))) return std::nullopt;
        return unit_ == Unit::rad ? core::rad_from_deg(value) : value;
    }

  private:
    const ConfigTable& table_;
    Unit unit_;
};

void read_tolerance(const ConfigTable& table, CharacteristicSpec& spec) {
    if (spec.kind == Kind::points_out) {
        spec.nominal = 0.0;
        if (table.has("upper")) spec.above = table.required_number("upper", {0.0, 1e6});
        return;
    }
    const UnitReader reader(table, unit_of(spec.kind));
    spec.nominal = reader.number("nominal", {-1e6, 1e6});
    const auto both = reader.number("tolerance", {1e-9, 1e6});
    const auto below = reader.number("lower", {-1e6, 1e6}), above = reader.number("upper", {-1e6, 1e6});
    if (is_zone_width(spec.kind) || spec.kind == Kind::curvature_deviation) {
        if (spec.nominal || below || above)
            table.complain(reader.key(spec.nominal ? "nominal"
                                      : below      ? "lower"
                                                   : "upper"),
                           spec.kind == Kind::curvature_deviation
                               ? "does not go with the largest deviation either way; say tolerance_per_mm"
                               : "does not go with a tolerance that is the full width of a zone");
        spec.nominal = 0.0;
        spec.above = both;
        return;
    }
    if (both && (below || above)) table.complain(reader.key("tolerance"), "(+-) and lower, upper exclude each other");
    if (below && above && *below >= *above) table.complain(reader.key("lower"), "must be less than upper");
    spec.below = both ? std::optional(-*both) : below;
    spec.above = both ? both : above;
}

void read_method(const ConfigTable& table, CharacteristicSpec& spec) {
    const std::string method = table.text("method", "");
    if (method.empty()) return;
    const auto unknown = [&](const char* known) {
        table.complain("method", "\"" + method + "\" is none of " + known);
        table.ignore_rest();
    };
    switch (spec.kind) {
        case Kind::chord:
            if (const auto found = fitting::chord_method_from(method))
                spec.chord = *found;
            else
                unknown("NOSETAIL, CALIPER, TANGENT, BELAC, XAXIS, RADCENTER, MINCIRCLE, MAXDIST");
            return;
        case Kind::stagger:
            if (const auto found = fitting::stagger_method_from(method))
                spec.stagger = *found;
            else
                unknown("NOSETAIL, CALIPER");
            return;
        case Kind::max_thickness:
            if (core::in_small_letters(method) != "max_inscribed" && core::in_small_letters(method) != "inscribed")
                unknown("MAX_INSCRIBED");
            return;
        case Kind::max_thickness_position:
            if (core::in_small_letters(method) != "chord" && core::in_small_letters(method) != "camber")
                unknown("CHORD, CAMBER");
            if (core::in_small_letters(method) == "camber") spec.position = fitting::PositionMethod::on_camber;
            return;
        default:
            table.complain("method", "is not to be chosen for " + std::string(to_string(spec.kind)));
    }
}

/// Of what needs several sections.
void read_ends(const ConfigTable& table, CharacteristicSpec& spec) {
    const auto section = [&](const char* key) {
        const auto index = table.integer(key, 0, {0.0, 1e6});
        return table.has(key) ? std::optional(static_cast<std::size_t>(index)) : std::nullopt;
    };
    if (spec.kind == Kind::relative_twist) {
        spec.reference_section = section("reference_section");
    } else if (spec.kind == Kind::generatrix) {
        const bool pressure = table.word("side", "suction", {"suction", "pressure"}) == "pressure";
        spec.side = pressure ? fitting::Zone::pressure : fitting::Zone::suction;
        spec.share = table.required_number("share", {0.01, 0.99});
    } else {
        spec.root = section("root_section");
        spec.tip = section("tip_section");
        if (spec.root && spec.root == spec.tip) table.complain("tip_section", "must differ from root_section");
    }
}

/// Of a curvature: one zone, and the window.
void read_window(const ConfigTable& table, CharacteristicSpec& spec) {
    spec.window_mm = table.required_number("window_mm", {1e-2, 1e4});
    if (!table.has("zone")) table.complain("zone", "is missing: le, suction, te or pressure");
    const std::string zone = table.word("zone", "suction", {"le", "suction", "te", "pressure"});
    for (const auto one : {fitting::Zone::le, fitting::Zone::suction, fitting::Zone::te, fitting::Zone::pressure})
        if (zone == fitting::to_string(one)) spec.zone = one;
}

/// Of an edge's radius.
void read_radius_window(const ConfigTable& table, CharacteristicSpec& spec) {
    if (table.has("arc_deg")) spec.radius.arc_rad = core::rad_from_deg(table.required_number("arc_deg", {65.0, 300.0}));
    if (table.has("reach_mm")) spec.radius.reach_mm = table.required_number("reach_mm", {1e-3, 1e3});
    if (spec.radius.arc_rad && spec.radius.reach_mm)
        table.complain("reach_mm", "and arc_deg exclude each other: either says where the window ends");
}

/// Of points_out.
void read_zone(const ConfigTable& table, CharacteristicSpec& spec) {
    const std::string zone = table.word("zone", "all", {"all", "le", "suction", "te", "pressure"});
    for (const auto one : {fitting::Zone::le, fitting::Zone::suction, fitting::Zone::te, fitting::Zone::pressure})
        if (zone == fitting::to_string(one)) spec.zone = one;
    if (table.has("width_mm")) spec.width_mm = table.required_number("width_mm", {1e-6, 1e3});
}

void read_places(const ConfigTable& table, CharacteristicSpec& spec) {
    const core::Bounds distance{1e-3, 1e5};
    const bool thickness = spec.kind == Kind::le_thickness || spec.kind == Kind::te_thickness;
    const bool angle = spec.kind == Kind::le_angle || spec.kind == Kind::te_angle;
    const bool belac = spec.kind == Kind::chord && spec.chord == fitting::ChordMethod::belac;
    if (thickness) spec.distance_mm = table.required_number("distance_mm", distance);
    if (angle) {
        spec.near_mm = table.required_number("near_mm", distance);
        spec.far_mm = table.required_number("far_mm", distance);
        if (spec.far_mm <= spec.near_mm) table.complain("far_mm", "must be larger than near_mm");
        if (table.word("reference", "x", {"x", "chord"}) == "chord") spec.reference = fitting::AngleReference::chord;
    }
    if (spec.kind == Kind::throat) {
        spec.pitch_mm = table.required_number("pitch_mm", distance);
        spec.direction_rad = core::rad_from_deg(table.number("direction_deg", 90.0, {-360.0, 360.0}));
    }
    if (spec.kind == Kind::le_radius || spec.kind == Kind::te_radius) read_radius_window(table, spec);
    if (spec.kind == Kind::points_out) read_zone(table, spec);
    if (is_curvature(spec.kind)) read_window(table, spec);
    if (is_profile_form(spec.kind)) {
        if (table.has("le_change_mm")) spec.le_change_mm = table.required_number("le_change_mm", distance);
        if (table.has("te_change_mm")) spec.te_change_mm = table.required_number("te_change_mm", distance);
    }
    if (is_of_part(spec.kind)) read_ends(table, spec);
    // The generatrix takes the deviations as they are.
    if (needs_best_fit(spec.kind) && spec.kind != Kind::generatrix) spec.fit_zones = read_zone_set(table, "fit_zones");
    if (belac) spec.direction_rad = core::rad_from_deg(table.required_number("direction_deg", {-360.0, 360.0}));
}

void complain_of_name(const ConfigTable& table, const std::string& name) {
    std::array<std::string_view, rows.size()> names;
    std::string list;
    for (std::size_t i = 0; i < rows.size(); ++i) {
        names[i] = rows[i].name;
        list += (i == 0 ? "" : ", ") + std::string(names[i]);
    }
    const auto near = core::nearest_word(name, names);
    table.complain(
        "name", "\"" + name + "\" is none of " + list + (near ? "; did you mean \"" + *near + "\"?" : std::string()));
    table.ignore_rest();
}

bool is_name_of_another(std::string_view label, CharacteristicKind kind) {
    const auto named = characteristic_kind_from(label);
    return (named && named != kind) || std::any_of(profile_zones.begin(), profile_zones.end(),
                                                   [&](const ProfileZone& zone) { return zone.name == label; });
}

}  // namespace

std::string label_of(const CharacteristicSpec& spec, std::string_view method_word) {
    std::string label(to_string(spec.kind));
    const std::string method = core::in_small_letters(method_word);
    const bool usual = method.empty() || method == "nosetail" || method == "max_inscribed" || method == "inscribed";
    if (!usual) label += "_" + method;
    if (spec.distance_mm > 0.0) label += "_" + short_number(spec.distance_mm);
    if (spec.radius.arc_rad) label += "_arc_" + short_number(core::deg_from_rad(*spec.radius.arc_rad));
    if (spec.radius.reach_mm) label += "_reach_" + short_number(*spec.radius.reach_mm);
    if (spec.zone) label += "_" + std::string(fitting::to_string(*spec.zone));
    if (spec.window_mm > 0.0) label += "_" + short_number(spec.window_mm);
    if (spec.kind == Kind::generatrix)
        label += (spec.side == fitting::Zone::pressure ? "_pressure_" : "_suction_") + short_number(spec.share);
    if (spec.far_mm > 0.0) label += "_" + short_number(spec.near_mm) + "_" + short_number(spec.far_mm);
    return label;
}

bool share_a_section(const CharacteristicSpec& a, const CharacteristicSpec& b) {
    if (a.sections.empty() || b.sections.empty()) return true;
    return std::any_of(a.sections.begin(), a.sections.end(), [&](std::size_t i) { return b.is_of(i); });
}

std::string_view to_string(CharacteristicKind kind) noexcept {
    return row_of(kind).name;
}

std::optional<CharacteristicKind> characteristic_kind_from(std::string_view name) {
    const std::string wanted = core::in_small_letters(name);
    for (const Row& row : rows)
        if (row.name == wanted || (!row.keyword.empty() && row.keyword == wanted)) return row.kind;
    return std::nullopt;
}

Unit unit_of(CharacteristicKind kind) noexcept {
    return row_of(kind).unit;
}

bool is_profile_form(CharacteristicKind kind) noexcept {
    return kind >= Kind::profile_form_le && kind <= Kind::profile_form_pressure;
}

bool is_curvature(CharacteristicKind kind) noexcept {
    return kind == Kind::least_curvature || kind == Kind::greatest_curvature || kind == Kind::curvature_deviation;
}

bool is_of_part(CharacteristicKind kind) noexcept {
    return kind >= Kind::lean_x;
}

bool is_zone_width(CharacteristicKind kind) noexcept {
    return is_profile_form(kind) || kind == Kind::bow_true_position || kind == Kind::generatrix;
}

bool needs_best_fit(CharacteristicKind kind) noexcept {
    return kind >= Kind::displacement_x;
}

bool is_position(const CharacteristicSpec& spec) noexcept {
    switch (spec.kind) {
        case Kind::axial_chord:
        case Kind::stagger:
        case Kind::centroid_x:
        case Kind::centroid_y:
        case Kind::throat:
        case Kind::points_out:
        case Kind::displacement_x:
        case Kind::displacement_y:
        case Kind::twist:
            return true;
        case Kind::chord:
            return spec.chord == fitting::ChordMethod::belac || spec.chord == fitting::ChordMethod::x_axis;
        case Kind::le_angle:
        case Kind::te_angle:
            return spec.reference == fitting::AngleReference::x_axis;
        default:
            return false;
    }
}

bool CharacteristicSpec::is_of(std::size_t section) const {
    return sections.empty() || std::find(sections.begin(), sections.end(), section) != sections.end();
}

std::vector<CharacteristicSpec> read_characteristics(const std::vector<core::ConfigTable>& tables) {
    std::vector<CharacteristicSpec> specs;
    for (const ConfigTable& table : tables) {
        CharacteristicSpec spec;
        const std::string name = table.required_text("name");
        const auto kind = characteristic_kind_from(name);
        if (!kind) {
            if (table.has("name")) complain_of_name(table, name);
            continue;
        }
        spec.kind = *kind;
        read_method(table, spec);
        read_places(table, spec);
        read_tolerance(table, spec);
        for (const double index : table.numbers("sections")) {
            if (index < 0.0 || index != std::floor(index) || index > 1e6)
                table.complain("sections", "must be indices of sections, counted from 0");
            else
                spec.sections.push_back(static_cast<std::size_t>(index));
        }
        spec.label = table.text("label", label_of(spec, table.text("method", "")));
        if (is_name_of_another(spec.label, spec.kind))
            table.complain("label", "\"" + spec.label + "\" is the name of another characteristic");
        for (const auto& other : specs)
            if (other.label == spec.label && share_a_section(other, spec))
                table.complain("name", "\"" + spec.label + "\" is asked for twice: give one of them a label");
        specs.push_back(std::move(spec));
    }
    return specs;
}

}  // namespace cmm::acquisition
