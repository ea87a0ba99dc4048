// SPDX-License-Identifier: Apache-2.0
#include "fitting/open_edges.hpp"

#include <algorithm>
#include <utility>

namespace cmm::fitting {

Noise noise_of(const SmoothCurve& smooth, std::size_t points) {
    return {smooth.sigma_mm, static_cast<double>(points) - smooth.freedom};
}

void fit_open_edges(const OpenEdges& open, const SmoothCurve& smooth, std::span<const Vec2> good, SectionFit& fit) {
    if (!open.le && !open.te) return;
    const EdgeFitter fitter({smooth, good, open.part, open.ball_mm, noise_of(smooth, good.size()), open.gaps});
    const auto take = [&](EdgeOutcome outcome, EdgeFit& edge) {
        edge = std::move(outcome.fit);
        answer_by_contour(outcome.answer, smooth.curve, fit.contour, edge);
    };
    if (open.le) take(fitter.run(open.edges.le, open.edges.te, open.le_model), fit.le);
    if (open.te) take(fitter.run(open.edges.te, open.edges.le, open.te_model), fit.te);
}

void answer_by_contour(const EdgeAnswer& answer, const PiecewiseCubic& curve, std::span<const ContourPoint> contour,
                       EdgeFit& edge) {
    // Behind the lowest parameter they ascend.
    const auto lowest = std::min_element(contour.begin(), contour.end(),
                                         [](const ContourPoint& a, const ContourPoint& b) { return a.t < b.t; });
    const auto before = [](const ContourPoint& point, double t) { return point.t < t; };
    for (std::size_t k = 0; k < answer.t.size(); ++k) {
        const double t = curve.wrap(answer.t[k]);
        auto at = std::lower_bound(lowest, contour.end(), t, before);
        if (at == contour.end()) at = std::lower_bound(contour.begin(), lowest, t, before);
        const auto point = static_cast<std::size_t>(at - contour.begin()) % contour.size();
        for (Eigen::Index number = 0; number < 3; ++number)
            edge.slopes[static_cast<std::size_t>(number)].add(point,
                                                              answer.by_point(number, static_cast<Eigen::Index>(k)));
    }
}

}  // namespace cmm::fitting
