// SPDX-License-Identifier: Apache-2.0
#include "support/characteristic_coverage.hpp"

#include <cmath>
#include <functional>
#include <memory>
#include <numbers>
#include <optional>

#include "fitting/area_measures.hpp"
#include "fitting/best_fit.hpp"
#include "fitting/chord.hpp"
#include "fitting/compensation.hpp"
#include "fitting/datum.hpp"
#include "fitting/radius_uncertainty.hpp"
#include "fitting/surface_section.hpp"
#include "fitting/thickness_measures.hpp"
#include "fitting/throat.hpp"
#include "support/drawn_errors.hpp"
#include "support/formed_nominal.hpp"
#include "support/section_truth.hpp"
#include "support/twisted_blade.hpp"

namespace cmm::fitting::coverage {
namespace {

/// Of the three numbers of a motion; what is known counts as if it were a standard uncertainty.
Eigen::Matrix3d covariance_of(const MotionLoads& loads) {
    return loads * loads.transpose();
}

void count(Tally& tally, double error, double standard, double u95) {
    ++tally.trials;
    tally.held += std::abs(error) <= u95;
    tally.error += error;
    tally.u += standard;
    tally.error_squares += error * error;
    tally.u_squares += standard * standard;
    if (standard > 0.0) tally.squares += std::pow(error / standard, 2);
}

/// What is true of one blade.
struct Truth {
    double nose_tail, caliper, caliper_angle, belac, axial, largest, min_circle, stagger, thickness, on_chord,
        on_camber;
    double le_thickness, te_thickness, le_angle, te_angle, area;
    double distance_mm, near_mm, far_mm;
    section_truth::Vec2 centroid, pitch;
    double throat;
};

constexpr double belac_rad = 0.7;
constexpr double section_step_mm = 40.0;  // from one section of a blade to the next
constexpr std::size_t compensated_sections = 25, judged_step = 6;
constexpr double beyond_sections_mm = 2.0;
constexpr double form_mm = 5e-3;  // of blades against their nominals, where it matters

Truth truth_of(const families::Blade& blade) {
    const section_truth::SectionTruth t(section_truth::of_family(blade));
    Truth out{};
    const double chord = (t.tail() - t.nose()).norm();
    const auto caliper = t.caliper();
    const auto thickest = t.thickest();
    out.nose_tail = chord;
    out.caliper = caliper.length;
    out.caliper_angle = caliper.angle;
    out.belac = t.extent({std::cos(belac_rad), std::sin(belac_rad)});
    out.axial = t.extent({1.0, 0.0});
    out.largest = t.largest_distance();
    out.min_circle = t.min_circle();
    out.stagger = t.stagger();
    out.thickness = thickest.diameter;
    out.on_chord = thickest.on_chord;
    out.on_camber = thickest.on_camber;
    out.distance_mm = std::max(0.06 * chord, 2.5 * std::max(t.scale(true), t.scale(false)));
    out.near_mm = 0.6 * out.distance_mm;
    out.far_mm = 2.0 * out.distance_mm;
    out.le_thickness = t.edge_thickness(true, out.distance_mm);
    out.te_thickness = t.edge_thickness(false, out.distance_mm);
    out.le_angle = t.edge_angle(true, out.near_mm, out.far_mm);
    out.te_angle = t.edge_angle(false, out.near_mm, out.far_mm);
    out.area = t.area();
    out.centroid = t.centroid();
    out.pitch = section_truth::Vec2(0.0, 0.9 * chord);
    out.throat = 1e9;
    double at = 0.0;
    const auto look = [&](double place) {
        const double distance = t.distance(t.section().at(std::fmod(place + 4.0, 4.0)).position + out.pitch);
        if (distance < out.throat) {
            out.throat = distance;
            at = place;
        }
    };
    for (int k = 0; k < 200; ++k)
        look(0.02 * k);
    for (double step = 0.01; step > 1e-8; step *= 0.5) {
        const double from = at;
        look(from - step);
        look(from + step);
    }
    return out;
}

class Judge {
  public:
    Judge(MeasuredSection& section, Tallies& tallies) : section_(section), tallies_(tallies) {}

    void operator()(const std::string& name, const core::Result<Measure>& measure, double truth, bool angle = false) {
        Tally& tally = tallies_[name];
        if (!measure) {
            ++tally.refused;
            return;
        }
        const NumberUncertainty u = section_.uncertainty(*measure);
        const double error = measure->value - truth;
        count(tally, angle ? std::remainder(error, 2.0 * std::numbers::pi) : error, u.standard, u.u95);
    }

  private:
    MeasuredSection& section_;
    Tallies& tallies_;
};

/// `itself` for all but min-max motions: these rest on single places, and which ones a form decides that no noise
/// hides.
struct Nominals {
    ClosedCurve itself;
    formed::Nominal formed;

    Nominals(const families::Blade& blade, std::uint64_t seed)
        : itself(formed::itself(blade)), formed(formed::of_other_form(blade, form_mm, seed)) {}
};

void judge_min_max(const MeasuredSection& section, const ClosedCurve& nominal, const PlaneMotion& truth,
                   const std::string& of, Tallies& tallies) {
    BestFitOptions min_max;
    min_max.objective = FitObjective::min_max;
    const auto moved = fit_to_nominal(section.contour(), nominal, min_max);
    if (!moved) {
        ++tallies["min-max rotation" + of].refused;
        return;
    }
    const MeasuredSection* const only = &section;
    const Datum datum = datums_of(*moved, {&only, 1}).front();
    const Eigen::Matrix3d covariance = datum.covariance + covariance_of(datum.loads);
    const auto one = [&](const std::string& name, double error, Eigen::Index k) {
        const double standard = std::sqrt(covariance(k, k));
        count(tallies[name + of], error, standard, 2.0 * standard);
    };
    const Vec2 shift = moved->motion.shift_mm - truth.shift_mm;
    one("min-max shift x", shift.x(), 0);
    one("min-max shift y", shift.y(), 1);
    one("min-max rotation", moved->motion.turn_rad - truth.turn_rad, 2);
}

void judge(const families::Blade& blade, const Nominals& nominals, const Truth& truth, const SectionFit& fit,
           Tallies& tallies) {
    MeasuredSection section(fit);
    Judge say(section, tallies);
    if (const auto moved = fit_to_nominal(section.contour(), nominals.itself)) {
        say("displacement x", moved->dx, 0.0);
        say("displacement y", moved->dy, 0.0);
        say("twist", moved->twist, 0.0, true);
    } else {
        ++tallies["twist"].refused;
    }
    judge_min_max(section, nominals.formed.curve, nominals.formed.min_max, "", tallies);
    judge_min_max(section, nominals.itself, {}, " without form", tallies);
    say("chord NOSETAIL", measure_chord(section, ChordMethod::nose_tail), truth.nose_tail);
    say("chord CALIPER", measure_chord(section, ChordMethod::caliper), truth.caliper);
    say("chord BELAC", measure_chord(section, ChordMethod::belac, belac_rad), truth.belac);
    say("chord XAXIS", measure_chord(section, ChordMethod::x_axis), truth.axial);
    say("chord MINCIRCLE", measure_chord(section, ChordMethod::min_circle), truth.min_circle);
    say("chord MAXDIST", measure_chord(section, ChordMethod::largest), truth.largest);
    if (fit.le.model == EdgeModel::arc && fit.te.model == EdgeModel::arc && blade.le().along == blade.le().across &&
        blade.te().along == blade.te().across)
        say("chord RADCENTER", measure_chord(section, ChordMethod::rad_center),
            (blade.te().centre - blade.le().centre).norm() + blade.le().across + blade.te().across);
    say("stagger NOSETAIL", measure_stagger(section, StaggerMethod::nose_tail), truth.stagger, true);
    say("stagger CALIPER", measure_stagger(section, StaggerMethod::caliper), truth.caliper_angle, true);
    say("max_thickness", measure_max_thickness(section), truth.thickness);
    say("its place on the chord", measure_max_thickness_position(section, PositionMethod::on_chord), truth.on_chord);
    say("its place on the camber line", measure_max_thickness_position(section, PositionMethod::on_camber),
        truth.on_camber);
    say("LE thickness", measure_edge_thickness(section, EdgeName::le, truth.distance_mm), truth.le_thickness);
    say("TE thickness", measure_edge_thickness(section, EdgeName::te, truth.distance_mm), truth.te_thickness);
    say("LE angle", measure_edge_angle(section, EdgeName::le, truth.near_mm, truth.far_mm, AngleReference::x_axis),
        truth.le_angle, true);
    say("TE angle", measure_edge_angle(section, EdgeName::te, truth.near_mm, truth.far_mm, AngleReference::x_axis),
        truth.te_angle, true);
    say("throat", measure_throat(section, truth.pitch), truth.throat);
    const AreaMeasures area = measure_area(section);
    say("area", area.area, truth.area);
    say("centroid x", area.centroid_x, truth.centroid.x());
    say("centroid y", area.centroid_y, truth.centroid.y());
    // Of edges that were taken for what they are; an ellipse that the noise lets pass for an arc has another radius.
    const auto radius = [&](const std::string& name, const EdgeFit& edge, const families::End& end) {
        const EdgeModel form = end.along == end.across ? EdgeModel::arc : EdgeModel::ellipse;
        Tally& tally = tallies[name];
        if (!edge.valid || edge.model != form) {
            ++tally.refused;
            return;
        }
        const double u95 = radius_uncertainty(fit, &edge == &fit.le ? Zone::le : Zone::te).u95;
        count(tally, edge.radius_mm - end.nose_radius(), u95 / 2.0, u95);
    };
    radius("LE radius", fit.le, blade.le());
    radius("TE radius", fit.te, blade.te());
}

/// Of two sections, each by its own best fit: what they have in common goes together.
void judge_lean(const ClosedCurve& nominal, const MeasuredSection& root, const MeasuredSection& tip, Tallies& tallies) {
    const auto low = fit_to_nominal(root.contour(), nominal), high = fit_to_nominal(tip.contour(), nominal);
    if (!low || !high) return;
    const MeasuredSection *const first = &root, *const last = &tip;
    const Datum from = datums_of(*low, {&first, 1}).front(), to = datums_of(*high, {&last, 1}).front();
    const Eigen::Matrix3d covariance = from.covariance + to.covariance + covariance_of(to.loads - from.loads);
    const auto one = [&](const std::string& name, double value, Eigen::Index k) {
        const double standard = std::sqrt(covariance(k, k));
        count(tallies[name], value, standard, 2.0 * standard);
    };
    one("lean x", high->motion.shift_mm.x() - low->motion.shift_mm.x(), 0);
    one("lean y", high->motion.shift_mm.y() - low->motion.shift_mm.y(), 1);
    one("relative twist", high->motion.turn_rad - low->motion.turn_rad, 2);
}

/// Three sections like each other as one blade, which lies where its nominal does: its alignment, and the place of one
/// section in the aligned blade.
void judge_blade(const ClosedCurve& nominal, const std::vector<SectionFit>& fits, Tallies& tallies) {
    std::vector<std::unique_ptr<MeasuredSection>> sections;
    std::vector<const MeasuredSection*> measured;
    std::vector<FitMember> members;
    for (const auto& fit : fits) {
        sections.push_back(std::make_unique<MeasuredSection>(fit));
        measured.push_back(sections.back().get());
        members.push_back({&sections.back()->contour(), &nominal, {}});
    }
    judge_lean(nominal, *sections.front(), *sections.back(), tallies);
    const auto found = fit_to_nominals(members);
    if (!found) {
        ++tallies["blade rotation"].refused;
        return;
    }
    const auto datums = datums_of(*found, measured);
    const Eigen::Matrix3d covariance = datums[0].covariance + covariance_of(datums[0].loads);
    const auto standard = [&](Eigen::Index k) { return std::sqrt(covariance(k, k)); };
    const auto& motion = found->motion;
    count(tallies["blade shift x"], motion.shift_mm.x(), standard(0), 2.0 * standard(0));
    count(tallies["blade shift y"], motion.shift_mm.y(), standard(1), 2.0 * standard(1));
    count(tallies["blade rotation"], motion.turn_rad, standard(2), 2.0 * standard(2));
    const SectionFit aligned = undone(fits[0], motion);
    MeasuredSection first(aligned);
    const auto placed = fit_to_nominal(first.contour(), nominal);
    if (!placed) return;
    for (const auto& [name, measure] : {std::pair("displacement x in the aligned blade", &placed->dx),
                                        std::pair("twist in the aligned blade", &placed->twist)}) {
        const auto u = first.uncertainty(datums[0].of_aligned(*measure, first.contour()));
        count(tallies[name], measure->value, u.standard, u.u95);
    }
}

void judge_compensated(const families::TwistedBlade& blade, std::uint64_t seed, const families::ScanOptions& scanning,
                       Compensated& out) {
    const auto scanned = families::scan_rows(blade, compensated_sections, beyond_sections_mm,
                                             blade.height() - beyond_sections_mm, scanning);
    SectionOptions options;
    options.ball_radius_mm = scanning.ball_mm;
    const auto hint = [&](const families::Blade& outline) {
        options.le_hint = outline.le().nose;
        options.te_hint = outline.te().nose;
    };
    SurfaceCompensation surface(scanning.ball_mm);
    std::vector<std::optional<SectionFit>> flat(scanned.rows.size());
    for (std::size_t k = 0; k < flat.size(); ++k) {
        std::vector<section_truth::Vec2> centres;
        for (const auto& centre : scanned.rows[k])
            centres.push_back(centre.head<2>());
        hint(blade.outline(scanned.heights[k]));
        auto fit = fit_section(centres, {}, options);
        if (!fit || !surface.add(fit->centres.curve, scanned.heights[k], options.le_hint, options.te_hint)) continue;
        flat[k] = std::move(*fit);
    }
    const bool fitted = surface.fit().has_value();
    for (std::size_t k = 0; k < flat.size(); k += judged_step) {
        Tallies& tallies = k == 0 || k + 1 == flat.size() ? out.ends : out.between;
        const families::Blade outline = blade.outline(scanned.heights[k]);
        hint(outline);
        const auto section = fitted && flat[k] ? compensate_section(surface, scanned.heights[k], *flat[k], options)
                                               : core::fail(core::ErrorCode::fit_not_evaluable, "no surface");
        if (section)
            judge(outline, Nominals(outline, seed), truth_of(outline), section->fit, tallies);
        else
            ++tallies["section"].refused;
    }
}

}  // namespace

std::vector<Tallies> run(const Task& task) {
    std::vector<Tallies> tallies(task.sigmas_mm.size());
    for (std::uint64_t seed = task.first_seed; seed < task.first_seed + task.blades; ++seed) {
        const families::Blade blade = families::make(task.family, seed);
        const Truth truth = truth_of(blade);
        const Nominals nominals(blade, seed);
        core::Rng machines = core::Rng::keyed(seed, 0xE0, static_cast<std::uint64_t>(task.family));
        for (std::size_t k = 0; k < task.sigmas_mm.size(); ++k) {
            families::ScanOptions scanning;
            scanning.points = task.points;
            scanning.sigma_mm = task.sigmas_mm[k];
            scanning.bad_share = task.bad_share;
            scanning.seed = 7919 * seed + k;
            SectionOptions options;
            options.ball_radius_mm = scanning.ball_mm;
            options.le_hint = blade.le().nose;
            options.te_hint = blade.te().nose;
            auto machine = drawn_errors::draw(task.errors, machines);
            const auto measured_at = [&](double z_mm) -> core::Result<SectionFit> {
                auto scan = families::scan(blade, scanning);
                drawn_errors::displace(blade, machine, scan, z_mm);
                auto fit = fit_section(scan.points, {}, options);
                if (fit) fit->contour_noise.set_fields(ErrorFields(task.errors, z_mm));
                return fit;
            };
            const auto fit = measured_at(0.0);
            if (!fit) {
                ++tallies[k]["section"].refused;
                continue;
            }
            judge(blade, nominals, truth, *fit, tallies[k]);
            std::vector<SectionFit> sections{*fit};
            for (std::uint64_t other = 1; other < task.sections; ++other) {
                scanning.seed += 1000003;
                drawn_errors::draw_waves(task.errors, machines, machine);
                if (auto beside = measured_at(section_step_mm * static_cast<double>(other)))
                    sections.push_back(std::move(*beside));
            }
            if (sections.size() > 1) judge_blade(nominals.itself, sections, tallies[k]);
        }
    }
    return tallies;
}

std::vector<Compensated> run_compensated(const Task& task) {
    std::vector<Compensated> tallies(task.sigmas_mm.size());
    for (std::uint64_t seed = task.first_seed; seed < task.first_seed + task.blades; ++seed) {
        const families::TwistedBlade blade(task.family, seed);
        for (std::size_t k = 0; k < task.sigmas_mm.size(); ++k) {
            families::ScanOptions scanning;
            scanning.sigma_mm = task.sigmas_mm[k];
            scanning.bad_share = task.bad_share;
            scanning.seed = 7919 * seed + k;
            judge_compensated(blade, seed, scanning, tallies[k]);
        }
    }
    return tallies;
}

}  // namespace cmm::fitting::coverage
