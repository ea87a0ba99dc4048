// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "fitting/bridge.hpp"
#include "fitting/outliers.hpp"
#include "fitting/spline_residual.hpp"

namespace cmm::fitting {

enum class PointState : std::uint8_t { good, accused, bad };

/// What the search for bad points thinks of each point of a chain, the local scatter, and the two tests that it goes
/// by: the four-neighbour test (seed 000, A8) and the prediction by all good neighbours. Indices of closed chains wrap.
class ChainState {
  public:
    static constexpr std::ptrdiff_t none = PTRDIFF_MAX;
    static constexpr double reject_factor = 5.0;   ///< of a prediction: bad
    static constexpr double suspect_factor = 3.5;  ///< times the standard deviation of a residual: looked at closely

    ChainState(std::span<const Vec2> points, bool closed, double floor_mm);

    bool closed() const { return closed_; }
    std::ptrdiff_t size() const { return n_; }
    bool exists(std::ptrdiff_t i) const { return closed_ || (i >= 0 && i < n_); }
    const Vec2& point(std::ptrdiff_t i) const { return points_[index(i)]; }
    PointState& state(std::ptrdiff_t i) { return state_[index(i)]; }
    PointState state(std::ptrdiff_t i) const { return state_[index(i)]; }
    /// Of the four-neighbour test, in standard deviations of a point.
    double ratio(std::ptrdiff_t i) const { return ratio_[index(i)]; }
    /// From the latest prediction that was noted, mm.
    double residual(std::ptrdiff_t i) const { return residual_[index(i)]; }
    /// Standard deviation of a point, so that the floor is never undercut.
    double sigma_at(std::ptrdiff_t i) const { return std::max(scatter_[block_of(i)], floor_ / reject_factor); }
    /// Of most points of the chain, so that the floor is never undercut.
    double least_sigma() const { return std::max(sigma_, floor_ / reject_factor); }
    /// Of the points there, and so many before and after it.
    double largest_sigma(std::ptrdiff_t i, std::ptrdiff_t by) const {
        double sigma = sigma_at(i);
        for (const std::ptrdiff_t there : {i - by, i + by})
            if (exists(there)) sigma = std::max(sigma, sigma_at(there));
        return sigma;
    }
    /// Where steps are not clearly longer than the noise, every so many-th point is a neighbour.
    std::ptrdiff_t stride(std::ptrdiff_t i) const { return stride_[block_of(i)]; }

    /// The next good point beyond `from`; none when there is none near. Points nearer to `from` than `apart_mm` are
    /// passed over, at most three of them.
    std::ptrdiff_t good_beyond(std::ptrdiff_t from, std::ptrdiff_t step, double apart_mm);
    /// The four-neighbour test of one point among the good ones.
    SplineResidual test(std::ptrdiff_t i);
    /// The same of all points from low to high that are not bad; their ratios are kept.
    void test(std::ptrdiff_t low, std::ptrdiff_t high);
    /// Whether that test makes it suspect now.
    bool stands_out(std::ptrdiff_t i) {
        const SplineResidual now = test(i);
        return std::abs(now.distance_mm) > suspect_factor * now.gain * sigma_at(i);
    }
    /// The prediction by all good neighbours.
    Verdict judge(std::ptrdiff_t i);
    void note(std::ptrdiff_t i, PointState now, const Verdict& verdict);
    void estimate_scatter();
    /// The strides, by the scatter; points whose stride is not one are tested again. False when there are none.
    bool set_strides();
    /// Whether the four-neighbour test or a sharp turn makes a point suspect. One that was settled stays so as long as
    /// the scatter has not become clearly smaller.
    bool suspicious(std::ptrdiff_t i) const;
    void settled(std::ptrdiff_t i) { settled_at_[index(i)] = sigma_at(i); }
    bool any_bad() const { return std::find(state_.begin(), state_.end(), PointState::bad) != state_.end(); }
    BadPoints report();

  private:
    static constexpr std::size_t block = 16;  // points that share their scatter and stride

    /// Nearly all indices need no wrapping, and a division costs more than all else here.
    std::ptrdiff_t wrapped(std::ptrdiff_t i) const {
        if (!closed_ || (i >= 0 && i < n_)) return i;
        return (i % n_ + n_) % n_;
    }
    std::size_t index(std::ptrdiff_t i) const { return static_cast<std::size_t>(wrapped(i)); }
    std::size_t block_of(std::ptrdiff_t i) const { return index(i) / block; }
    bool has_plain_neighbours(std::ptrdiff_t i) const;
    bool are_plain(std::ptrdiff_t i) const;
    double quantile(std::ptrdiff_t low, std::ptrdiff_t high, double q);
    Neighbours neighbours_of(std::ptrdiff_t i);

    std::span<const Vec2> points_;
    bool closed_;
    std::ptrdiff_t n_;
    double floor_, sigma_ = 0.0;
    std::vector<PointState> state_;
    std::vector<char> corner_;
    std::vector<double> residual_, threshold_, ratio_, gain_, work_;
    std::vector<double> settled_at_;      // the standard deviation at which a point was last judged
    std::vector<double> scatter_;         // by block: standard deviation of a point
    std::vector<std::ptrdiff_t> stride_;  // by block
};

}  // namespace cmm::fitting
