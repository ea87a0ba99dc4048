// SPDX-License-Identifier: Apache-2.0
#include "acquisition/gauge_anova.hpp"

#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/fisher_f.hpp>
#include <cassert>
#include <cmath>

namespace cmm::acquisition {
namespace {

constexpr double pooled_above = 0.25;
constexpr double tail = 0.025;  // of a two-sided 95 % interval

double squared(double value) {
    return value * value;
}

double chi_square_over_freedom(double freedom, double probability) {
    return boost::math::quantile(boost::math::chi_squared(freedom), probability) / freedom;
}
/// How far below its estimate a mean square may be, and how far above, as shares of it (G and H of the literature).
double below(const AnovaRow& row) {
    return 1.0 - 1.0 / chi_square_over_freedom(row.freedom, 1.0 - tail);
}
double above(const AnovaRow& row) {
    return 1.0 / chi_square_over_freedom(row.freedom, tail) - 1.0;
}

/// A mean square with its coefficient in a variance.
struct Term {
    AnovaRow row;
    double coefficient;
    double size() const { return coefficient * row.mean(); }
};

GaugeComponent made(double variance, double low, double high) {
    const auto root = [](double value) { return std::sqrt(std::max(0.0, value)); };
    return {root(variance), root(std::min(low, variance)), root(std::max(high, variance))};
}

/// A sum with coefficients that are not negative. `variance`: the estimate, which differs from the sum where a part of
/// it was negative and counts as none.
GaugeComponent sum_of(const std::vector<Term>& terms, double variance) {
    double sum = 0.0, under = 0.0, over = 0.0;
    for (const auto& term : terms) {
        if (term.row.freedom <= 0.0) continue;
        sum += term.size();
        under += squared(below(term.row) * term.size());
        over += squared(above(term.row) * term.size());
    }
    return made(variance, sum - std::sqrt(under), sum + std::sqrt(over));
}

/// (first - second) / divisor.
GaugeComponent difference_of(const AnovaRow& first, const AnovaRow& second, double divisor) {
    const double a = first.mean() / divisor, b = second.mean() / divisor;
    const boost::math::fisher_f ratio(first.freedom, second.freedom);
    const double high = boost::math::quantile(ratio, 1.0 - tail), low = boost::math::quantile(ratio, tail);
    const double g1 = below(first), h1 = above(first), g2 = below(second), h2 = above(second);
    const double g12 = (squared(high - 1.0) - squared(g1 * high) - squared(h2)) / high;
    const double h12 = (squared(1.0 - low) - squared(h1 * low) - squared(g2)) / low;
    const double under = squared(g1 * a) + squared(h2 * b) + g12 * a * b;
    const double over = squared(h1 * a) + squared(g2 * b) + h12 * a * b;
    return made(a - b, a - b - std::sqrt(std::max(0.0, under)), a - b + std::sqrt(std::max(0.0, over)));
}

double variance_of(const std::optional<GaugeComponent>& component) {
    return component ? squared(component->deviation) : 0.0;
}

/// Sums of squares about the means.
class Squares {
  public:
    explicit Squares(const GaugeValues& values)
        : values_(values), of_part_(values.parts(), 0.0), of_appraiser_(values.appraisers(), 0.0) {
        const auto p = values.parts(), o = values.appraisers(), r = values.trials();
        for (std::size_t i = 0; i < p; ++i)
            for (std::size_t j = 0; j < o; ++j) {
                const double mean = cell(i, j);
                of_part_[i] += mean / static_cast<double>(o);
                of_appraiser_[j] += mean / static_cast<double>(p);
                all_ += mean / static_cast<double>(p * o);
                for (std::size_t k = 0; k < r; ++k)
                    repeats_ += squared(values.at(i, j, k) - mean);
            }
    }
    void fill(GaugeComponents& out) const {
        const auto p = static_cast<double>(values_.parts()), o = static_cast<double>(values_.appraisers()),
                   r = static_cast<double>(values_.trials());
        for (std::size_t i = 0; i < of_part_.size(); ++i) {
            out.parts.squares += o * r * squared(of_part_[i] - all_);
            for (std::size_t j = 0; j < of_appraiser_.size(); ++j)
                out.interaction.squares += r * squared(cell(i, j) - of_part_[i] - of_appraiser_[j] + all_);
        }
        for (const double mean : of_appraiser_)
            out.appraisers.squares += p * r * squared(mean - all_);
        out.repeats = {repeats_, p * o * (r - 1.0)};
        out.parts.freedom = p - 1.0;
        out.appraisers.freedom = o - 1.0;
        out.interaction.freedom = (p - 1.0) * (o - 1.0);
    }

  private:
    double cell(std::size_t part, std::size_t appraiser) const {
        double sum = 0.0;
        for (std::size_t k = 0; k < values_.trials(); ++k)
            sum += values_.at(part, appraiser, k);
        return sum / static_cast<double>(values_.trials());
    }
    const GaugeValues& values_;
    std::vector<double> of_part_, of_appraiser_;
    double all_ = 0.0, repeats_ = 0.0;
};

/// The repeats, with the interaction where it tells nothing of its own.
AnovaRow pool(GaugeComponents& out) {
    if (out.interaction.freedom <= 0.0) return out.repeats;
    const double error = out.repeats.mean();
    const boost::math::fisher_f none(out.interaction.freedom, out.repeats.freedom);
    if (error > 0.0) {
        out.interaction_p = boost::math::cdf(boost::math::complement(none, out.interaction.mean() / error));
    } else {
        out.interaction_p = out.interaction.mean() > 0.0 ? 0.0 : 1.0;
    }
    out.pooled = *out.interaction_p > pooled_above;
    if (!out.pooled) return out.repeats;
    return {out.repeats.squares + out.interaction.squares, out.repeats.freedom + out.interaction.freedom};
}

}  // namespace

GaugeComponents analyse_gauge(const GaugeValues& values) {
    assert(values.parts() > 0 && values.appraisers() > 0 && values.trials() > 1);
    GaugeComponents out;
    Squares(values).fill(out);
    const auto p = static_cast<double>(values.parts()), o = static_cast<double>(values.appraisers()),
               r = static_cast<double>(values.trials());
    const AnovaRow error = pool(out);
    const bool interacts = out.interaction.freedom > 0.0 && !out.pooled;
    const AnovaRow& under = interacts ? out.interaction : error;  // what parts and appraisers are held against
    out.repeatability = sum_of({{error, 1.0}}, error.mean());
    if (interacts) out.interacting = difference_of(out.interaction, error, r);
    if (values.appraisers() > 1) out.reproducibility = difference_of(out.appraisers, under, p * r);
    if (values.parts() > 1) out.part_variation = difference_of(out.parts, under, o * r);

    const double gauge =
        variance_of(out.repeatability) + variance_of(out.interacting) + variance_of(out.reproducibility);
    const double by_appraisers = values.appraisers() > 1 ? 1.0 / (p * r) : 0.0;
    const double by_parts = values.parts() > 1 ? 1.0 / (o * r) : 0.0;
    std::vector<Term> terms{{out.appraisers, by_appraisers}};
    if (interacts) {
        terms.push_back({error, 1.0 - 1.0 / r});
        terms.push_back({out.interaction, 1.0 / r - by_appraisers});
    } else {
        terms.push_back({error, 1.0 - by_appraisers});
    }
    out.gauge = sum_of(terms, gauge);
    if (values.parts() > 1) {
        terms.back().coefficient -= by_parts;
        terms.push_back({out.parts, by_parts});
        out.total = sum_of(terms, gauge + variance_of(out.part_variation));
    }
    return out;
}

std::optional<double> GaugeComponents::share_of_total() const {
    if (!total || total->deviation <= 0.0) return std::nullopt;
    return gauge.deviation / total->deviation;
}

std::optional<double> GaugeComponents::categories() const {
    if (!part_variation || gauge.deviation <= 0.0) return std::nullopt;
    return std::floor(1.41 * part_variation->deviation / gauge.deviation);
}

}  // namespace cmm::acquisition
