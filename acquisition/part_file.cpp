// SPDX-License-Identifier: Apache-2.0
#include "acquisition/part_file.hpp"

#include <algorithm>
#include <utility>

#include "acquisition/file_pattern.hpp"
#include "acquisition/nom_file.hpp"
#include "acquisition/tol_characteristics.hpp"
#include "acquisition/tol_file.hpp"
#include "core/config.hpp"
#include "core/text.hpp"
#include "core/units.hpp"

namespace cmm::acquisition {
namespace {

using core::Bounds;
using core::ConfigTable;

constexpr double smallest_mm = 1e-3;  // lengths below a micrometre are slips of the unit, not parts
constexpr double largest_mm = 1e5;
constexpr Bounds length_mm{smallest_mm, largest_mm};
constexpr Bounds place_mm{-largest_mm, largest_mm};
constexpr std::int64_t most_sections = 100000;

std::optional<Eigen::Vector2d> point(const ConfigTable& table, std::string_view key) {
    const auto values = table.numbers(key);
    if (!table.has(key)) return std::nullopt;
    if (values.size() != 2) {
        table.complain(key, "must be two numbers [x, y] in mm");
        return std::nullopt;
    }
    return Eigen::Vector2d(values[0], values[1]);
}

ParametricBlade read_blade(const ConfigTable& table) {
    ParametricBlade b{};
    const auto angle = [&](std::string_view key, double limit) {
        return core::rad_from_deg(table.required_number(key, {-limit, limit}));
    };
    b.chord_root_mm = table.required_number("chord_root_mm", length_mm);
    b.chord_tip_mm = table.required_number("chord_tip_mm", length_mm);
    b.thickness_root_mm = table.required_number("thickness_root_mm", length_mm);
    b.thickness_tip_mm = table.required_number("thickness_tip_mm", length_mm);
    b.camber_rad = angle("camber_deg", 170.0);
    b.stagger_root_rad = angle("stagger_root_deg", 180.0);
    b.stagger_tip_rad = angle("stagger_tip_deg", 180.0);
    b.le_radius_mm = table.required_number("le_radius_mm", length_mm);
    b.te_radius_mm = table.required_number("te_radius_mm", length_mm);
    b.lean_x_rad = angle("lean_x_deg", 80.0);
    b.lean_y_rad = angle("lean_y_deg", 80.0);
    b.z_root_mm = table.required_number("z_root_mm", place_mm);
    b.z_tip_mm = table.required_number("z_tip_mm", place_mm);
    if (b.z_tip_mm <= b.z_root_mm) table.complain("z_tip_mm", "must be larger than z_root_mm");
    if (b.le_radius_mm + b.te_radius_mm >= b.chord_root_mm) {
        table.complain("chord_root_mm", "must be larger than le_radius_mm + te_radius_mm");
    }
    return b;
}

std::vector<std::string> read_files(const ConfigTable& table) {
    std::vector<std::string> files;
    const auto names = table.texts("files");
    if (names.empty()) table.complain("files", "must name at least one file for this kind of nominal");
    for (const auto& name : names) {
        const std::string resolved = table.resolve(name);
        if (!is_file_pattern(name)) {
            files.push_back(resolved);
            continue;
        }
        auto found = expand_file_pattern(resolved);
        if (found.empty()) table.complain("files", "holds \"" + name + "\", which matches no file (" + resolved + ")");
        std::move(found.begin(), found.end(), std::back_inserter(files));
    }
    return files;
}

NominalSpec read_nominal(const ConfigTable& table) {
    NominalSpec spec;
    if (!table.has("kind"))
        table.complain("kind", "is missing: \"sections\", \"parametric\", \"mesh\", \"step\", \"nom\" or \"none\"");
    const std::string kind = table.word("kind", "none", {"sections", "parametric", "mesh", "step", "nom", "none"});
    const std::string span = table.word("span", "auto", {"auto", "x", "y", "z"});
    spec.span = span == "x" ? Span::x : span == "y" ? Span::y : span == "z" ? Span::z : Span::automatic;
    spec.le_hint_mm = point(table, "le_hint_mm");
    const bool from_files = kind == "sections" || kind == "mesh" || kind == "step" || kind == "nom";
    if (kind == "sections") spec.kind = NominalKind::sections;
    if (kind == "mesh") spec.kind = NominalKind::mesh;
    if (kind == "step") spec.kind = NominalKind::step;
    if (kind == "nom") spec.kind = NominalKind::nom;
    spec.skip = table.texts("skip");
    if (kind != "nom" && !spec.skip.empty()) table.complain("skip", "is for kind = \"nom\" only");
    if (kind == "nom" && span != "auto" && span != "z") table.complain("span", "is z in a nominal file (.NOM)");
    spec.solid = table.text("solid", "");
    if (kind != "step" && table.has("solid")) table.complain("solid", "is for kind = \"step\" only");
    if (kind == "parametric") {
        spec.kind = NominalKind::parametric;
        spec.blade = read_blade(table.table("blade"));
    } else if (table.has("blade")) {
        table.complain("blade", "is for kind = \"parametric\" only");
        table.ignore("blade");
    }
    if (from_files) {
        spec.files = read_files(table);
    } else if (!table.texts("files").empty()) {
        table.complain("files", "is for kind = \"sections\", \"mesh\", \"step\" and \"nom\" only");
    }
    if (kind != "sections" && spec.files.size() > 1)
        table.complain("files", "must name one file for this kind of nominal");
    return spec;
}

StylusSpec read_stylus(const ConfigTable& table) {
    StylusSpec stylus;
    stylus.radius_mm = table.number("radius_mm", stylus.radius_mm, {smallest_mm, 10.0});
    stylus.radius_given = table.has("radius_mm");
    // A thin shaft is the rule: six tenths of the ball where the file does not say it.
    stylus.shank_radius_mm = table.number("shank_radius_mm", 0.6 * stylus.radius_mm, {1e-4, 10.0});
    stylus.length_mm = table.number("length_mm", stylus.length_mm, {0.1, 1000.0});
    if (stylus.shank_radius_mm >= stylus.radius_mm) {
        table.complain("shank_radius_mm", "must be smaller than radius_mm");
    }
    if (stylus.length_mm <= stylus.radius_mm) table.complain("length_mm", "must be larger than radius_mm");
    return stylus;
}

std::vector<double> read_heights(const ConfigTable& table, NominalKind nominal) {
    auto heights = table.numbers("heights_mm");
    const double from = table.number("from_mm", 0.0, place_mm);
    const double to = table.number("to_mm", 0.0, place_mm);
    const auto count = table.integer("count", 0, {1.0, static_cast<double>(most_sections)});
    const bool range = table.has("from_mm") || table.has("to_mm") || table.has("count");
    if (table.has("heights_mm")) {
        if (range) table.complain("heights_mm", "and from_mm/to_mm/count exclude each other: give one of the two");
        if (heights.empty()) table.complain("heights_mm", "must hold at least one height in mm");
        const bool ascending =
            std::adjacent_find(heights.begin(), heights.end(), std::greater_equal<>()) == heights.end();
        if (!ascending) table.complain("heights_mm", "must ascend");
        for (const double z : heights) {
            if (std::abs(z) > largest_mm) table.complain("heights_mm", "must lie within +-100000 mm");
        }
        return heights;
    }
    if (!range) {
        if (nominal == NominalKind::nom) return heights;  // those of its sections
        table.complain("heights_mm", "is missing (or from_mm, to_mm and count)");
        return heights;
    }
    for (const std::string_view key : {"from_mm", "to_mm", "count"}) {
        if (!table.has(key)) table.complain(key, "is missing: from_mm, to_mm and count go together");
    }
    if (count > 1 && to <= from) table.complain("to_mm", "must be larger than from_mm");
    if (count == 1 && to < from) table.complain("to_mm", "must not be smaller than from_mm");
    for (std::int64_t i = 0; i < std::min(count, most_sections); ++i) {
        heights.push_back(count == 1 ? from
                                     : from + (to - from) * static_cast<double>(i) / static_cast<double>(count - 1));
    }
    return heights;
}

constexpr double most_extra_passes = 5.0;

ScanSpec read_scan(const ConfigTable& table, NominalKind nominal) {
    ScanSpec scan;
    scan.heights_mm = read_heights(table, nominal);
    scan.pitch_mm = table.number("pitch_mm", scan.pitch_mm, {0.002, 100.0});
    scan.edge_density = table.number("edge_density", scan.edge_density, {1.0, 100.0});
    scan.max_speed_mm_s = table.number("max_speed_mm_s", scan.max_speed_mm_s, {0.01, 600.0});
    scan.clearance_mm = table.number("clearance_mm", scan.clearance_mm, {0.1, 1000.0});
    scan.approach_mm = table.number("approach_mm", scan.approach_mm, {0.05, 100.0});
    scan.search_mm = table.number("search_mm", scan.search_mm, {0.01, 100.0});
    scan.wait_s = table.number("wait_s", scan.wait_s, {0.0, 86400.0});
    scan.stop_when_rejected = table.boolean("stop_when_rejected", scan.stop_when_rejected);
    UntilDecided again;
    const bool until_decided = table.boolean("until_decided", false);
    again.passes = static_cast<std::size_t>(
        table.integer("extra_passes", static_cast<std::int64_t>(again.passes), {1.0, most_extra_passes}));
    again.seconds = table.number("extra_s", again.seconds, {1.0, 86400.0});
    if (until_decided) scan.until_decided = again;
    for (const std::string_view key : {"extra_passes", "extra_s"})
        if (table.has(key) && !until_decided) table.complain(key, "needs until_decided = true");
    if (until_decided && nominal == NominalKind::none) table.complain("until_decided", "needs a nominal");
    scan.start_mm = point(table, "start_mm");
    scan.toward_mm = point(table, "toward_mm");
    const auto box = table.numbers("box_mm");
    if (table.has("box_mm")) {
        if (box.size() != 4 || box[2] <= box[0] || box[3] <= box[1]) {
            table.complain("box_mm", "must be four numbers [x0, y0, x1, y1] in mm with x0 < x1 and y0 < y1");
        } else {
            scan.box_mm = std::array<double, 4>{box[0], box[1], box[2], box[3]};
        }
    }
    if (nominal != NominalKind::none) {
        for (const std::string_view key : {"start_mm", "toward_mm", "box_mm"}) {
            if (table.has(key)) table.complain(key, "is for nominal.kind = \"none\" only");
        }
    }
    if (scan.start_mm && scan.toward_mm && (*scan.start_mm - *scan.toward_mm).norm() < smallest_mm) {
        table.complain("toward_mm", "must differ from start_mm");
    }
    return scan;
}

std::optional<fitting::EdgeModel> read_edge_model(const ConfigTable& table, std::string_view key) {
    return fitting::edge_model_from(
        table.word(key, "auto", {"auto", "free", "arc", "ellipse", "double_arc", "parabola"}));
}

fitting::FilterSpec read_filter(const ConfigTable& table, const std::string& zones) {
    const std::string kind_key = zones + "_filter", cutoff_key = zones + "_cutoff_mm";
    const auto kind =
        fitting::filter_kind_from(table.word(kind_key, "none", {"none", "gaussian", "spline", "robust_gaussian"}));
    fitting::FilterSpec filter;
    filter.kind = kind.value_or(filter.kind);
    filter.cutoff_mm = table.number(cutoff_key, filter.cutoff_mm, {smallest_mm, 1000.0});
    const bool filters = filter.kind != fitting::FilterKind::none;
    if (filters && !table.has(cutoff_key)) table.complain(cutoff_key, "is missing: a filter has a cut-off wavelength");
    if (!filters && table.has(cutoff_key)) table.complain(cutoff_key, "needs " + kind_key);
    return filter;
}

FittingSpec read_fitting(const ConfigTable& table, NominalKind nominal) {
    using fitting::Zone;
    FittingSpec spec;
    spec.le_model = read_edge_model(table, "le_model");
    spec.te_model = read_edge_model(table, "te_model");
    const auto names = fitting::compensation_method_names();
    const auto method =
        fitting::compensation_method_from(table.word("compensation", "3d", {names.begin(), names.end()}));
    spec.compensation = method.value_or(spec.compensation);
    if (spec.compensation == CompensationMethod::point_distance && nominal == NominalKind::none)
        table.complain("compensation", "\"point_distance\" needs a nominal");
    spec.fairing_mm = table.number("fairing_mm", 0.0, {0.0, 1.0});
    spec.filters.at(Zone::suction) = spec.filters.at(Zone::pressure) = read_filter(table, "side");
    spec.filters.at(Zone::le) = spec.filters.at(Zone::te) = read_filter(table, "edge");
    return spec;
}

GateSpec read_gate(const ConfigTable& table) {
    GateSpec gate;
    const double profile = table.number("profile_mm", 0.0, {1e-4, 100.0});
    const double edge = table.number("edge_profile_mm", 0.0, {1e-4, 100.0});
    if (table.has("profile_mm")) gate.profile_mm = profile;
    if (table.has("edge_profile_mm")) gate.edge_profile_mm = edge;
    const auto method = decision_method_from(
        table.word("decision_rule", "iso_14253_1", {"iso_14253_1", "simple", "stringent", "relaxed"}));
    gate.rule.method = method.value_or(gate.rule.method);
    gate.rule.risk = table.number("risk", gate.rule.risk, {1e-4, 0.25});
    return gate;
}

ToleranceSpec read_tolerance_table(const ConfigTable& table) {
    ToleranceSpec spec;
    const std::string file = table.text("file", "");
    spec.skip = table.texts("skip");
    if (!file.empty()) spec.file = table.resolve(file);
    if (file.empty() && table.has("skip")) table.complain("file", "is missing: the tolerance file (.TOL)");
    return spec;
}

/// Heights of the sections and tolerances, where files of PC-DMIS Blade say them.
core::Status take_blade_files(PartFile& part) {
    std::optional<NomFile> nom;
    if (part.nominal.kind == NominalKind::nom) {
        auto read = read_nom(part.nominal.files.at(0), part.nominal.skip);
        if (!read) return tl::unexpected(std::move(read.error()).with_context("while reading the nominal"));
        nom = std::move(*read);
    }
    if (nom && part.scan.heights_mm.empty()) {
        for (const auto& section : nom->sections) {
            if (section.skewed)
                return core::fail(core::ErrorCode::config_invalid,
                                  part.path + ": scan.heights_mm is missing: section " + section.name +
                                      " of the nominal is skewed and has no height to be measured at");
            part.scan.heights_mm.push_back(section.z_mm);
        }
        std::sort(part.scan.heights_mm.begin(), part.scan.heights_mm.end());
    }
    if (part.tolerance.file.empty()) return {};
    const auto content = core::read_file(part.tolerance.file);
    if (!content) return tl::unexpected(content.error());
    const auto tol = parse_tol(*content, part.tolerance.file, part.tolerance.skip, nom && nom->inches);
    if (!tol) return tl::unexpected(tol.error());
    auto specs = characteristics_of(*tol, nom ? &*nom : nullptr, part.scan.heights_mm);
    if (!specs) return tl::unexpected(specs.error());
    for (auto& spec : *specs) {
        for (const auto& other : part.gate.characteristics)
            if (other.label == spec.label && share_a_section(other, spec))
                return core::fail(core::ErrorCode::config_invalid,
                                  part.path + ": \"" + spec.label + "\" is asked for by a [[characteristic]] and by " +
                                      part.tolerance.file + ": take one of them out, or give the first a label");
    }
    std::move(specs->begin(), specs->end(), std::back_inserter(part.gate.characteristics));
    return {};
}

void check_sections(const ConfigTable& root, std::size_t count) {
    const auto check = [&](const ConfigTable& table, std::string_view key, double index) {
        if (index >= static_cast<double>(count))
            table.complain(key, "names section " + core::fixed(index, 0) + ", but the last one of [scan] is section " +
                                    std::to_string(count - 1) + ": they count from 0");
    };
    for (const ConfigTable& table : root.tables("characteristic")) {
        for (const double index : table.numbers("sections"))
            check(table, "sections", index);
        for (const std::string_view key : {"root_section", "tip_section", "reference_section"})
            check(table, key, table.number(key, 0.0));
    }
}

}  // namespace

core::Result<PartFile> load_part_file(const std::string& path) {
    auto text = core::read_file(path);
    if (!text) return tl::unexpected(text.error());
    return parse_part_file(*text, path);
}

core::Result<PartFile> load_part_to_measure(const std::string& path) {
    auto text = core::read_file(path);
    if (!text) return tl::unexpected(text.error());
    const auto root = ConfigTable::parse(*text, path);
    if (!root) return tl::unexpected(root.error());
    auto part = read_part_file(*root);
    if (!part) return part;
    part->text = std::move(*text);
    check_sections(*root, part->scan.heights_mm.size());
    if (auto status = root->finish(); !status) return tl::unexpected(std::move(status.error()));
    return part;
}

core::Result<PartFile> parse_part_file(std::string_view text, const std::string& path) {
    const auto root = ConfigTable::parse(text, path);
    if (!root) return tl::unexpected(root.error());
    auto part = read_part_file(*root);
    if (part) part->text = std::string(text);
    return part;
}

core::Result<PartFile> read_part_file(const ConfigTable& root) {
    PartFile part;
    part.path = root.file();
    const auto table = root.table("part");
    part.name = table.required_text("name");
    if (table.has("name") && core::trim(part.name).empty()) table.complain("name", "must not be empty");
    table.word("kind", "blade", {"blade"});
    part.serial = table.text("serial", "");
    part.nominal = read_nominal(root.table("nominal"));
    part.stylus = read_stylus(root.table("stylus"));
    part.scan = read_scan(root.table("scan"), part.nominal.kind);
    part.fitting = read_fitting(root.table("fitting"), part.nominal.kind);
    part.gate = read_gate(root.table("gate"));
    if (part.scan.until_decided) part.gate.rule.looks = 1 + part.scan.until_decided->passes;
    part.gate.characteristics = read_characteristics(root.tables("characteristic"));
    part.alignment = read_alignment(root.table("alignment"), part.nominal.kind != NominalKind::none,
                                    part.gate.profile_mm.has_value(), part.gate.edge_profile_mm.has_value());
    part.tolerance = read_tolerance_table(root.table("tolerance"));
    part.uncertainty = read_uncertainty(root.table("uncertainty"));
    root.ignore("actual");
    if (auto status = root.finish(); !status) return tl::unexpected(std::move(status.error()));
    if (auto status = take_blade_files(part); !status) return tl::unexpected(std::move(status.error()));
    return part;
}

core::Result<GateSpec> load_gate_file(const std::string& path) {
    const auto root = ConfigTable::load(path);
    if (!root) return tl::unexpected(root.error());
    for (const char* other :
         {"part", "nominal", "stylus", "scan", "fitting", "alignment", "tolerance", "uncertainty", "actual"})
        root->ignore(other);
    if (!root->has("gate") && !root->has("characteristic"))
        root->complain("gate", "is missing: a table with profile_mm, edge_profile_mm");
    auto gate = read_gate(root->table("gate"));
    gate.characteristics = read_characteristics(root->tables("characteristic"));
    if (auto status = root->finish(); !status) return tl::unexpected(status.error());
    return gate;
}

}  // namespace cmm::acquisition
