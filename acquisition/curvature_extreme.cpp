// SPDX-License-Identifier: Apache-2.0
#include "acquisition/curvature_extreme.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "acquisition/characteristic.hpp"
#include "acquisition/worst_place.hpp"
#include "core/text.hpp"
#include "fitting/curvature_measures.hpp"
#include "fitting/statistics.hpp"

namespace cmm::acquisition {
namespace {

using fitting::ContourGeometry;
using fitting::ContourPlace;
using fitting::MeanCurvature;
using Kind = CharacteristicKind;

constexpr double places_of_a_window = 24.0;   // the curvature's extreme between two of them is one to 1 in 1 000
constexpr std::size_t places_of_a_noise = 4;  // every so many-th: the noise changes slowly along a side
constexpr double values_of_a_window = 20.0;   // independent ones: the weights' bend jumps at the window's ends
constexpr double risk_of_search = 0.01, risk_of_value = 0.04;  // of the 5 % that U95 leaves
constexpr double most_of_perimeter = 0.45;
constexpr std::size_t least_stretches = 8;  // of the contour in a window: the noise is known on that scale

/// A middle of a window, on the measured contour and on the nominal's.
struct WindowMiddle {
    double s_mm = 0.0, nominal_mm = 0.0;
};

/// Middles of windows that lie within a stretch, so dense that none is missed.
std::vector<double> middles_within(double from_mm, double length_mm, double window_mm) {
    std::vector<double> out;
    const double room = length_mm - window_mm;
    if (room < 0.0) return out;
    const double steps = std::ceil(places_of_a_window * room / window_mm);
    for (double k = 0.0; k <= steps; ++k)
        out.push_back(from_mm + 0.5 * window_mm + (steps > 0.0 ? room * k / steps : 0.0));
    return out;
}

/// The stretches of a contour that are of a zone, by arc length: first and length.
std::vector<std::pair<double, double>> stretches_of(const ContourGeometry& contour, fitting::Zone zone) {
    std::vector<std::pair<double, double>> out;
    const std::size_t n = contour.size();
    std::size_t start = 0;
    while (start < n && contour.point(start).zone == zone)
        ++start;  // so that none goes over the end
    for (std::size_t k = 0; k < n; ++k) {
        const std::size_t i = start + k;
        if (contour.point(i).zone != zone) continue;
        const bool begins = k == 0 || contour.point(i + n - 1).zone != zone;
        const double s = contour.point(i).arc_length_mm;
        if (begins) out.emplace_back(s, 0.0);
        double length = s - out.back().first;
        if (length < 0.0) length += contour.perimeter();
        out.back().second = length;
    }
    return out;
}

/// The signed number whose largest is looked for.
double sense_of(Kind kind) {
    return kind == Kind::least_curvature ? -1.0 : 1.0;
}

std::string method_of(const CharacteristicSpec& spec) {
    const std::string window = core::fixed(spec.window_mm, 3) + " mm of arc length, weights (1 - u^2)^2";
    if (spec.kind == Kind::curvature_deviation)
        return "CURVATURE: largest |difference| from the nominal, after the best fit, of means over " + window;
    return std::string("CURVATURE: ") + (spec.kind == Kind::least_curvature ? "least" : "greatest") + " mean over " +
           window;
}

tl::unexpected<core::Error> too_short(double length_mm, double window_mm) {
    return core::fail(core::ErrorCode::fit_not_evaluable, "the zone is " + core::fixed(length_mm, 3) +
                                                              " mm long, shorter than the window of " +
                                                              core::fixed(window_mm, 3) + " mm");
}

/// Where the contour lies to a place of the nominal: on the same side of the part, however thin that is.
ContourPlace opposite(const ContourGeometry& contour, const fitting::Vec2& position, const fitting::Vec2& normal) {
    ContourPlace nearest;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < contour.size(); ++i) {
        const auto& point = contour.point(i);
        const double squared = (point.position_mm - position).squaredNorm();
        if (squared >= least || point.normal.dot(normal) <= 0.0) continue;
        least = squared;
        nearest.index = i;
    }
    return contour.foot(position, contour.whole(), &nearest);
}

core::Result<std::vector<WindowMiddle>> middles_of(const CharacteristicSpec& spec, const ContourGeometry& contour,
                                                   const CurvatureNominal* nominal) {
    std::vector<WindowMiddle> out;
    double longest = 0.0;
    if (nominal == nullptr) {
        for (const auto& [from, length] : stretches_of(contour, *spec.zone)) {
            longest = std::max(longest, length);
            for (const double s : middles_within(from, length, spec.window_mm))
                out.push_back({s, 0.0});
        }
    } else {
        const auto& curve = nominal->curve;
        const auto span = curve.span_of(*spec.zone);
        longest = span.to_mm - span.from_mm;
        for (const double s : middles_within(span.from_mm, longest, spec.window_mm)) {
            const auto at = curve.curve().evaluate(curve.curve().wrap(s));
            const auto place =
                opposite(contour, nominal->motion.apply(at.position), nominal->motion.apply_to_direction(at.normal));
            out.push_back({contour.arc(place), curve.curve().ahead(curve.le_mm(), s)});
        }
    }
    if (out.empty()) return too_short(longest, spec.window_mm);
    if (spec.window_mm > most_of_perimeter * contour.perimeter())
        return core::fail(core::ErrorCode::fit_not_evaluable, "the window is as long as the section");
    return out;
}

/// Where the contour shows the ball instead of the part, or bridges a gap, no curvature of the part is known.
class LeftOut {
  public:
    LeftOut(const ContourGeometry& contour, bool (*is_out)(const fitting::ContourPoint&))
        : perimeter_(contour.perimeter()) {
        for (const auto& point : contour.points())
            if (is_out(point)) at_mm_.push_back(point.arc_length_mm);
    }
    bool touches(double s_mm, double half_mm) const {
        return std::any_of(at_mm_.begin(), at_mm_.end(),
                           [&](double at) { return std::abs(std::remainder(at - s_mm, perimeter_)) <= half_mm; });
    }

  private:
    double perimeter_;
    std::vector<double> at_mm_;
};

/// A number at a place, larger the nearer it is to what is looked for.
struct PlaceValue {
    double s_mm = 0.0;
    double value = 0.0;   ///< of which the largest is looked for
    double number = 0.0;  ///< signed: the curvature, or its deviation
    double sigma = 0.0, bound = 0.0;
};

/// How uncertain they are: at some of them by the covariance of the contour, evenly between.
void add_noise(const fitting::MeasuredSection& section, const MeanCurvature& mean, std::vector<PlaceValue>& places) {
    const auto find = [&](PlaceValue& place) {
        const auto u = section.uncertainty({"", 0.0, mean.slopes(place.s_mm), {}});
        place.bound = u.offset_error;
        place.sigma = std::max(0.0, u.u95 - u.offset_error) / section.fit().contour_noise.coverage();
    };
    std::size_t known = 0;
    find(places.front());
    while (known + 1 < places.size()) {
        const std::size_t next = std::min(known + places_of_a_noise, places.size() - 1);
        find(places[next]);
        for (std::size_t i = known + 1; i < next; ++i) {
            const double share = static_cast<double>(i - known) / static_cast<double>(next - known);
            places[i].sigma = places[known].sigma + share * (places[next].sigma - places[known].sigma);
            places[i].bound = places[known].bound + share * (places[next].bound - places[known].bound);
        }
        known = next;
    }
}

UncertainLargest largest_of(const std::vector<PlaceValue>& places, double deviate) {
    UncertainLargest out;
    for (const auto& place : places)
        out.add(place.value, deviate * place.sigma, place.bound);
    return out;
}

/// Half the interval that holds the largest of the true values in 95 % of the cases. First the places that cannot be
/// the largest are left out, at a fifth of the risk: one that stands out is as good as alone.
double u95_of_largest(const std::vector<PlaceValue>& places, double independent) {
    const auto deviate = [](double risk, double count) {
        return fitting::upper_deviate_of_largest(0.5 * risk, std::max(1.0, count));
    };
    const double searching = deviate(risk_of_search, independent);
    const double for_certain = largest_of(places, searching).at_least();
    std::vector<PlaceValue> likely;
    for (const auto& place : places)
        if (place.value + searching * place.sigma + place.bound >= for_certain) likely.push_back(place);
    const double share = static_cast<double>(likely.size()) / static_cast<double>(places.size());
    const auto found = largest_of(likely, deviate(risk_of_value, 1.0 + share * (independent - 1.0)));
    return std::max(found.at_most() - found.largest(), found.largest() - found.at_least());
}

/// Which way the limits may be passed decides which side of the interval counts.
void set_guards(const CharacteristicSpec& spec, const std::vector<PlaceValue>& places, double independent,
                const DecisionRule& rule, Characteristic& c) {
    const auto found =
        largest_of(places, fitting::upper_deviate_of_largest(rule.risk_of_look(), std::max(1.0, independent)));
    const auto [more, less] = found.guards();
    // "More" lies beyond what was found, towards the limit on the side that is looked at.
    const bool other_side = spec.kind == Kind::least_curvature ? spec.above.has_value() : spec.below.has_value();
    c.guard_accept = other_side ? std::max(more, less) : more;
    c.guard_reject = other_side ? std::max(more, less) : less;
}

std::string place_note(const CharacteristicSpec& spec, double number, const Eigen::Vector2d& at) {
    const char* what = spec.kind == Kind::curvature_deviation ? (number > 0.0 ? "more bent" : "less bent") : "";
    return std::string(what) + (*what != '\0' ? " than the nominal " : "") + "at x " + core::fixed(at.x(), 3) +
           " mm, y " + core::fixed(at.y(), 3) + " mm";
}

}  // namespace

Characteristic curvature_extreme(const CharacteristicSpec& spec, const fitting::MeasuredSection& section,
                                 const CurvatureNominal* nominal, const DecisionRule& rule) {
    Characteristic c;
    c.unit = unit_of(spec.kind);
    c.method = method_of(spec);
    c.decision = Decision::not_evaluable;
    const ContourGeometry& contour = section.contour();
    const auto middles = middles_of(spec, contour, nominal);
    if (!middles) {
        c.note = middles.error().message;
        return c;
    }
    const MeanCurvature mean(contour, spec.window_mm);
    std::optional<MeanCurvature> nominal_mean;
    if (spec.kind == Kind::curvature_deviation) nominal_mean.emplace(nominal->contour, spec.window_mm);
    const LeftOut unreached(contour, [](const fitting::ContourPoint& p) { return p.measured && !p.reached; });
    const LeftOut unmeasured(contour, [](const fitting::ContourPoint& p) { return !p.measured; });
    std::size_t in_gaps = 0;
    std::vector<PlaceValue> places;
    for (const auto& middle : *middles) {
        if (mean.stretches(middle.s_mm) < least_stretches) {
            c.note = "the window holds fewer than " + std::to_string(least_stretches) + " of the contour's points";
            return c;
        }
        if (unmeasured.touches(middle.s_mm, 0.5 * spec.window_mm)) {
            ++in_gaps;
            continue;
        }
        if (unreached.touches(middle.s_mm, 0.5 * spec.window_mm)) continue;
        PlaceValue place;
        place.s_mm = middle.s_mm;
        place.number = mean.at(middle.s_mm) - (nominal_mean ? nominal_mean->at(middle.nominal_mm) : 0.0);
        place.value = nominal_mean ? std::abs(place.number) : sense_of(spec.kind) * place.number;
        places.push_back(place);
    }
    if (places.empty()) {
        c.note = in_gaps > 0 ? "it was not measured: a gap of the points" : "the ball does not reach it";
        return c;
    }
    add_noise(section, mean, places);
    const auto worst =
        std::max_element(places.begin(), places.end(), [](const auto& a, const auto& b) { return a.value < b.value; });
    const double windows = static_cast<double>(places.size() - 1) / places_of_a_window;
    const double independent = 1.0 + values_of_a_window * windows;
    c.value = nominal_mean ? worst->value : worst->number;
    c.u95 = u95_of_largest(places, independent);
    const auto& noise = section.fit().contour_noise;
    if (noise.has_fields()) c.budget = section.uncertainty({"", 0.0, mean.slopes(worst->s_mm), {}}).budget;
    c.decision = Decision::reported;
    const double s = std::fmod(worst->s_mm + contour.perimeter(), contour.perimeter());
    const auto nearest = std::min_element(
        contour.points().begin(), contour.points().end(),
        [&](const auto& a, const auto& b) { return std::abs(a.arc_length_mm - s) < std::abs(b.arc_length_mm - s); });
    c.note = place_note(spec, worst->number, nearest->position_mm);
    if (const auto note = offset_error_note(worst->bound, c.unit); !note.empty()) c.note += "; " + note;
    const auto share_of = [&](std::size_t count) {
        return static_cast<double>(count) / static_cast<double>(middles->size());
    };
    if (const auto share = share_of(middles->size() - places.size() - in_gaps); share > 0.0)
        c.note += "; " + core::fixed(100.0 * share, 1) + " % of it not evaluable: the ball does not reach there";
    know_gap(share_of(in_gaps), c);
    set_guards(spec, places, independent, rule, c);
    return c;
}

core::Result<double> curvature_of_nominal(const CharacteristicSpec& spec, const fitting::NominalSection& curve,
                                          const ContourGeometry& contour) {
    const auto span = curve.span_of(*spec.zone);
    const auto middles = middles_within(span.from_mm, span.to_mm - span.from_mm, spec.window_mm);
    if (middles.empty()) return too_short(span.to_mm - span.from_mm, spec.window_mm);
    const MeanCurvature mean(contour, spec.window_mm);
    double largest = -std::numeric_limits<double>::infinity();
    for (const double s : middles)
        largest = std::max(largest, sense_of(spec.kind) * mean.at(curve.curve().ahead(curve.le_mm(), s)));
    return sense_of(spec.kind) * largest;
}

}  // namespace cmm::acquisition
