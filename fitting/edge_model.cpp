// SPDX-License-Identifier: Apache-2.0
#include "fitting/edge_model.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "fitting/edge_starts.hpp"
#include "fitting/model_fitter.hpp"

namespace cmm::fitting {
namespace {

constexpr std::array first_turns_rad{1.3, 1.0, 0.75};  // to either side of the nose
constexpr double least_gain = 2.0;                     // "positive" evidence: Kass and Raftery 1995
constexpr double trimmed_share = 0.04;                 // of a window at either end: it may have grown past the model's
// Variance of the parameters over that of a window which was not chosen by the same points: measured on the arcs of
// turbine blades (docs/measured.md).
constexpr double chosen_window = 1.2;
constexpr double surely_round = 25.0;  // squared roundness over its variance: above it an ellipse, no parabola
constexpr double barely_round = 4.0;   // below it no ellipse
constexpr double least_arc_turn_rad = std::numbers::pi / 6.0;  // of each of two arcs: less is a side

class Chooser {
  public:
    Chooser(const EdgePoints& edge, std::optional<EdgeModel> request) : fitter_(edge), request_(request) {}

    EdgeChoice run() {
        for (const double angle : first_turns_rad) {
            window_ = fitter_.turning_by(angle);
            if (window_.count() < EllipseShape::size + 3) break;
            // The narrowest is tried in any case: it says why there is no model.
            if (angle != first_turns_rad.back() && fitter_.reaches_a_side(window_)) continue;
            if (try_models()) break;
        }
        pick();
        return std::move(choice_);
    }

  private:
    /// The simplest model that the points do not refuse.
    bool try_models() {
        if (wanted(EdgeModel::arc) && try_shape(arc_start(fitter_, window_))) return true;
        if (wanted(EdgeModel::ellipse) || wanted(EdgeModel::parabola))
            if (try_conics()) return true;
        return wanted(EdgeModel::double_arc) && try_shape(two_arcs_start(fitter_, window_));
    }

    bool wanted(EdgeModel model) const { return !request_ || *request_ == model; }

    /// An ellipse whose roundness is not told from a parabola's is tried as one first; where no ellipse will do, no
    /// parabola will, which is one of them.
    bool try_conics() {
        if (request_ == EdgeModel::parabola) return try_shape(vertex_start(fitter_, window_));
        const auto start = round_start(fitter_, window_);
        if (!start) return false;
        fitter_.forget_normals();
        const auto ellipse = fitter_.fit(*start, window_);
        const double roundness = ellipse.shape.values()[4];
        const double variance = std::pow(fitter_.edge().noise.sigma_mm, 2) * inverse_of_small(ellipse.normal)(4, 4);
        const double significance = roundness * std::abs(roundness) / std::max(variance, 1e-300);
        if (!request_ && !ellipse.hopeless && significance < surely_round)
            if (try_shape(std::optional(ParabolaShape(ellipse.shape.values().head<4>())))) return true;
        return significance > barely_round && try_shape(std::optional(ellipse.shape));
    }

    /// Fits a shape in the window, extends and judges it. True when the points support it.
    template <class Shape>
    bool try_shape(const std::optional<Shape>& start) {
        if (!start) return false;
        fitter_.forget_normals();
        auto fitted = fitter_.fit(*start, window_);
        std::string why = fitter_.misfit(fitted, window_);
        EdgeWindow window = window_;
        if (why.empty()) {
            fitter_.grow(fitted, window);
            const auto trim = static_cast<std::size_t>(std::ceil(trimmed_share * static_cast<double>(window.count())));
            window = {window.begin + trim, window.end - trim};
            fitted = fitter_.fit(fitted.shape, window);
            why = fitter_.misfit(fitted, window);
        }
        if constexpr (Shape::model == EdgeModel::double_arc)
            if (why.empty() && lopsided(fitted.shape, window)) why = "one of the arcs turns by less than 30 degrees";
        const bool supported = why.empty();
        record(fitted, window, std::move(why));
        return supported;
    }

    template <class Shape>
    void record(const OrthogonalFit<Shape>& fitted, const EdgeWindow& window, std::string why) {
        ModelTrial trial;
        trial.model = Shape::model;
        trial.shape = fitted.shape;
        trial.why = std::move(why);
        trial.begin = window.begin;
        trial.end = window.end;
        const double freedom = static_cast<double>(window.count()) - Shape::size;
        trial.rms_mm = std::sqrt(fitted.squares / freedom);
        trial.gain = fitter_.gain(fitted.squares, Shape::size, window);
        trial.noise = combined_noise(fitted.squares, freedom, fitter_.edge().noise);
        using Matrix = typename OrthogonalFit<Shape>::Matrix;
        trial.covariance = chosen_window * std::pow(trial.noise.sigma_mm, 2) * Matrix(inverse_of_small(fitted.normal));
        const auto same = std::find_if(choice_.trials.begin(), choice_.trials.end(),
                                       [](const ModelTrial& t) { return t.model == Shape::model; });
        if (same == choice_.trials.end())
            choice_.trials.push_back(std::move(trial));
        else
            *same = std::move(trial);
    }

    void pick() {
        for (std::size_t i = 0; i < choice_.trials.size(); ++i) {
            const ModelTrial& trial = choice_.trials[i];
            if (!trial.why.empty() || trial.gain < least_gain) continue;
            if (!choice_.chosen || trial.gain > choice_.trials[*choice_.chosen].gain) choice_.chosen = i;
        }
    }

    bool lopsided(const DoubleArcShape& shape, const EdgeWindow& w) const {
        const double meeting = shape.values()[4];
        const Vec2 m(std::cos(meeting), std::sin(meeting));
        return turn_angle(fitter_.normal(w.begin), m) < least_arc_turn_rad ||
               turn_angle(m, fitter_.normal(w.end - 1)) < least_arc_turn_rad;
    }

    ModelFitter fitter_;
    std::optional<EdgeModel> request_;
    EdgeWindow window_;
    EdgeChoice choice_;
};

}  // namespace

EdgeChoice choose_edge_model(const EdgePoints& edge, std::optional<EdgeModel> request) {
    if (request == EdgeModel::free || edge.points.empty()) return {};
    return Chooser(edge, request).run();
}

}  // namespace cmm::fitting
