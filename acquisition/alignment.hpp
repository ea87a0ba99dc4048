// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "acquisition/six_point_spec.hpp"
#include "acquisition/zone_set.hpp"
#include "core/config.hpp"
#include "fitting/best_fit.hpp"
#include "fitting/error_fields.hpp"
#include "fitting/plane_motion.hpp"

namespace cmm::acquisition {

/// By what the measured part is laid onto its nominal before deviations are taken (docs/adr/0017).
enum class AlignmentKind : std::uint8_t {
    none,        ///< the machine's part frame is the nominal's
    six_points,  ///< six datum points, touched before the first section, make the part frame; no fit after them
    section,     ///< each section by its own best fit: form without location
    blade,       ///< all sections by one rigid motion in x, y and about z: location within the blade counts
};
std::string_view to_string(AlignmentKind kind) noexcept;

/// The [alignment] of a part file.
struct AlignmentSpec {
    AlignmentKind kind = AlignmentKind::none;
    fitting::FitObjective objective = fitting::FitObjective::least_squares;
    bool translate_x = true, translate_y = true, rotate = true;  ///< false: held as measured
    ZoneSet zones = all_zones;                                   ///< that take part
    std::optional<SixPointSpec> six_points;                      ///< also before a best fit: where the part stands
};

/// `has_nominal`: without one there is nothing to align to. Complains of that, of what contradicts itself, and of zones
/// to fit into that have no width (`sides`, `edges`: whether the gate gives them one).
AlignmentSpec read_alignment(const core::ConfigTable& table, bool has_nominal, bool sides, bool edges);

/// How a section was aligned: what stands in the files and the report.
struct Alignment {
    enum class State : std::uint8_t {
        none,         ///< not asked for
        provisional,  ///< of the blade: sections are still missing
        final,
        refused,  ///< not possible: `note` says why, and nothing is judged against the nominal
    };
    State state = State::none;
    AlignmentSpec spec;
    fitting::PlaneMotion motion;                                ///< from the nominal to where the part was measured
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();       ///< standard, of shift x, shift y (mm) and turn (rad)
    fitting::MotionLoads loads = fitting::MotionLoads::Zero();  ///< beside it: by what all sections have in common
    double rms_mm = 0.0, largest_mm = 0.0;  ///< of the deviations that are left, from the zones' middles
    double condition = 1.0;                 ///< of the free numbers
    int rounds = 0;                         ///< of the iteration
    std::size_t sections = 0;               ///< that the fit holds
    std::string note;

    /// Whether deviations are of the aligned section.
    bool done() const { return state == State::provisional || state == State::final; }
    /// Standard uncertainty of shift x, shift y (mm) and turn (rad), all together.
    double standard(Eigen::Index number) const;
};
/// "none", "provisional", "final", "refused".
std::string_view to_string(Alignment::State state) noexcept;

/// "after the best fit of the blade (least squares, x y rotation)"; "nominal frame" without alignment.
std::string frame_words(const AlignmentSpec& spec);
/// For people, in one line: "x +0.0123 mm (u 0.0004), y ..., rotation ... deg (u ...); rms ..., condition ..., ...
/// rounds".
std::string alignment_words(const Alignment& alignment);
/// The free ones of "x", "y" and "rotation", with blanks between.
std::string free_words(const AlignmentSpec& spec);

}  // namespace cmm::acquisition
