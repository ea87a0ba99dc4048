// SPDX-License-Identifier: Apache-2.0
#include "acquisition/alignment.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/text.hpp"
#include "core/units.hpp"

namespace cmm::acquisition {
namespace {

using core::ConfigTable;
using fitting::FitObjective;

const char* objective_words(FitObjective objective) {
    switch (objective) {
        case FitObjective::least_squares:
            return "least squares by arc length";
        case FitObjective::min_max:
            return "smallest largest deviation";
        case FitObjective::into_tolerance:
            return "into the tolerance zones";
    }
    return "";
}

}  // namespace

std::string_view to_string(AlignmentKind kind) noexcept {
    switch (kind) {
        case AlignmentKind::none:
            return "none";
        case AlignmentKind::six_points:
            return "six_points";
        case AlignmentKind::section:
            return "section";
        case AlignmentKind::blade:
            return "blade";
    }
    return "none";
}

std::string_view to_string(Alignment::State state) noexcept {
    switch (state) {
        case Alignment::State::none:
            return "none";
        case Alignment::State::provisional:
            return "provisional";
        case Alignment::State::final:
            return "final";
        case Alignment::State::refused:
            return "refused";
    }
    return "none";
}

double Alignment::standard(Eigen::Index number) const {
    return std::sqrt(std::max(0.0, covariance(number, number) + loads.row(number).squaredNorm()));
}

AlignmentSpec read_alignment(const ConfigTable& table, bool has_nominal, bool sides, bool edges) {
    AlignmentSpec spec;
    const std::string kind = table.word("kind", "none", {"none", "six_points", "rps", "section", "blade"});
    const std::string objective =
        table.word("objective", "least_squares", {"least_squares", "min_max", "into_tolerance"});
    const std::string translation = table.word("translation", "xy", {"xy", "x", "y", "none"});
    spec.rotate = table.word("rotation", "free", {"free", "fixed"}) == "free";
    spec.kind = kind == "section"                       ? AlignmentKind::section
                : kind == "blade"                       ? AlignmentKind::blade
                : kind == "six_points" || kind == "rps" ? AlignmentKind::six_points
                                                        : AlignmentKind::none;
    spec.objective = objective == "min_max"          ? FitObjective::min_max
                     : objective == "into_tolerance" ? FitObjective::into_tolerance
                                                     : FitObjective::least_squares;
    spec.translate_x = translation == "xy" || translation == "x";
    spec.translate_y = translation == "xy" || translation == "y";
    spec.zones = read_zone_set(table, "zones");
    spec.six_points = read_six_points(table, spec.kind == AlignmentKind::six_points);
    const bool best_fit = spec.kind == AlignmentKind::section || spec.kind == AlignmentKind::blade;
    if (spec.six_points && spec.kind == AlignmentKind::none)
        table.complain("point", "needs kind = \"six_points\", or a best fit after them: \"section\" or \"blade\"");
    if (spec.six_points && best_fit && !(spec.translate_x && spec.translate_y && spec.rotate))
        table.complain("kind", "\"" + kind + "\" after six points moves freely: leave translation and rotation out");
    if (!best_fit) {
        if (spec.kind == AlignmentKind::six_points && !has_nominal)
            table.complain("kind", "\"" + kind + "\" needs a nominal: there is nothing to align to");
        for (const char* key : {"objective", "translation", "rotation", "zones"})
            if (table.has(key)) table.complain(key, "needs kind = \"section\" or \"blade\"");
        return spec;
    }
    if (!has_nominal) table.complain("kind", "\"" + kind + "\" needs a nominal: there is nothing to align to");
    if (!spec.translate_x && !spec.translate_y && !spec.rotate)
        table.complain("rotation", "is fixed, and so is the translation: nothing may move");
    if (spec.objective == FitObjective::into_tolerance) {
        const bool side_takes_part = spec.zones[1] || spec.zones[3], edge_takes_part = spec.zones[0] || spec.zones[2];
        if (side_takes_part && !sides)
            table.complain("objective", "\"into_tolerance\" needs gate.profile_mm, or zones without the sides");
        if (edge_takes_part && !edges)
            table.complain("objective", "\"into_tolerance\" needs gate.edge_profile_mm, or zones without the edges");
    }
    return spec;
}

std::string free_words(const AlignmentSpec& spec) {
    std::string out;
    if (spec.translate_x) out += "x ";
    if (spec.translate_y) out += "y ";
    if (spec.rotate) out += "rotation ";
    return out.substr(0, out.size() - 1);
}

std::string frame_words(const AlignmentSpec& spec) {
    if (spec.kind == AlignmentKind::none) return "nominal frame";
    if (spec.kind == AlignmentKind::six_points) return "frame of the six datum points (RPS)";
    const std::string words = zone_words(spec.zones), zones = words.empty() ? "" : "; of " + words;
    return std::string("after the best fit of the ") + std::string(to_string(spec.kind)) + " (" +
           objective_words(spec.objective) + "; free: " + free_words(spec) + zones +
           (spec.six_points ? "; from the frame of the six datum points)" : ")");
}

std::string alignment_words(const Alignment& alignment) {
    if (alignment.state == Alignment::State::none) return "none: the machine's part frame is that of the nominal";
    if (alignment.state == Alignment::State::refused) return "refused: " + alignment.note;
    const auto u = [&](Eigen::Index k) { return alignment.standard(k); };
    if (alignment.spec.kind == AlignmentKind::six_points) {
        return "six datum points (RPS); in the plane of the section u x " + core::fixed(u(0), 5) + " mm, y " +
               core::fixed(u(1), 5) + " mm, rotation " + core::fixed(core::deg_from_rad(u(2)), 6) + " deg";
    }
    const auto& motion = alignment.motion;
    std::string out = "x " + core::signed_fixed(motion.shift_mm.x(), 4) + " mm (u " + core::fixed(u(0), 5) + "), y " +
                      core::signed_fixed(motion.shift_mm.y(), 4) + " mm (u " + core::fixed(u(1), 5) + "), rotation " +
                      core::signed_fixed(core::deg_from_rad(motion.turn_rad), 5) + " deg (u " +
                      core::fixed(core::deg_from_rad(u(2)), 6) + ") about x " + core::fixed(motion.about_mm.x(), 3) +
                      ", y " + core::fixed(motion.about_mm.y(), 3) + "; " + core::length_text(alignment.rms_mm) +
                      " rms and " + core::length_text(alignment.largest_mm) + " at most are left; condition " +
                      core::fixed(alignment.condition, 1) + ", " + std::to_string(alignment.rounds) + " rounds";
    if (alignment.state == Alignment::State::provisional) out = "provisional: " + out;
    if (!alignment.note.empty()) out += "; " + alignment.note;
    return out;
}

}  // namespace cmm::acquisition
