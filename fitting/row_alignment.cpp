// SPDX-License-Identifier: Apache-2.0
#include "fitting/row_alignment.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "fitting/over_rows.hpp"
#include "fitting/statistics.hpp"

namespace cmm::fitting {
namespace {

constexpr double joint_share = 0.6;         // of few rows: know a joint that all have
constexpr double least_joint_share = 0.2;   // of all rows: agree on a joint
constexpr double agreeing_share = 0.5;      // of those that know one
constexpr double agreeing_sigmas = 3.0;     // from one to the next
constexpr double same_way_share = 0.8;      // of what is told of one place: the curvature rises there, or it falls
constexpr double most_unlike = 1.25;        // of its places: those of joints that all rows have are 0.90 at most
constexpr std::size_t rows_that_judge = 6;  // of a form over z that fewer do not tell
constexpr double step_range = 3.0;          // of a joint's step over the rows, over the usual one
constexpr double least_told_mm = 3e-4;      // of a joint's place

/// Whether a side begins at a feature.
constexpr bool is_side(std::size_t feature) {
    return feature == RowFeatures::le_end || feature == RowFeatures::te_end;
}

/// Of a feature among the knots: two more on each side before it.
constexpr std::size_t knot_of(std::size_t feature) {
    return feature + (feature > RowFeatures::le_end ? 2 : 0) + (feature > RowFeatures::te_end ? 2 : 0);
}

/// What the rows know of the joint at one end of their edges: its place from where places count, mm. By row.
using ToldJoints = std::vector<std::optional<RowJoint>>;

std::size_t count_of(const ToldJoints& told) {
    return static_cast<std::size_t>(
        std::count_if(told.begin(), told.end(), [](const auto& j) { return j.has_value(); }));
}

std::vector<std::optional<Known>> places_of(const ToldJoints& told) {
    std::vector<std::optional<Known>> places;
    for (const auto& joint : told)
        places.push_back(joint ? std::optional(Known{joint->s_mm, joint->sigma_mm}) : std::nullopt);
    return places;
}

/// The median.
double usual(std::vector<double> values) {
    return nth_smallest(values, values.size() / 2);
}

/// Within which a joint's steps on the rows are.
std::pair<double, double> usual_steps(const ToldJoints& told) {
    std::vector<double> steps;
    for (const auto& joint : told)
        if (joint) steps.push_back(joint->step);
    const double step = usual(std::move(steps));
    return std::minmax({step / step_range, step * step_range});
}

/// Steps of the curvature at a joint, smoothed over the rows. A row whose points are off there tells any step.
std::vector<double> common_steps(const ToldJoints& told, std::span<const double> z) {
    const auto [low, high] = usual_steps(told);
    std::vector<std::optional<Known>> known(told.size());
    for (std::size_t k = 0; k < told.size(); ++k)
        if (told[k]) known[k] = Known{std::clamp(told[k]->step, low, high)};
    auto smooth = smoothed_over(z, known).value;
    for (double& step : smooth)
        step = std::clamp(step, low, high);
    return smooth;
}

double usual_off(std::span<const std::optional<Known>> known, const Smoothed& smooth) {
    std::vector<double> off;
    for (std::size_t k = 0; k < known.size(); ++k)
        if (known[k]) off.push_back(std::abs(known[k]->value - smooth.value[k]));
    return usual(std::move(off));
}

/// Whether a step up is one on most rows that know the joint, or a step down.
bool same_way(const ToldJoints& told) {
    double up = 0.0, down = 0.0;
    for (const auto& joint : told)
        if (joint) (joint->step > 0.0 ? up : down) += 1.0;
    return std::max(up, down) >= same_way_share * (up + down);
}

double usual_doubt_mm(const ToldJoints& told) {
    std::vector<double> sigma;
    for (const auto& joint : told)
        if (joint) sigma.push_back(joint->sigma_mm);
    return usual(std::move(sigma));
}

/// Those of the joints that are at nearly one distance from the edges' ends, from one to the next.
ToldJoints nearest_together(const ToldJoints& told, const Smoothed& ends, double near_mm) {
    struct Place {
        double from_end_mm;
        std::size_t row;
    };
    std::vector<Place> places;
    for (std::size_t k = 0; k < told.size(); ++k)
        if (told[k]) places.push_back({told[k]->s_mm - ends.value[k], k});
    std::sort(places.begin(), places.end(),
              [](const Place& a, const Place& b) { return a.from_end_mm < b.from_end_mm; });
    std::size_t first = 0, most = 0, most_first = 0;
    for (std::size_t i = 0; i < places.size(); ++i) {
        if (i > 0 && places[i].from_end_mm - places[i - 1].from_end_mm > near_mm) first = i;
        if (i + 1 - first <= most) continue;
        most = i + 1 - first;
        most_first = first;
    }
    ToldJoints together(told.size());
    for (std::size_t i = most_first; i < most_first + most; ++i)
        together[places[i].row] = told[places[i].row];
    return together;
}

/// Leaves of what is told what agrees in its place, its way and its step, if that is enough for a joint that all rows
/// have: some may not tell it, and others know another one.
bool keep_agreeing(ToldJoints& told, const Smoothed& ends, double ends_off_mm) {
    const std::size_t known = count_of(told);
    if (known < rows_that_judge) return false;
    const double sigma_mm = usual_doubt_mm(told);
    ToldJoints agreeing = nearest_together(told, ends, agreeing_sigmas * std::hypot(sigma_mm, sigma_mm, ends_off_mm));
    if (!same_way(agreeing)) return false;
    const auto [low, high] = usual_steps(agreeing);
    for (auto& joint : agreeing)
        if (joint && (joint->step < low || joint->step > high)) joint.reset();
    const auto agree = static_cast<double>(count_of(agreeing));
    if (count_of(agreeing) < rows_that_judge || agree < agreeing_share * static_cast<double>(known) ||
        agree < least_joint_share * static_cast<double>(told.size()))
        return false;
    told = std::move(agreeing);
    return true;
}

/// Where rows know a joint and agree on its place, by what each can tell and by how evenly the edges end
/// (`ends_off_mm`); of few rows, where most know it. Each row of a real part may know one that is nowhere else.
std::optional<Smoothed> common_joint(std::span<const double> z, ToldJoints& told, const Smoothed& ends,
                                     double ends_off_mm) {
    if (!keep_agreeing(told, ends, ends_off_mm)) {
        const bool most_know = static_cast<double>(count_of(told)) > joint_share * static_cast<double>(z.size());
        if (!most_know || !same_way(told)) return std::nullopt;
    }
    const auto places = places_of(told);
    Smoothed smooth = told_over(z, places);
    if (count_of(told) >= rows_that_judge &&
        usual_off(places, smooth) > most_unlike * std::hypot(usual_doubt_mm(told), ends_off_mm))
        return std::nullopt;
    return smooth;
}

}  // namespace

RowAlignment::RowAlignment(std::span<const RowFeatures> rows) {
    const std::size_t n = rows.size();
    std::vector<double> z(n);
    std::array<std::vector<double>, count> ahead;  // of the LE nose
    const auto from_nose = [&](std::size_t k, double s) {
        const double d = s - rows[k].s_mm[RowFeatures::le_nose], l = rows[k].length_mm;
        return d - std::floor(d / l) * l;
    };
    for (std::size_t k = 0; k < n; ++k) {
        z[k] = rows[k].z_mm;
        for (std::size_t j = 0; j < count; ++j)
            ahead[j].push_back(from_nose(k, rows[k].s_mm[j]));
    }
    // The ends of the edges, as distances from their noses.
    std::array<bool, count> at_joint{};
    for (const auto& [end, nose] : {std::pair{RowFeatures::le_end, RowFeatures::le_nose},
                                    {RowFeatures::te_begin, RowFeatures::te_nose},
                                    {RowFeatures::te_end, RowFeatures::te_nose},
                                    {RowFeatures::le_begin, RowFeatures::le_nose}}) {
        const bool before_le = end == RowFeatures::le_begin;
        const auto origin = [&, nose = nose](std::size_t k) { return before_le ? rows[k].length_mm : ahead[nose][k]; };
        std::vector<std::optional<Known>> ends(n);
        ToldJoints told(n);
        for (std::size_t k = 0; k < n; ++k) {
            ends[k] = Known{ahead[end][k] - origin(k), 1.0};
            if (const auto& joint = rows[k].joints[end])
                told[k] = RowJoint{from_nose(k, joint->s_mm) - origin(k), std::max(joint->sigma_mm, least_told_mm),
                                   joint->step};
        }
        Smoothed smooth = smoothed_over(z, ends);
        if (auto joint = common_joint(z, told, smooth, usual_off(ends, smooth))) {
            at_joint[end] = true;
            smooth = std::move(*joint);
        }
        for (std::size_t k = 0; k < n; ++k)
            ahead[end][k] = origin(k) + smooth.value[k];
        if (!at_joint[end]) continue;
        for (const double sigma : smooth.sigma)
            joint_sigma_mm_[end].push_back(std::hypot(sigma, smooth.apart));
        joint_step_[end] = common_steps(told, z);
    }
    // A row on which the common ends would not follow each other keeps its own, which do.
    for (std::size_t k = 0; k < n; ++k) {
        const auto follow = [&](std::size_t j) {
            return ahead[j][k] < (j + 1 < count ? ahead[j + 1][k] : rows[k].length_mm);
        };
        bool all = true;
        for (std::size_t j = 0; j < count; ++j)
            all = all && follow(j);
        for (std::size_t j = 0; j < count && !all; ++j)
            ahead[j][k] = from_nose(k, rows[k].s_mm[j]);
    }
    for (std::size_t k = 0; k < n; ++k)
        period_ += rows[k].length_mm / static_cast<double>(n);
    for (std::size_t j = 0; j < count; ++j)
        for (std::size_t k = 0; k < n; ++k)
            u_[j] += ahead[j][k] / rows[k].length_mm * period_ / static_cast<double>(n);
    u_[count] = period_;
    for (std::size_t j = 0; j < count; ++j)
        if (at_joint[j]) joints_.push_back(u_[j]);
    knot_u_ = with_quarters(u_);
    for (std::size_t k = 0; k < n; ++k) {
        AtFeatures s;
        for (std::size_t j = 0; j < count; ++j)
            s[j] = rows[k].s_mm[RowFeatures::le_nose] + ahead[j][k];
        s[count] = s[0] + rows[k].length_mm;
        maps_.push_back(map_of(with_quarters(s)));
    }
}

/// At the features, and a quarter from each end of a side: an edge that is longer on one row would otherwise move the
/// places all along it.
RowAlignment::AtKnots RowAlignment::with_quarters(const AtFeatures& at) {
    AtKnots values;
    for (std::size_t j = 0; j <= count; ++j) {
        values[knot_of(j)] = at[j];
        if (!is_side(j)) continue;
        values[knot_of(j) + 1] = 0.75 * at[j] + 0.25 * at[j + 1];
        values[knot_of(j) + 2] = 0.25 * at[j] + 0.75 * at[j + 1];
    }
    return values;
}

RowAlignment::Map RowAlignment::map_of(const AtKnots& s) const {
    Map map{s, {}};
    constexpr std::size_t spans = knots - 1;
    std::array<double, spans> secant;
    for (std::size_t j = 0; j < spans; ++j)
        secant[j] = (map.s[j + 1] - map.s[j]) / (knot_u_[j + 1] - knot_u_[j]);
    for (std::size_t j = 0; j < knots; ++j) {
        const double left = secant[(j + spans - 1) % spans], right = secant[j % spans];
        map.slope[j] = left * right > 0.0 ? 2.0 * left * right / (left + right) : 0.0;
    }
    return map;
}

std::vector<RowAlignment::CommonJoint> RowAlignment::joints_on(std::size_t row) const {
    std::vector<CommonJoint> joints;
    for (std::size_t j = 0; j < count; ++j)
        if (!joint_sigma_mm_[j].empty())
            joints.push_back({maps_[row].s[knot_of(j)], joint_sigma_mm_[j][row], joint_step_[j][row]});
    return joints;
}

double RowAlignment::arc_length(std::size_t row, double u) const {
    const Map& map = maps_[row];
    const auto above = std::upper_bound(knot_u_.begin() + 1, knot_u_.end() - 1, u);
    const auto j = static_cast<std::size_t>(above - knot_u_.begin()) - 1;
    const double h = knot_u_[j + 1] - knot_u_[j], w = (u - knot_u_[j]) / h;
    const double a = map.s[j], b = map.s[j + 1], p = h * map.slope[j], q = h * map.slope[j + 1];
    return a + w * (p + w * (3.0 * (b - a) - 2.0 * p - q + w * (2.0 * (a - b) + p + q)));
}

}  // namespace cmm::fitting
