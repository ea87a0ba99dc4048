// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/alignment.hpp"
#include "acquisition/characteristic_spec.hpp"
#include "acquisition/decision_rule.hpp"
#include "acquisition/uncertainty_spec.hpp"
#include "acquisition/until_decided.hpp"
#include "core/config.hpp"
#include "core/error.hpp"
#include "fitting/compensation_method.hpp"
#include "fitting/edge_kind.hpp"
#include "fitting/filter.hpp"

namespace cmm::acquisition {

enum class NominalKind { sections, parametric, mesh, step, nom, none };
enum class Span { automatic, x, y, z };

/// The numbers of docs/part-file.md, "The parametric blade".
struct ParametricBlade {
    double chord_root_mm, chord_tip_mm, thickness_root_mm, thickness_tip_mm;
    double camber_rad, stagger_root_rad, stagger_tip_rad;
    double le_radius_mm, te_radius_mm;
    double lean_x_rad, lean_y_rad;
    double z_root_mm, z_tip_mm;
};

struct NominalSpec {
    NominalKind kind = NominalKind::none;
    std::vector<std::string> files;  ///< resolved against the part file, patterns expanded, sorted
    Span span = Span::automatic;
    std::optional<Eigen::Vector2d> le_hint_mm;
    std::optional<ParametricBlade> blade;
    std::vector<std::string> skip = {};  ///< words of a nominal file (.NOM) to go on without
    std::string solid;                   ///< of a STEP file: its name or number; empty: the only one
};

struct StylusSpec {
    double radius_mm = 1.0, shank_radius_mm = 0.6, length_mm = 20.0;
    bool radius_given = false;  ///< by the file
};

struct ScanSpec {
    std::vector<double> heights_mm;  ///< ascending
    double pitch_mm = 0.4, edge_density = 4.0, max_speed_mm_s = 10.0;
    double clearance_mm = 5.0, approach_mm = 1.0, search_mm = 1.5;
    double wait_s = 300.0;                      ///< at rest, for what may pass by itself; 0: the run ends at once
    bool stop_when_rejected = false;            ///< the run ends as soon as the part's verdict is certain to be reject
    std::optional<UntilDecided> until_decided;  ///< undecided sections are measured again
    std::optional<Eigen::Vector2d> start_mm, toward_mm;
    std::optional<std::array<double, 4>> box_mm;  ///< x0 y0 x1 y1
};

struct GateSpec {
    std::optional<double> profile_mm, edge_profile_mm;  ///< full width of the zone; absent: reported, not judged
    std::vector<CharacteristicSpec> characteristics;    ///< asked for by [[characteristic]]
    DecisionRule rule;
};

/// A tolerance file of PC-DMIS Blade; what it asks for stands with the characteristics of the gate.
struct ToleranceSpec {
    std::string file;               ///< empty: none
    std::vector<std::string> skip;  ///< keywords to go on without
};

using fitting::CompensationMethod;

/// How the sections are fitted and their deviations filtered; by default nothing is asked for.
struct FittingSpec {
    std::optional<fitting::EdgeModel> le_model, te_model;  ///< absent: the points choose
    CompensationMethod compensation = CompensationMethod::surface;
    double fairing_mm = 0.0;       ///< how far fairing may move the contour; 0: none
    fitting::ZoneFilters filters;  ///< of the deviations that the profiles judge
};

/// A part file as the host sees it ([actual] is the simulator's). A value.
struct PartFile {
    std::string path;  ///< of the file itself
    std::string text;  ///< its content, kept in the run file
    std::string name, serial;
    NominalSpec nominal;
    StylusSpec stylus;
    ScanSpec scan;
    FittingSpec fitting;
    AlignmentSpec alignment;
    GateSpec gate;
    ToleranceSpec tolerance;
    UncertaintySpec uncertainty;
};

/// Errors: input_missing, config_syntax, config_invalid (file:line:column, did you mean); of the nominal file and the
/// tolerance file of PC-DMIS Blade, which are read here: input_missing, input_invalid.
core::Result<PartFile> load_part_file(const std::string& path);
/// The same of a part that is to be measured: the sections that its characteristics name have to be among its heights.
/// (Points from files have sections of their own.)
core::Result<PartFile> load_part_to_measure(const std::string& path);
core::Result<PartFile> parse_part_file(std::string_view text, const std::string& path);
/// The same of a text that is parsed already: its tables, key by key. Errors: config_invalid, and of the files above.
core::Result<PartFile> read_part_file(const core::ConfigTable& root);

/// The [gate] table and the [[characteristic]] list alone, of a part file or of a file of its own (`cmmlive gate`).
/// Errors as above.
core::Result<GateSpec> load_gate_file(const std::string& path);

}  // namespace cmm::acquisition
