// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "core/config.hpp"
#include "core/text.hpp"
#include "core/units.hpp"
#include "sim/geometry_source.hpp"
#include "sim/grown.hpp"
#include "sim/offset.hpp"
#include "sim/placed.hpp"
#include "sim/surface.hpp"

namespace cmm::sim {

using core::ConfigTable;
using core::Result;

namespace {

struct PartNumbers {
    Part part;
    Deviation deviation;
    double thicken_mm = 0.0, growth = 0.0, ball_error_mm = 0.0;
    Eigen::Vector3d stands_at_mm = Eigen::Vector3d::Zero(), stands_turned_rad = Eigen::Vector3d::Zero();
};

/// Zero where it is not said.
Eigen::Vector3d read_three(const ConfigTable& table, const char* key) {
    const auto values = table.numbers(key);
    if (!table.has(key)) return Eigen::Vector3d::Zero();
    if (values.size() == 3) return {values[0], values[1], values[2]};
    table.complain(key, "must be three numbers [x, y, z]");
    return Eigen::Vector3d::Zero();
}

/// What both [nominal] and [actual] say about geometry.
GeometrySource read_source(const ConfigTable& table, const std::string& kind) {
    GeometrySource source;
    source.where = table.where("kind");
    if (kind == "sections" || kind == "mesh") {
        source.kind = kind == "mesh" ? GeometrySource::Kind::mesh : GeometrySource::Kind::sections;
        const auto names = table.texts("files");
        if (names.empty()) table.complain("files", "must name at least one file");
        if (kind == "mesh" && names.size() > 1) table.complain("files", "must be one .ply or .stl");
        for (const auto& name : names)
            source.files.push_back(table.resolve(name));
    } else {
        source.kind = GeometrySource::Kind::parametric;
        source.blade = read_blade(table.table("blade"));
    }
    if (kind != "sections") {
        table.word("span", "auto", {"x", "y", "z", "auto"});  // may stay in the file when the kind changes
    } else {
        source.span = table.word("span", "auto", {"x", "y", "z", "auto"});
    }
    return source;
}

void read_stylus(const ConfigTable& stylus, Part& part) {
    part.ball_radius_mm = stylus.number("radius_mm", 1.0, {0.0, 10.0});
    if (part.ball_radius_mm <= 0.0) stylus.complain("radius_mm", "must be above 0");
    const double shank = stylus.number("shank_radius_mm", 0.6 * part.ball_radius_mm);
    if (!(shank > 0.0 && shank < part.ball_radius_mm))
        stylus.complain("shank_radius_mm", "must be above 0 and below radius_mm");
    if (stylus.number("length_mm", 20.0) <= 0.0) stylus.complain("length_mm", "must be above 0");
}

constexpr double share_from_um_m = 1e-6;

/// What the machine, the probe and the temperature do to every point alike.
void read_errors(const ConfigTable& actual, PartNumbers& numbers) {
    MachineError& error = numbers.part.error;
    error.scale = share_from_um_m * read_three(actual, "scale_um_m");
    error.squareness = share_from_um_m * read_three(actual, "squareness_um_m");
    error.lobes_mm = core::mm_from_um(actual.number("lobes_um", 0.0, {0.0, 1000.0}));
    error.lobes = static_cast<int>(actual.integer("lobes", error.lobes, {1.0, 12.0}));
    error.lobes_from_rad = core::rad_from_deg(actual.number("lobes_from_deg", 0.0, {-360.0, 360.0}));
    numbers.ball_error_mm = core::mm_from_um(actual.number("ball_error_um", 0.0, {-100.0, 100.0}));
    numbers.growth = share_from_um_m * actual.number("growth_um_m", 0.0, {-10000.0, 10000.0});
}

void read_actual(const ConfigTable& actual, PartNumbers& numbers) {
    read_errors(actual, numbers);
    numbers.part.noise_mm = core::mm_from_um(actual.number("noise_um", 1.0, {0.0, 1000.0}));
    numbers.part.bad_points_share = actual.number("bad_points_percent", 1.0, {0.0, 100.0}) / 100.0;
    numbers.thicken_mm = actual.number("thicken_mm", 0.0, {-10.0, 10.0});
    numbers.deviation.twist_rad = core::rad_from_deg(actual.number("twist_deg", 0.0, {-90.0, 90.0}));
    numbers.stands_at_mm = read_three(actual, "stands_at_mm");
    numbers.stands_turned_rad = core::rad_from_deg(1.0) * read_three(actual, "stands_turned_deg");
    const auto shift = actual.numbers("shift_mm");
    if (actual.has("shift_mm") && shift.size() != 2 && shift.size() != 3)
        actual.complain("shift_mm", "must be [x, y] or [x, y, z]");
    for (std::size_t i = 0; i < std::min<std::size_t>(3, shift.size()); ++i) {
        numbers.deviation.shift_mm[static_cast<Eigen::Index>(i)] = shift[i];
    }
}

/// [nominal] with its other keys, so that a misspelt one is found here too; its geometry when `wanted`.
GeometrySource read_nominal(const ConfigTable& nominal, bool wanted) {
    const std::string kind = nominal.word("kind", "none", {"sections", "parametric", "mesh", "step", "nom", "none"});
    nominal.text("solid", "");
    nominal.texts("skip");
    const auto hint = nominal.numbers("le_hint_mm");
    if (nominal.has("le_hint_mm") && hint.size() != 2) nominal.complain("le_hint_mm", "must be [x, y]");
    if (kind != "none" && kind != "step" && kind != "nom") return read_source(nominal, kind);
    nominal.texts("files");
    nominal.word("span", "auto", {"x", "y", "z", "auto"});
    if (wanted && kind == "none")
        nominal.complain("kind",
                         "is \"none\" and [actual] has no geometry: there is nothing to simulate; give actual.kind");
    if (wanted && (kind == "step" || kind == "nom"))
        nominal.complain("kind", "is \"" + kind +
                                     "\", which the simulator does not read: give actual.kind, for example "
                                     "\"mesh\" with an STL of the part");
    return {};
}

}  // namespace

Result<Part> load_part(const std::string& part_file) {
    const auto root = ConfigTable::load(part_file);
    if (!root) return tl::unexpected(root.error());
    return read_part(*root);
}

Result<Part> read_part(const ConfigTable& root) {
    PartNumbers numbers;
    const ConfigTable part = root.table("part");
    numbers.part.name = part.required_text("name");
    part.word("kind", "blade", {"blade"});
    part.text("serial", "");
    for (const char* of_the_host :
         {"scan", "fitting", "alignment", "gate", "tolerance", "characteristic", "uncertainty"})
        root.ignore(of_the_host);
    read_stylus(root.table("stylus"), numbers.part);
    const ConfigTable actual = root.table("actual");
    read_actual(actual, numbers);
    const std::string kind = actual.word("kind", "nominal", {"nominal", "parametric", "sections", "mesh"});
    GeometrySource source = read_nominal(root.table("nominal"), kind == "nominal");
    if (kind != "nominal") {
        source = read_source(actual, kind);
    } else {
        actual.texts("files");
        actual.word("span", "auto", {"x", "y", "z", "auto"});
    }
    if (auto status = root.finish(); !status) return tl::unexpected(status.error());

    numbers.part.ball_radius_mm += numbers.ball_error_mm;
    source.beyond_mm = numbers.part.ball_radius_mm;
    auto surface = build_surface(source, numbers.deviation, numbers.part.remarks);
    if (!surface) return tl::unexpected(surface.error());
    numbers.part.surface =
        numbers.thicken_mm == 0.0 ? *surface : std::make_shared<OffsetSurface>(*surface, 0.5 * numbers.thicken_mm);
    if (numbers.growth != 0.0)
        numbers.part.surface = std::make_shared<GrownSurface>(numbers.part.surface, 1.0 + numbers.growth);
    if (!numbers.stands_at_mm.isZero(0.0) || !numbers.stands_turned_rad.isZero(0.0)) {
        numbers.part.surface =
            std::make_shared<PlacedSurface>(numbers.part.surface, numbers.stands_at_mm, numbers.stands_turned_rad);
    }
    return std::move(numbers.part);
}

}  // namespace cmm::sim
