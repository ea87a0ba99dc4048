// SPDX-License-Identifier: Apache-2.0
#include "acquisition/measure_again.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <utility>

#include "acquisition/ball_path.hpp"
#include "acquisition/point_tolerance.hpp"
#include "acquisition/worst_place.hpp"
#include "fitting/closest_point.hpp"
#include "fitting/statistics.hpp"
#include "fitting/thickness_measures.hpp"

namespace cmm::acquisition {
namespace {

using Eigen::Vector2d;
using fitting::Zone;
using Kind = CharacteristicKind;

constexpr double spare = 1.3;          // the value moves when points are added, the guard band is an estimate
constexpr std::size_t most_split = 8;  // of a gap in one pass
constexpr double least_gap_mm = 0.02;  // what a probe can tell apart
constexpr std::size_t beside = 6;      // points of the lap to either side: so far the smoothing reaches
constexpr double touch_down_s = 1.0;
constexpr double near_place_steps = 0.6;  // of the lap: a point so near to a place was measured there
constexpr double near_touch_share = 0.1;  // of the contour's length, about a place where the largest circle touches

/// The lap without the points past its start, and how densely each of its steps is to be measured.
class AgainPlanner {
  public:
    AgainPlanner(const SectionResult& judged, const SectionSetup& setup, const PlannedPath& lap,
                 const UntilDecided& bound)
        : judged_(judged), setup_(setup), bound_(bound), lap_(lap.points) {
        lap_.resize(lap_.size() - std::min(lap_.size(), SamplingOptions().overlap));
        split_.assign(lap_.size(), 1);
        missing_.assign(lap_.size(), 0);
        std::vector<double> breaks{0.0};
        std::vector<fitting::PiecewiseCubic::Piece> sides;
        for (std::size_t i = 0; i < lap_.size(); ++i) {
            const Vector2d from = centre(i), side = centre(i + 1) - from;
            sides.push_back({from, side.normalized(), Vector2d::Zero(), Vector2d::Zero()});
            breaks.push_back(breaks.back() + side.norm());
        }
        polygon_ = fitting::PiecewiseCubic(std::move(breaks), std::move(sides), true);
        index_ = fitting::ClosestPointIndex(polygon_);
    }

    std::optional<AgainPass> plan() {
        AgainPass pass;
        const auto& characteristics = judged_.characteristics;
        const bool open = is_only_to_be_measured() ||
                          std::any_of(characteristics.begin(), characteristics.end(), lacks_measured_places);
        const bool gaps = open && ask_gaps();
        for (const auto& c : characteristics) {
            const bool by_density = judged_.all_round() && c.decision == Decision::undecided && ask(c);
            if (by_density || (gaps && lacks_measured_places(c))) pass.because.push_back(c.name);
        }
        if (pass.because.empty() && !gaps) return std::nullopt;
        fill(pass);
        if (pass.stretches.empty() || spent_s() + pass.duration_s > bound_.seconds) return std::nullopt;
        return pass;
    }

  private:
    Vector2d centre(std::size_t i) const { return lap_[i % lap_.size()].centre_mm.head<2>(); }

    /// What no number of points makes smaller: bounds, and what machine, probe and temperature share of U95.
    struct NoNoise {
        double bound = 0.0, shared = 0.0;

        /// What is left for the noise of a guard, or of the room for one.
        double leave_of(double whole) const {
            const double left = whole - bound;
            if (shared == 0.0) return left;
            return left > shared ? std::sqrt(left * left - shared * shared) : 0.0;
        }
    };

    /// Of one number; of the largest of many by their own bound and deviate.
    NoNoise no_noise_of(const Characteristic& c) const {
        if (!c.budget) return {};
        const auto& rule = setup_.gate.rule;
        return {rule.guards(c.budget->bound).accept, rule.deviate() * c.budget->shared()};
    }

    NoNoise no_noise_of_many(const Characteristic& c, double bound) const {
        const double deviate = fitting::upper_deviate_of_largest(setup_.gate.rule.risk_of_look(), least_shared_values);
        return {bound, c.budget ? deviate * c.budget->shared() : 0.0};
    }

    /// Into how many parts the gaps have to be split for this characteristic; nothing: that would not help.
    std::optional<std::size_t> split_for(const Characteristic& c, const NoNoise& no_noise) const {
        const double over = c.upper ? *c.value - *c.upper : -1e300, under = c.lower ? *c.lower - *c.value : -1e300;
        const double excess = std::max(over, under);  // of the nearer limit, negative inside
        const double guard = excess > 0.0 ? c.guard_reject.value_or(0.0) : c.guard_accept.value_or(0.0);
        const double room = no_noise.leave_of(std::abs(excess)), noise = no_noise.leave_of(guard);
        if (room <= 0.0 || noise <= 0.0) return std::nullopt;
        const double wanted = spare * std::pow(noise / room, 2);
        if (wanted * density() > bound_.most_density) return std::nullopt;
        return std::clamp<std::size_t>(static_cast<std::size_t>(std::ceil(wanted)), 2, most_split);
    }

    /// How many times as dense as the lap the densest stretch is by now.
    double density() const {
        std::vector<std::size_t> count(lap_.size(), 1);
        for (const auto& point : judged_.points)
            if (point.pass > 0) ++count[index_.closest(point.centre_mm.head<2>()).span];
        return static_cast<double>(*std::max_element(count.begin(), count.end()));
    }

    const CharacteristicSpec* spec_of(const Characteristic& c) const {
        for (const auto& spec : setup_.gate.characteristics)
            if (spec.label == c.name && spec.is_of(judged_.index)) return &spec;
        return nullptr;
    }

    bool ask(const Characteristic& c) {
        if (!c.value || judged_.deviation_mm.empty()) return false;
        constexpr std::array zones{std::pair{"profile_le", Zone::le}, std::pair{"profile_suction", Zone::suction},
                                   std::pair{"profile_te", Zone::te}, std::pair{"profile_pressure", Zone::pressure}};
        for (const auto& [name, zone] : zones)
            if (c.name == name) return ask_profile(c, zone);
        if (c.name == point_tolerance_name) {
            const auto finer = split_for(c, no_noise_of_many(c, 0.0));
            if (finer) std::fill(split_.begin(), split_.end(), *finer);
            return finer.has_value();
        }
        const auto* spec = spec_of(c);
        const auto kind = spec != nullptr ? std::optional(spec->kind) : characteristic_kind_from(c.name);
        if (!kind || *kind == Kind::points_out) return false;  // more points make none of them more certain
        const auto split = split_for(c, no_noise_of(c));
        if (!split) return false;
        switch (*kind) {
            case Kind::le_radius:
            case Kind::le_thickness:
            case Kind::le_angle:
            case Kind::profile_form_le:
                mark_zone(Zone::le, *split);
                break;
            case Kind::te_radius:
            case Kind::te_thickness:
            case Kind::te_angle:
            case Kind::profile_form_te:
                mark_zone(Zone::te, *split);
                break;
            case Kind::profile_form_suction:
                mark_zone(Zone::suction, *split);
                break;
            case Kind::profile_form_pressure:
                mark_zone(Zone::pressure, *split);
                break;
            case Kind::chord:
            case Kind::axial_chord:
            case Kind::stagger:
                mark_zone(Zone::le, *split);
                mark_zone(Zone::te, *split);
                break;
            case Kind::least_curvature:
            case Kind::greatest_curvature:
            case Kind::curvature_deviation:
                mark_zone(*spec->zone, *split);
                break;
            case Kind::max_thickness:
            case Kind::max_thickness_position:
                mark_thickest(*split);
                break;
            default:
                std::fill(split_.begin(), split_.end(), *split);
        }
        return true;
    }

    /// Nothing has limits, and it was not measured all round.
    bool is_only_to_be_measured() const {
        const auto has_limit = [](const Characteristic& c) { return c.lower || c.upper; };
        return judged_.decision() == Decision::undecided &&
               std::none_of(judged_.characteristics.begin(), judged_.characteristics.end(), has_limit);
    }

    /// With limits, and not decided where something was not measured. What is not evaluable for another reason asks in
    /// vain, once: then the gap is measured.
    static bool lacks_measured_places(const Characteristic& c) {
        return (c.lower || c.upper) &&
               (c.partly ? c.decision == Decision::undecided : c.decision == Decision::not_evaluable);
    }

    /// Places of the lap in gaps of the contour where no good point is. Nothing: there are none.
    bool ask_gaps() {
        const auto& contour = judged_.fit->contour;
        const std::size_t n = lap_.size();
        const auto span_of = [&](const fitting::ContourPoint& at) {
            return index_.closest(at.position_mm + setup_.ball_radius_mm * at.normal).span;
        };
        std::vector<char> there(n, 0);
        for (const auto& point : judged_.points) {
            if (point.verdict.reason != fitting::RejectReason::none) continue;
            const Vector2d at = point.centre_mm.head<2>();
            const std::size_t span = index_.closest(at).span;
            for (const std::size_t i : {span, (span + 1) % n}) {
                const double step_mm = (centre(i + 1) - centre(i + n - 1)).norm() / 2.0;
                if ((at - centre(i)).norm() < near_place_steps * step_mm) there[i] = 1;
            }
        }
        bool any = false;
        for (const ContourGap& gap : judged_.gaps()) {
            const std::size_t first = span_of(contour[gap.before]), last = span_of(contour[gap.behind]);
            for (std::size_t i = first; i != (last + 1) % n; i = (i + 1) % n) {
                missing_[i] = static_cast<char>(there[i] == 0);
                any = any || there[i] == 0;
            }
        }
        return any;
    }

    /// The places that may lie beyond the limit.
    bool ask_profile(const Characteristic& c, Zone zone) {
        const auto& contour = judged_.fit->contour;
        double bound = 0.0;
        for (std::size_t i = 0; i < contour.size(); ++i)
            if (contour[i].zone == zone)
                bound = std::max(bound, 2.0 * (contour[i].offset_error_mm + contour[i].bound_mm +
                                               std::abs(contour[i].machine.known_mm)));
        const auto split = split_for(c, no_noise_of_many(c, bound));
        if (!split) return false;
        for (std::size_t i = 0; i < contour.size(); ++i) {
            const auto& d = judged_.deviation_mm[i];
            if (contour[i].zone != zone || !d || 2.0 * std::abs(*d) + *c.guard_accept <= *c.upper) continue;
            mark(contour[i], *split);
        }
        return true;
    }

    void mark_zone(Zone zone, std::size_t split) {
        for (const auto& point : judged_.fit->contour)
            if (point.zone == zone) mark(point, split);
    }

    void mark_thickest(std::size_t split) {
        fitting::MeasuredSection measured(*judged_.fit);
        const auto thickness = fitting::measure_max_thickness(measured);
        if (!thickness) return;
        const auto& contour = judged_.fit->contour;
        const double reach_mm = 0.5 * near_touch_share * contour.back().arc_length_mm;
        for (const auto& [at, weight] : thickness->slopes.parts())
            for (const auto& point : contour)
                if ((point.position_mm - contour[at].position_mm).norm() < reach_mm && point.zone == contour[at].zone)
                    mark(point, split);
    }

    void mark(const fitting::ContourPoint& place, std::size_t split) {
        const std::size_t n = lap_.size();
        const auto foot = index_.closest(place.position_mm + setup_.ball_radius_mm * place.normal, last_span_);
        last_span_ = foot.span;
        for (std::size_t k = 0; k <= 2 * beside; ++k) {
            std::size_t& known = split_[(foot.span + n + k - beside) % n];
            known = std::max(known, split);
        }
    }

    /// Where a step of the lap has points, as shares of it: its beginning, those of earlier passes, its end.
    std::vector<std::vector<double>> occupied() {
        std::vector<std::vector<double>> shares(lap_.size(), std::vector<double>{0.0});
        const auto& breaks = polygon_.breaks();
        for (const auto& point : judged_.points) {
            if (point.pass == 0) continue;
            const auto foot = index_.closest(point.centre_mm.head<2>(), last_span_);
            last_span_ = foot.span;
            shares[foot.span].push_back((foot.t - breaks[foot.span]) / (breaks[foot.span + 1] - breaks[foot.span]));
        }
        for (auto& of_step : shares) {
            of_step.push_back(1.0);
            std::sort(of_step.begin(), of_step.end());
        }
        return shares;
    }

    drivers::PathPoint between(std::size_t i, double share) const {
        const auto &from = lap_[i], &to = lap_[(i + 1) % lap_.size()];
        drivers::PathPoint point = from;
        point.centre_mm += share * (to.centre_mm - from.centre_mm);
        point.normal = (from.normal + share * (to.normal - from.normal)).normalized();
        point.speed_mm_s = std::min(from.speed_mm_s, to.speed_mm_s);
        return point;
    }

    /// By the passes before, as their points tell.
    double spent_s() {
        double spent = 0.0;
        const RecordedPoint* before = nullptr;
        for (const auto& point : judged_.points) {
            if (point.pass == 0) continue;
            const auto span = index_.closest(point.centre_mm.head<2>(), last_span_).span;
            last_span_ = span;
            const double step_mm = before != nullptr ? (point.centre_mm - before->centre_mm).norm() : 0.0;
            const bool goes_on = before != nullptr && before->pass == point.pass &&
                                 step_mm < 2.0 * (centre(span + 1) - centre(span)).norm();
            spent += goes_on ? step_mm / lap_[span].speed_mm_s : touch_down_s;
            before = &point;
        }
        return spent;
    }

    bool is_asked_for(std::size_t step) const { return split_[step] > 1 || missing_[step] != 0; }

    void fill(AgainPass& pass) {
        const std::size_t n = lap_.size();
        const auto shares = occupied();
        std::size_t first = 0;  // a step behind one that is not asked for
        while (first < n && (!is_asked_for(first) || is_asked_for((first + n - 1) % n)))
            ++first;
        if (first == n) first = 0;
        bool going_on = false;
        const auto add = [&](const drivers::PathPoint& point) {
            if (!std::exchange(going_on, true)) pass.stretches.emplace_back();
            pass.stretches.back().push_back(point);
        };
        for (std::size_t k = 0; k < n; ++k) {
            const std::size_t i = (first + k) % n;
            if (missing_[i] != 0) add(lap_[i]);
            if (split_[i] == 1) {
                going_on = going_on && missing_[i] != 0;
                continue;
            }
            const double step_mm = (centre(i + 1) - centre(i)).norm();
            for (std::size_t gap = 0; gap + 1 < shares[i].size(); ++gap) {
                const double from = shares[i][gap], width = shares[i][gap + 1] - from;
                const auto most = static_cast<std::size_t>(width * step_mm / least_gap_mm);
                const std::size_t parts = std::min(split_[i], most);
                for (std::size_t part = 1; part < parts; ++part)
                    add(between(i, from + width * static_cast<double>(part) / static_cast<double>(parts)));
            }
        }
        for (const auto& stretch : pass.stretches) {
            pass.duration_s += touch_down_s;
            for (std::size_t k = 1; k < stretch.size(); ++k)
                pass.duration_s += (stretch[k].centre_mm - stretch[k - 1].centre_mm).norm() / stretch[k].speed_mm_s;
        }
    }

    const SectionResult& judged_;
    const SectionSetup& setup_;
    const UntilDecided& bound_;
    std::vector<drivers::PathPoint> lap_;
    std::vector<std::size_t> split_;  // by step of the lap; 1: not asked for
    std::vector<char> missing_;       // whether the place where the step begins is asked for
    fitting::PiecewiseCubic polygon_;
    fitting::ClosestPointIndex index_;
    std::size_t last_span_ = 0;
};

}  // namespace

std::size_t AgainPass::points() const {
    return std::accumulate(stretches.begin(), stretches.end(), std::size_t{0},
                           [](std::size_t sum, const auto& stretch) { return sum + stretch.size(); });
}

std::optional<AgainPass> plan_again(const SectionResult& judged, const SectionSetup& setup, const PlannedPath& lap,
                                    const UntilDecided& bound) {
    if (!judged.has_contour() || !setup.nominal || lap.points.size() <= SamplingOptions().overlap) return std::nullopt;
    return AgainPlanner(judged, setup, lap, bound).plan();
}

}  // namespace cmm::acquisition
