// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

namespace cmm::fitting {

/// What the points say of the curve's roughness at a knot.
struct KnotRoughness {
    double square = 0.0;  ///< of the curvature's second derivative by length, 1/mm^6
    double known = 0.0;   ///< the share of it that the points determine; 0 at joints
};

/// How rough a curve may be, knot by knot: the variance of a scaled jump x_k of the curvature's slope there. A jump is
/// taken from Student's distribution with a scale that varies slowly along the curve, so that flat sides become stiff
/// and single ends of arcs stay free. Estimated by maximum evidence: fixed-point updates of MacKay 1992 (Bayesian
/// interpolation, eq 4.8) with the scale mixture of West 1984. The memory is kept between uses.
class Roughness {
  public:
    /// Starts with `variance` for each knot. `window`: knots to either side that share a scale; `few` is the number of
    /// degrees of freedom of Student's distribution.
    void reset(const std::vector<double>& variance, std::size_t window, double few);

    /// The scale at each knot is known: it stays, and Student's distribution has `few` degrees of freedom. Nothing is
    /// held.
    void adopt(const std::vector<double>& variance, double few);
    bool held(std::size_t knot) const { return held_[knot] != 0; }

    const std::vector<double>& variance() const { return variance_; }

    /// Goes over to other knots: each takes what was known at the old knot that `from` names. What made the runs of
    /// `calm` (old knots) rough is gone: they and their neighbours become as calm as the curve before and behind.
    struct Run {
        std::size_t first = 0, last = 0;
    };
    void carry_over(const std::vector<std::size_t>& from, const std::vector<Run>& calm);
    /// The variance at a knot is given, and neither changes nor says anything of its neighbours. Infinite: any jump.
    void hold(std::size_t knot, double variance);

    /// One update. `jump` is the posterior mean of x_k, `told` the share of it that the points determine: one less its
    /// posterior variance over `variance`.
    void update(const std::vector<double>& jump, const std::vector<double>& told);

  private:
    /// Sums over 2 w + 1 knots, cyclic, in place.
    void sum_window(std::vector<double>& values, std::size_t w);

    /// `rough`: the logarithms of the scales before any run was calmed.
    void calm_down(const Run& run, const std::vector<double>& rough);
    void set_scale();
    void update_scale(const std::vector<double>& jump, const std::vector<double>& told);

    std::vector<double> variance_, log_scale_, scale_;
    std::vector<char> held_;
    std::vector<double> pull_, known_, sums_;
    std::size_t window_ = 2;
    double few_ = 0.3;
    bool scale_known_ = false;
};

}  // namespace cmm::fitting
