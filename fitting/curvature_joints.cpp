// SPDX-License-Identifier: Apache-2.0
#include "fitting/curvature_joints.hpp"

#include <algorithm>
#include <cmath>

namespace cmm::fitting {
namespace {

constexpr std::size_t flank = 2;        // spans from the steep ones to those that show the slope before and behind
constexpr std::size_t widest_core = 5;  // steep spans
constexpr double core_share = 0.5;      // of the steepest slope
constexpr double step_share = 0.2;      // of what the curvature changes over the steep spans
constexpr std::size_t level_spans = 4;  // beside the end of a slope
constexpr double level_share = 0.25;    // of the slope
constexpr double ramp_share = 0.5;      // of what the curvature changes at the end of a slope
constexpr double least_effect = 1.0 / 3.0;
constexpr int iterations = 6;
constexpr double knot_free_share = 0.35;  // of a span: free of other knots

}  // namespace

std::vector<CurvatureJoint> find_curvature_joints(std::span<const double> breaks, std::span<const double> slope,
                                                  std::span<const double> length, double sigma_mm) {
    const std::size_t n = slope.size();
    std::vector<CurvatureJoint> joints;
    if (n < 4 * widest_core) return joints;
    for (std::size_t peak = widest_core + flank; peak + widest_core + flank < n; ++peak) {
        const double steepest = std::abs(slope[peak]);
        if (steepest < std::abs(slope[peak - 1]) || steepest <= std::abs(slope[peak + 1])) continue;
        const auto steep = [&](std::size_t k) {
            return slope[k] * slope[peak] > 0.0 && std::abs(slope[k]) > core_share * steepest;
        };
        std::size_t first = peak, last = peak;
        while (last - first < widest_core && steep(first - 1))
            --first;
        while (last - first < widest_core && steep(last + 1))
            ++last;
        if (last - first >= widest_core) continue;
        // A curvature that runs with the slopes of the flanks and jumps at t has the same change and the same moment.
        const double before = slope[first - flank], behind = slope[last + flank];
        const double left = breaks[first - flank + 1], right = breaks[last + flank];
        double change = 0.0, moment = 0.0, core = 0.0, width_mm = 0.0;
        for (std::size_t k = first - flank + 1; k < last + flank; ++k) {
            const double part = slope[k] * length[k];
            change += part;
            moment += 0.5 * part * (breaks[k] + breaks[k + 1]);
            if (k < first || k > last) continue;
            core += part;
            width_mm += length[k];
        }
        double t = 0.5 * (breaks[first] + breaks[last + 1]), step = 0.0;
        for (int i = 0; i < iterations; ++i) {
            step = change - before * (t - left) - behind * (right - t);
            const double own = 0.5 * (before * (t * t - left * left) + behind * (right * right - t * t));
            t = std::clamp((moment - own) / step, left, right);
        }
        const double off_mm = std::abs(step) * width_mm * width_mm / 24.0;
        if (!std::isfinite(t) || step * core < step_share * core * core || off_mm < least_effect * sigma_mm) continue;
        const CurvatureJoint joint{t, step, step, width_mm, first - flank + 1, last + flank - 1, left, right};
        // Of two that lie next to each other the larger counts.
        while (!joints.empty() && joint.first_span <= joints.back().last_span + 1 &&
               std::abs(joints.back().step) < std::abs(step))
            joints.pop_back();
        if (joints.empty() || joint.first_span > joints.back().last_span + 1) joints.push_back(joint);
    }
    return joints;
}

void add_supposed_joints(std::span<const double> breaks, std::span<const double> slope, std::span<const double> length,
                         double sigma_mm, std::vector<CurvatureJoint>& joints) {
    const std::size_t n = slope.size();
    std::vector<CurvatureJoint> ends;
    for (std::size_t k = level_spans; k + level_spans < n; ++k) {
        const bool falls = slope[k] < 0.0;
        const auto at = [&](std::size_t back) { return falls ? k - back : k + back; };  // into the slope
        const auto beyond = [&](std::size_t on) { return falls ? k + on : k - on; };
        double steepest = 0.0;
        for (std::size_t j = 0; j < level_spans; ++j)
            steepest = std::max(steepest, (falls ? -1.0 : 1.0) * slope[at(j)]);
        if (std::abs(slope[k]) < core_share * steepest) continue;
        bool level = true;
        double core = 0.0, width_mm = 0.0;
        for (std::size_t j = 1; j <= level_spans; ++j)
            level = level && std::abs(slope[beyond(j)]) < (j > 1 ? level_share : core_share) * steepest;
        for (std::size_t j = 0; j < 3; ++j) {
            core += slope[at(j)] * length[at(j)];
            width_mm += length[at(j)];
        }
        const double change = falls ? -core : core;  // as the slope has it
        if (!level || change * width_mm * width_mm / 24.0 < least_effect * sigma_mm) continue;
        const std::size_t first = std::min(at(2), k), last = std::max(at(2), k);
        ends.push_back(
            {breaks[falls ? k : k + 1], core, core, width_mm, first, last, breaks[first - 1], breaks[last + 2], true});
    }
    const auto near = [](const CurvatureJoint& a, const CurvatureJoint& b) {
        return a.first_span <= b.last_span + 2 && b.first_span <= a.last_span + 2;
    };
    std::erase_if(joints, [&](const CurvatureJoint& ramp) {
        return std::any_of(ends.begin(), ends.end(), [&](const CurvatureJoint& end) {
            return near(ramp, end) && std::abs(ramp.step) < std::abs(end.step) &&
                   ramp.step * end.step < ramp_share * end.step * end.step;
        });
    });
    std::stable_sort(ends.begin(), ends.end(), [](const CurvatureJoint& a, const CurvatureJoint& b) {
        return std::abs(a.step) > std::abs(b.step);
    });
    for (const CurvatureJoint& end : ends) {
        if (std::any_of(joints.begin(), joints.end(), [&](const CurvatureJoint& j) { return near(j, end); })) continue;
        joints.insert(std::find_if(joints.begin(), joints.end(), [&](const auto& j) { return j.t > end.t; }), end);
    }
}

std::vector<double> breaks_with_joints(std::span<const double> breaks, std::span<const double> places,
                                       std::size_t knots, double share, std::vector<KnotCluster>& at) {
    std::vector<double> out;
    out.reserve(breaks.size() + knots * places.size());
    at.clear();
    std::size_t k = 0;
    for (const double place : places) {
        const auto next = std::upper_bound(breaks.begin(), breaks.end(), place);
        const auto span = static_cast<std::size_t>(next - breaks.begin()) - 1;
        const double width = breaks[span + 1] - breaks[span];
        const double clear = knot_free_share * width, apart = share * width;
        for (; k < breaks.size() && breaks[k] < place - clear; ++k)
            out.push_back(breaks[k]);
        while (k + 1 < breaks.size() && breaks[k] <= place + clear)
            ++k;
        at.push_back({out.size(), apart});
        for (std::size_t j = 0; j < knots; ++j)
            out.push_back(place + (static_cast<double>(j) - 0.5 * static_cast<double>(knots - 1)) * apart);
    }
    for (; k < breaks.size(); ++k)
        out.push_back(breaks[k]);
    return out;
}

}  // namespace cmm::fitting
