// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "acquisition/alignment.hpp"
#include "acquisition/place_limits.hpp"
#include "acquisition/uncertainty_spec.hpp"
#include "acquisition/unit.hpp"
#include "acquisition/zone_set.hpp"
#include "core/error.hpp"
#include "fitting/compensation_method.hpp"
#include "fitting/section.hpp"
#include "fitting/six_points.hpp"

namespace cmm::acquisition {

class NominalSurface;

/// For people: "section 3 (z 45.000 mm)"; sections count from 0.
std::string section_text(std::size_t index, double z_mm);

/// ISO 14253-1: three states; `reported` carries no requirement, `not_evaluable` says why in `note`.
enum class Decision : std::uint8_t { accept, reject, undecided, reported, not_evaluable };
std::string_view to_string(Decision decision) noexcept;

/// A characteristic of one section: a number with its method, its uncertainty and what was decided about it.
/// Always there: profile_le, profile_suction, profile_te, profile_pressure (with a nominal), le_radius, te_radius,
/// chord, max_thickness; others by the part file (characteristic_spec.hpp).
struct Characteristic {
    std::string name;
    std::string method;  ///< e.g. "line profile ISO 1101, 2 max|d|, nominal frame"
    std::optional<double> value;
    std::optional<double> u95;    ///< expanded uncertainty
    std::optional<double> upper;  ///< largest value that conforms, where there is a requirement
    Decision decision = Decision::reported;
    std::string note;
    Unit unit = Unit::mm;
    std::optional<double> nominal = {};  ///< none: not said, or there is none (profiles)
    std::optional<double> lower = {};    ///< smallest value that conforms
    bool partly = false;                 ///< of a part of its zone: the rest was not measured
    bool required = false;  ///< a tolerance was asked for, also where its limits are not known for want of a nominal
    /// What the decision rule keeps between value and limit to accept, and to reject (decision_rule.hpp).
    std::optional<double> guard_accept = {}, guard_reject = {};
    /// Of u95, by where it comes from; where anything is known of machine, probe or temperature.
    std::optional<fitting::ErrorBudget> budget = {};

    bool has_limits() const { return upper || lower; }
    bool has_requirement() const { return required || has_limits(); }
};
/// A number of a characteristic that is a length; none of one that is not.
inline std::optional<double> in_mm(const Characteristic& c, std::optional<double> number) {
    return c.unit == Unit::mm ? number : std::nullopt;
}

/// One recorded point with what became of it: raw points are kept for ever.
struct RecordedPoint {
    std::uint64_t sequence = 0;
    Eigen::Vector3d centre_mm = Eigen::Vector3d::Zero();  ///< part frame
    std::uint16_t flags = 0;
    fitting::PointVerdict verdict;
    std::uint8_t pass = 0;  ///< 0: of the lap; k: of the kth pass that measured stretches of it again
};

/// How the ball was taken off a section's contour.
struct Compensation {
    enum class State : std::uint8_t {
        flat,         ///< in the section's plane, for good
        provisional,  ///< until the section above has closed: in its plane, or by a lean that was not measured
        final,        ///< by the method that was asked for
    };
    State state = State::flat;
    std::string note;           ///< flat: why
    double share = 0.0;         ///< of the section that the method compensates; elsewhere the 2-D offset stands
    double from_flat_mm = 0.0;  ///< largest distance from the 2-D contour
    double change_mm = 0.0;     ///< largest distance from the contour that was told before this one, whichever it was
    fitting::CompensationMethod asked = fitting::CompensationMethod::surface;
    std::size_t set_aside = 0;  ///< final, point by point: contacts out of order or off their neighbours

    /// By which the contour as it is now was made, or will be.
    fitting::CompensationMethod method() const {
        return state == State::flat ? fitting::CompensationMethod::flat : asked;
    }
};
/// "2d", "provisional", "final".
std::string_view to_string(Compensation::State state) noexcept;

/// Where a section lies to its nominal by its best fit (least squares), in the frame of the blade's alignment if there
/// is one; standard covariance of shift x, shift y (mm) and turn (rad) by the section's own points.
struct SectionPlacement {
    Eigen::Vector2d shift_mm = Eigen::Vector2d::Zero();
    double turn_rad = 0.0;
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
    Eigen::Matrix3d places = Eigen::Matrix3d::Zero();           ///< part of it: by what the machine does place by place
    fitting::MotionLoads loads = fitting::MotionLoads::Zero();  ///< by what all sections have in common
    ZoneSet zones = all_zones;                                  ///< that took part
};
/// The deviation at one place of the nominal, for a line along the span.
struct SpanPoint {
    std::string label;
    double deviation_mm = 0.0, scatter_mm = 0.0;  ///< standard, by the section's own points
    double place_mm = 0.0;                        ///< standard, by what the machine does at this place alone
    fitting::FieldLoads loads = fitting::FieldLoads::Zero();  ///< by what all sections have in common
};

/// A stretch of a contour that was not measured: the contour's points before and behind it, and how long it is.
struct ContourGap {
    std::size_t before = 0, behind = 0;
    double length_mm = 0.0;
};

/// A finished section. `fit` is absent where the points do not determine a section; `why` says it.
struct SectionResult {
    std::size_t index = 0;  ///< 0-based, order of measurement
    std::string name;
    double z_mm = 0.0;
    std::vector<RecordedPoint> points;
    std::optional<fitting::SectionFit> fit;
    std::string why;  ///< not evaluable because ...
    /// Signed distance along the normal of the nominal, after the alignment, one per fit->contour point, none where the
    /// ball does not reach the nominal, and in gaps of the points; empty without a nominal, and where the alignment was
    /// refused.
    std::vector<std::optional<double>> deviation_mm;
    /// That the nominal has at its points, one per fit->contour point; empty where it has none.
    std::vector<PointTolerance> tolerances;
    std::shared_ptr<const NominalSurface> nominal_surface;  ///< where the nominal is one (only STEP is)
    /// For the pictures: the nominal laid onto the measured section; empty without a nominal.
    std::vector<Eigen::Vector2d> nominal_contour;
    Alignment alignment;
    std::vector<SectionPlacement> placements;  ///< where characteristics of the part ask for them
    std::vector<SpanPoint> span_points;        ///< likewise
    std::vector<Characteristic> characteristics;
    Compensation compensation;

    /// Whether it has a contour. Places of it may be unmeasured.
    bool has_contour() const { return fit && !fit->contour.empty(); }
    /// Whether it was measured all round, but for gaps on its sides.
    bool all_round() const { return has_contour() && fit->missing.empty(); }
    /// Why it was not; empty when it was.
    std::string why_not_all_round() const;
    /// The nose of LE or TE; none where it was not measured.
    std::optional<Eigen::Vector2d> nose_mm(fitting::Zone edge) const;
    std::size_t rejected() const;
    /// Contour points without a deviation because the ball does not reach there.
    std::size_t not_reached() const;
    /// Stretches of the contour that were not measured, in its order; one may run over its first point.
    std::vector<ContourGap> gaps() const;
    /// Length of all gaps.
    double missing_mm() const;
    /// U95 of the deviation at a contour point, with that of the alignment.
    double deviation_u95_mm(std::size_t point) const;
    const Characteristic* find(std::string_view characteristic_name) const;
    /// By the best fit of these zones; nullptr: there is none.
    const SectionPlacement* placement(const ZoneSet& zones) const;
    /// Worst decision of its requirements: reject, undecided, accept; `reported` when it has none and misses
    /// little.
    Decision decision() const;
};

/// Half the 95 % interval of a deviation at a contour point by the scatter of the points, with that of the alignment
/// (k = 2); and with what machine, probe and temperature add.
double scatter_u95_mm(const fitting::ContourPoint& point, const Alignment& alignment);
double aligned_u95_mm(const fitting::ContourPoint& point, const Alignment& alignment);

/// Of a contour that is not empty.
const fitting::ContourPoint& nearest_to(const std::vector<fitting::ContourPoint>& contour,
                                        const Eigen::Vector2d& point_mm);

/// Whether at most a twentieth of the section lies in gaps.
bool misses_little(const fitting::SectionFit& fit);

/// A characteristic that needs several sections.
struct PartCharacteristic {
    Characteristic number;
    std::optional<std::size_t> section;  ///< of which it says something; none: of the part
};
/// "bow_x of section 2", "lean_x".
std::string name_of(const PartCharacteristic& c);

/// A file that a result rests on (traceability.hpp).
struct SourceFile {
    std::string what, name, sha256;  ///< "Part file", without its folder, empty: not known
};

/// A whole part with all that the files and the report say about it. A value.
struct PartResult {
    std::string part_name, part_serial, started_utc, machine, run_id;
    std::string software_version;     ///< "cmmlive 0.1.0"
    std::vector<SourceFile> sources;  ///< part file, nominal, tolerances (traceability.hpp)
    std::string plan_hash;            ///< of the run's plan; empty: not of a run
    double ball_radius_mm = 0.0;
    bool has_nominal = false;
    std::optional<fitting::SixPointFrame> part_frame;  ///< where the part stands on the machine, by six points
    std::string decision_rule;                         ///< in a sentence
    UncertaintySpec uncertainty;                       ///< what was known of machine, probe and temperature
    bool complete = true;  ///< false: the scan ended early; then the verdict cannot be accept
    std::vector<SectionResult> sections;
    std::vector<PartCharacteristic> characteristics;  ///< that need several sections

    /// reject before undecided before accept. A part without requirements is accepted when all of it was measured:
    /// "done".
    Decision verdict() const;
    /// What was asked for, by a section that has it; nullptr: no alignment.
    const Alignment* alignment() const;
    /// Whether any characteristic carries a requirement.
    bool has_requirements() const;
};

/// The contour, its bridges too; empty: none.
std::vector<Eigen::Vector2d> contour_positions(const SectionResult& section);

/// Points of each pass that measured stretches of the section again, by its number.
std::map<int, std::size_t> points_of_passes(const SectionResult& section);

/// Why the verdict is not accept, one line for each bad section, the rejected ones first: "section 3 (z 40.0):
/// profile_pressure 0.212 mm +- 0.004 mm > 0.100 mm; also profile_le 0.131 mm".
std::vector<std::string> verdict_reasons(const PartResult& part);

}  // namespace cmm::acquisition
