// SPDX-License-Identifier: Apache-2.0
#include "acquisition/evaluation.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "core/text.hpp"
#include "core/units.hpp"
#include "fitting/closed_curve.hpp"

namespace cmm::acquisition {
namespace {

using Eigen::Vector2d;
using fitting::ContourPoint;
using fitting::Zone;

// A foot whose normal is more than 60 degrees away lies on another side of the blade.
constexpr double same_side_cosine = 0.5;
constexpr std::size_t stations_of_nominal = 2400;
constexpr std::size_t window_stations = 6;  // either way; a contour advances by about one from point to point
constexpr double undirected_mm = 1e-5;      // nearer than this the way to the foot says nothing about its normal

/// The nominal at equal steps of arc length: position and outward normal, to find the right side quickly.
class SideSafeDistance {
  public:
    explicit SideSafeDistance(fitting::ClosedCurve curve) : curve_(std::move(curve)) {
        stations_.reserve(stations_of_nominal);
        for (std::size_t i = 0; i < stations_of_nominal; ++i)
            stations_.push_back(curve_.evaluate(station_mm(i)));
    }

    /// Consecutive points of a contour are near each other: the last foot's surroundings are searched first.
    double signed_mm(const ContourPoint& point) {
        auto best = nearest(point, last_ + stations_.size() - window_stations, 2 * window_stations + 1);
        const auto ahead = (best + stations_.size() - last_) % stations_.size();
        const bool at_border = ahead == window_stations || ahead == stations_.size() - window_stations;
        if (!started_ || best == none || at_border) best = nearest(point, 0, stations_.size());
        if (best == none) return curve_.closest(point.position_mm).distance_mm;
        started_ = true;
        last_ = best;
        const auto foot = curve_.closest(point.position_mm, station_mm(best));
        if (normal_at(foot, point.position_mm).dot(point.normal) >= same_side_cosine) return foot.distance_mm;
        return (point.position_mm - stations_[best].position).dot(stations_[best].normal);
    }

  private:
    static constexpr std::size_t none = std::numeric_limits<std::size_t>::max();

    /// The way from the foot to the point is the normal already.
    Vector2d normal_at(const fitting::ClosestPoint& foot, const Vector2d& point) const {
        if (std::abs(foot.distance_mm) < undirected_mm) return curve_.evaluate(foot.s_mm).normal;
        return (point - foot.foot) / foot.distance_mm;
    }

    double station_mm(std::size_t i) const {
        return curve_.length() * static_cast<double>(i) / static_cast<double>(stations_of_nominal);
    }
    std::size_t nearest(const ContourPoint& point, std::size_t first, std::size_t count) const {
        std::size_t best = none;
        double best_squared = std::numeric_limits<double>::max();
        for (std::size_t k = 0; k < count; ++k) {
            const auto i = (first + k) % stations_.size();
            const double squared = (stations_[i].position - point.position_mm).squaredNorm();
            if (squared < best_squared && stations_[i].normal.dot(point.normal) >= same_side_cosine) {
                best = i;
                best_squared = squared;
            }
        }
        return best;
    }

    fitting::ClosedCurve curve_;
    std::vector<fitting::CurvePoint> stations_;
    std::size_t last_ = 0;
    bool started_ = false;
};

struct ProfileZone {
    Zone zone;
    const char* name;
    bool edge;
};
constexpr std::array profile_zones{
    ProfileZone{Zone::le, "profile_le", true}, ProfileZone{Zone::suction, "profile_suction", false},
    ProfileZone{Zone::te, "profile_te", true}, ProfileZone{Zone::pressure, "profile_pressure", false}};

constexpr const char* profile_method = "line profile ISO 1101, 2 max|d|, nominal frame";
constexpr const char* radius_method = "orthogonal-distance circle through the edge's points";
constexpr const char* chord_method = "NOSETAIL: distance of the nose points";
constexpr const char* thickness_method = "INSCRIBED: diameter of the largest inscribed circle";

double offset_error_mm(const EvaluationOptions& options) {
    return options.ball_radius_mm * (1.0 - std::cos(options.lean_rad));
}

Characteristic not_evaluable(const char* name, const char* method, std::optional<double> limit, std::string why) {
    return {name, method, {}, {}, limit, Decision::not_evaluable, std::move(why)};
}

Characteristic reported(const char* name, const char* method, double value, double u95, std::string note) {
    return {name, method, value, u95, {}, Decision::reported, std::move(note)};
}

std::string systematic_note(double error_mm) {
    return error_mm > 0.0 ? "U95 includes " + core::length_text(error_mm) + " of 2-D offset error" : std::string();
}

std::optional<double> limit_of(const ProfileZone& zone, const EvaluationOptions& options) {
    return zone.edge ? options.edge_profile_mm : options.profile_mm;
}

Characteristic profile(const ProfileZone& zone, const SectionResult& section, const EvaluationOptions& options) {
    const auto limit = limit_of(zone, options);
    const auto& contour = section.fit->contour;
    std::optional<std::size_t> worst;
    for (std::size_t i = 0; i < contour.size(); ++i) {
        if (contour[i].zone != zone.zone) continue;
        if (!worst || std::abs(section.deviation_mm[i]) > std::abs(section.deviation_mm[*worst])) worst = i;
    }
    if (!worst) return not_evaluable(zone.name, profile_method, limit, "the contour has no such zone");
    const double deviation = section.deviation_mm[*worst];
    const double error = offset_error_mm(options);
    Characteristic c{zone.name,
                     profile_method,
                     2.0 * std::abs(deviation),
                     2.0 * (contour[*worst].u95_mm + error),
                     limit,
                     Decision::reported,
                     {}};
    const auto& at = contour[*worst].position_mm;
    c.note = "worst d " + std::string(deviation > 0 ? "+" : "") + core::length_text(deviation) + " at x " +
             core::fixed(at.x(), 3) + " mm, y " + core::fixed(at.y(), 3) + " mm";
    if (const auto note = systematic_note(error); !note.empty()) c.note += "; " + note;
    if (limit) c.decision = decide(*c.value_mm, *c.u95_mm, *limit);
    return c;
}

Characteristic edge_radius(const char* name, const fitting::EdgeArc& arc, double error) {
    if (!arc.valid) return not_evaluable(name, radius_method, {}, arc.why.empty() ? "no circular edge" : arc.why);
    return reported(name, radius_method, arc.radius_mm, arc.radius_u95_mm + error,
                    "arc of " + core::fixed(core::deg_from_rad(arc.arc_angle_rad), 0) + " deg, rms " +
                        core::length_text(arc.rms_mm));
}

double u95_at(const std::vector<ContourPoint>& contour, const Vector2d& point) {
    const auto nearer = [&](const ContourPoint& a, const ContourPoint& b) {
        return (a.position_mm - point).squaredNorm() < (b.position_mm - point).squaredNorm();
    };
    return std::min_element(contour.begin(), contour.end(), nearer)->u95_mm;
}

double largest_side_u95(const std::vector<ContourPoint>& contour) {
    double largest = 0.0;
    for (const auto& point : contour) {
        if (point.zone == Zone::suction || point.zone == Zone::pressure) largest = std::max(largest, point.u95_mm);
    }
    return largest;
}

/// Sizes between two surfaces: both ends' uncertainties in quadrature, both ends' offset errors added.
void add_sizes(SectionResult& section, const EvaluationOptions& options) {
    const auto& fit = *section.fit;
    const double error = offset_error_mm(options);
    const auto note = systematic_note(2.0 * error);
    section.characteristics.push_back(edge_radius("le_radius", fit.le, error));
    section.characteristics.push_back(edge_radius("te_radius", fit.te, error));
    const double chord_u95 = std::hypot(u95_at(fit.contour, fit.le_point_mm), u95_at(fit.contour, fit.te_point_mm));
    section.characteristics.push_back(reported("chord", chord_method, fit.chord_mm, chord_u95 + 2.0 * error, note));
    const double thickness_u95 = std::sqrt(2.0) * largest_side_u95(fit.contour);
    section.characteristics.push_back(
        reported("max_thickness", thickness_method, fit.max_thickness_mm, thickness_u95 + 2.0 * error, note));
}

void add_nothing_evaluable(SectionResult& section, bool with_profiles, const EvaluationOptions& options) {
    auto& out = section.characteristics;
    if (with_profiles) {
        for (const auto& zone : profile_zones) {
            out.push_back(not_evaluable(zone.name, profile_method, limit_of(zone, options), section.why));
        }
    }
    out.push_back(not_evaluable("le_radius", radius_method, {}, section.why));
    out.push_back(not_evaluable("te_radius", radius_method, {}, section.why));
    out.push_back(not_evaluable("chord", chord_method, {}, section.why));
    out.push_back(not_evaluable("max_thickness", thickness_method, {}, section.why));
}

void take_fit(SectionResult& section, core::Result<fitting::SectionFit> fit) {
    if (!fit) {
        section.why = fit.error().text();
        return;
    }
    if (fit->verdicts.size() == section.points.size()) {
        for (std::size_t i = 0; i < section.points.size(); ++i)
            section.points[i].verdict = fit->verdicts[i];
    }
    section.fit = std::move(*fit);
    if (!section.closed()) section.why = "the section is not closed";
}

}  // namespace

double guard_band_mm(double u95_mm) {
    constexpr double one_sided_95 = 1.65;  // ISO 14253-1:2017, normal distribution
    constexpr double coverage = 2.0;
    return one_sided_95 / coverage * u95_mm;
}

Decision decide(double value_mm, double u95_mm, double limit_mm) {
    const double g = guard_band_mm(u95_mm);
    if (value_mm + g <= limit_mm) return Decision::accept;
    return value_mm - g > limit_mm ? Decision::reject : Decision::undecided;
}

core::Result<std::vector<double>> deviations_mm(std::span<const ContourPoint> contour,
                                                std::span<const Vector2d> nominal) {
    auto curve = fitting::ClosedCurve::through(nominal);
    if (!curve) return tl::unexpected(curve.error().with_context("nominal contour"));
    SideSafeDistance distance(std::move(*curve));
    std::vector<double> deviations;
    deviations.reserve(contour.size());
    for (const auto& point : contour)
        deviations.push_back(distance.signed_mm(point));
    return deviations;
}

SectionResult evaluate_section(SectionResult section, core::Result<fitting::SectionFit> fit,
                               std::span<const Vector2d> nominal, const EvaluationOptions& options) {
    section.nominal_contour.assign(nominal.begin(), nominal.end());
    section.characteristics.clear();
    take_fit(section, std::move(fit));
    if (section.closed() && !nominal.empty()) {
        auto deviations = deviations_mm(section.fit->contour, nominal);
        if (deviations) {
            section.deviation_mm = std::move(*deviations);
        } else {
            section.why = deviations.error().text();
        }
    }
    if (!section.why.empty()) {
        add_nothing_evaluable(section, !nominal.empty(), options);
        return section;
    }
    if (!nominal.empty()) {
        for (const auto& zone : profile_zones)
            section.characteristics.push_back(profile(zone, section, options));
    }
    add_sizes(section, options);
    return section;
}

}  // namespace cmm::acquisition
