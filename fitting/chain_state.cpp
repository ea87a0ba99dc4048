// SPDX-License-Identifier: Apache-2.0
#include "fitting/chain_state.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "fitting/statistics.hpp"

namespace cmm::fitting {
namespace {

constexpr double texture_factor = 1.4;  // local over global scatter from which the local one counts
constexpr double sharp_turn_rad = 0.6;  // from chord to chord; a steep run turns so where the cubic goes astray
constexpr double base_share = 0.35;     // of the gap: slopes over a shorter base would only amplify noise
constexpr double stride_sigmas = 15.0;  // a step shorter than this has no direction
constexpr std::ptrdiff_t longest_stride = 16;
constexpr std::ptrdiff_t half_a_block = 8;

}  // namespace

ChainState::ChainState(std::span<const Vec2> points, bool closed, double floor)
    : points_(points), closed_(closed), n_(static_cast<std::ptrdiff_t>(points.size())), floor_(floor) {
    const std::size_t n = points.size();
    state_.assign(n, PointState::good);
    corner_.assign(n, 0);
    residual_.assign(n, 0.0);
    threshold_.assign(n, 0.0);
    ratio_.assign(n, 0.0);
    gain_.assign(n, 1.0);
    settled_at_.assign(n, 1e9);
    stride_.assign(n / block + 1, 1);
    scatter_.assign(n / block + 1, 0.0);
}

std::ptrdiff_t ChainState::good_beyond(std::ptrdiff_t from, std::ptrdiff_t step, double apart) {
    std::ptrdiff_t found = none;
    int passed = 0;
    for (std::ptrdiff_t at = from + step, walked = 0; walked < 24 && exists(at); at += step, ++walked) {
        if (state(at) != PointState::good) continue;
        found = at;
        if (apart <= 0.0 || (point(at) - point(from)).squaredNorm() >= apart * apart || ++passed > 3) break;
    }
    return found;
}

/// Whether the four neighbours of a point are good and well apart, as almost always.
bool ChainState::has_plain_neighbours(std::ptrdiff_t i) const {
    const std::ptrdiff_t step = stride(i);
    if (i < 2 * step || i + 2 * step >= n_) return false;
    const auto at = static_cast<std::size_t>(i), by = static_cast<std::size_t>(step);
    const bool good = state_[at - 2 * by] == PointState::good && state_[at - by] == PointState::good &&
                      state_[at + by] == PointState::good && state_[at + 2 * by] == PointState::good;
    const Vec2 &a = points_[at - 2 * by], &b = points_[at - by], &c = points_[at + by], &d = points_[at + 2 * by];
    const double least = base_share * base_share * (c - b).squaredNorm();
    return good && least > 0.0 && (b - a).squaredNorm() >= least && (d - c).squaredNorm() >= least;
}

SplineResidual ChainState::test(std::ptrdiff_t i) {
    const std::ptrdiff_t step = stride(i);
    if (has_plain_neighbours(i)) {
        return spline_residual(point(i - 2 * step), point(i - step), point(i + step), point(i + 2 * step), point(i));
    }
    const std::ptrdiff_t b = good_beyond(i, -step, 0.0), c = good_beyond(i, step, 0.0);
    if (b == none || c == none) return {};
    const double apart = base_share * (point(c) - point(b)).norm();
    const std::ptrdiff_t a = good_beyond(b, -step, apart), d = good_beyond(c, step, apart);
    if (a == none || d == none || (closed_ && d - a >= n_)) return {};
    return spline_residual(point(a), point(b), point(c), point(d), point(i));
}

void ChainState::test(std::ptrdiff_t low, std::ptrdiff_t high) {
    const auto keep = [this](std::ptrdiff_t i, const SplineResidual& found) {
        if (state(i) == PointState::bad) return;
        const std::size_t k = index(i);
        residual_[k] = found.distance_mm;
        gain_[k] = found.gain;
        threshold_[k] = 0.0;
        ratio_[k] = std::abs(found.distance_mm) / found.gain;
    };
    for (std::ptrdiff_t i = low; i <= high; ++i) {
        if (!exists(i)) continue;
        if (i >= 0 && i + 7 <= high && are_plain(i)) {
            const EightResiduals found = spline_residuals(&points_[static_cast<std::size_t>(i)], stride(i));
            for (std::ptrdiff_t k = 0; k < 8; ++k)
                keep(i + k, found[static_cast<std::size_t>(k)]);
            i += 7;
        } else if (state(i) != PointState::bad) {
            keep(i, test(i));
        }
    }
}

/// Whether eight points from `i` on have plain neighbours, all at the same stride.
bool ChainState::are_plain(std::ptrdiff_t i) const {
    if (i + 7 >= n_ || stride(i) != stride(i + 7)) return false;
    for (std::ptrdiff_t k = i; k < i + 8; ++k)
        if (!has_plain_neighbours(k)) return false;
    return true;
}

/// Of the good points' ratios from low up to high.
double ChainState::quantile(std::ptrdiff_t low, std::ptrdiff_t high, double q) {
    work_.resize(static_cast<std::size_t>(high - low));
    std::size_t good = 0;
    for (std::ptrdiff_t k = low; k < high; ++k) {
        if (!exists(k)) continue;
        work_[good] = ratio(k);
        good += state(k) == PointState::good;
    }
    if (good == 0) return 0.0;
    return nth_smallest(std::span(work_).first(good), static_cast<std::size_t>(q * static_cast<double>(good - 1)));
}

/// Four clean tenths are enough to see the noise among the residuals that each bad point spoils. Only where fewer
/// than four tenths are small is it worth while to look what the local scatter is.
void ChainState::estimate_scatter() {
    sigma_ = quantile(0, n_, 0.5) / 0.6745;
    const double small = texture_factor * 0.5244 * sigma_;
    const std::size_t blocks = scatter_.size();
    std::vector<std::size_t> all(blocks, 0), quiet(blocks, 0);
    for (std::size_t i = 0; i < points_.size(); ++i) {
        if (state_[i] != PointState::good) continue;
        ++all[i / block];
        quiet[i / block] += ratio_[i] <= small;
    }
    for (std::size_t k = 0; k < blocks; ++k) {
        const auto sum = [&](const std::vector<std::size_t>& counts) {
            const std::size_t before = k > 0 ? counts[k - 1] : (closed_ ? counts[blocks - 1] : 0);
            const std::size_t after = k + 1 < blocks ? counts[k + 1] : (closed_ ? counts[0] : 0);
            return before + counts[k] + after;
        };
        scatter_[k] = sigma_;
        if (10 * sum(quiet) >= 4 * sum(all)) continue;
        const auto low = static_cast<std::ptrdiff_t>(k * block), reach_out = static_cast<std::ptrdiff_t>(block);
        scatter_[k] = std::max(sigma_, quantile(low - reach_out, low + 2 * reach_out, 0.4) / 0.5244);
    }
}

bool ChainState::set_strides() {
    bool any = false;
    for (std::size_t k = 0; k < stride_.size(); ++k) {
        work_.clear();
        const auto low = static_cast<std::ptrdiff_t>(k * block);
        for (std::ptrdiff_t i = low; i < low + static_cast<std::ptrdiff_t>(block); ++i)
            if (exists(i) && exists(i + 1)) work_.push_back((point(i + 1) - point(i)).norm());
        // Where every step is long enough, as nearly everywhere, their median need not be known.
        const auto shortest = std::min_element(work_.begin(), work_.end());
        if (shortest == work_.end() || *shortest >= std::max(stride_sigmas * scatter_[k], 1e-9)) continue;
        const auto nth = work_.begin() + static_cast<std::ptrdiff_t>(work_.size() / 2);
        std::nth_element(work_.begin(), nth, work_.end());
        const double wanted = std::ceil(stride_sigmas * scatter_[k] / std::max(*nth, 1e-9));
        const auto most = static_cast<double>(std::clamp<std::ptrdiff_t>(n_ / 100, 1, longest_stride));
        stride_[k] = static_cast<std::ptrdiff_t>(std::clamp(wanted, 1.0, most));
        any = any || stride_[k] > 1;
    }
    for (std::size_t k = 0; any && k < stride_.size(); ++k) {
        const auto low = static_cast<std::ptrdiff_t>(k * block);
        if (stride_[k] > 1) test(low, std::min(low + static_cast<std::ptrdiff_t>(block), n_) - 1);
    }
    return any;
}

bool ChainState::suspicious(std::ptrdiff_t i) const {
    if (state_[index(i)] == PointState::bad || sigma_at(i) > 0.8 * settled_at_[index(i)]) return false;
    if (ratio(i) > suspect_factor * sigma_at(i)) return true;
    if (!exists(i - 1) || !exists(i + 1)) return false;
    const Vec2 in = point(i) - point(i - 1), out = point(i + 1) - point(i);
    if (std::abs(cross(in, out)) <= sharp_turn_rad * in.dot(out)) return false;
    const double shortest = std::sqrt(std::min(in.squaredNorm(), out.squaredNorm()));
    const double limit = sharp_turn_rad + 5.0 * 2.4 * sigma_at(i) / std::max(shortest, 1e-9);
    return limit < 3.0 && std::abs(cross(in, out)) > std::tan(std::min(limit, 1.5)) * in.dot(out);
}

Neighbours ChainState::neighbours_of(std::ptrdiff_t i) {
    Neighbours near;
    const std::ptrdiff_t step = stride(i);
    const auto collect = [&](std::ptrdiff_t direction, std::array<Vec2, Neighbours::most>& out, std::size_t& count) {
        std::ptrdiff_t since = step;  // the nearest one counts at once
        const std::ptrdiff_t walk = 24 + static_cast<std::ptrdiff_t>(Neighbours::most) * step;
        for (std::ptrdiff_t at = i + direction, walked = 0; walked < walk && exists(at) && count < out.size();
             at += direction, ++walked) {
            if (closed_ && std::abs(at - i) > n_ / 2) break;
            if (state(at) != PointState::good || ++since < step) continue;
            out[count++] = point(at);
            since = 0;
        }
    };
    collect(-1, near.before, near.count_before);
    collect(1, near.after, near.count_after);
    return near;
}

Verdict ChainState::judge(std::ptrdiff_t i) {
    return judge_point(neighbours_of(i), point(i), largest_sigma(i, half_a_block));
}

void ChainState::note(std::ptrdiff_t i, PointState now, const Verdict& verdict) {
    const std::size_t k = index(i);
    state_[k] = now;
    corner_[k] = static_cast<char>(now == PointState::good && verdict.corner);
    residual_[k] = verdict.residual_mm;
    threshold_[k] = reject_factor * verdict.sd_mm;
}

BadPoints ChainState::report() {
    BadPoints out;
    out.bad.resize(points_.size());
    for (std::size_t i = 0; i < points_.size(); ++i) {
        out.bad[i] = static_cast<char>(state_[i] == PointState::bad);
        out.count += state_[i] == PointState::bad;
        if (threshold_[i] <= 0.0) threshold_[i] = reject_factor * gain_[i] * sigma_at(static_cast<std::ptrdiff_t>(i));
    }
    out.corner = std::move(corner_);
    out.residual = std::move(residual_);
    out.threshold_mm = std::move(threshold_);
    out.sigma_mm = sigma_;
    return out;
}

}  // namespace cmm::fitting
