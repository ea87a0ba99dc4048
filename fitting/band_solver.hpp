// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

#include "fitting/vec2.hpp"

namespace cmm::fitting {

/// Symmetric positive definite band matrix of half bandwidth W, open or cyclic, with plane vectors as right-hand side.
/// Cyclic: the last W unknowns are a border around a plain band (Schur complement), so the cost stays O(n W^2).
/// Value type, one owner. Cyclic matrices need n > 2 W.
template <int W>
class BandSolver {
  public:
    BandSolver(std::size_t n, bool cyclic)
        : n_(n), core_(cyclic ? n - W : n), band_(core_), border_(cyclic ? core_ : 0), corner_(Corner::Zero()) {
        for (auto& row : band_)
            row.fill(0.0);
        for (auto& row : border_)
            row.setZero();
    }

    /// Adds to A(i, j) and A(j, i); i and j are neighbours within W (round the end when cyclic).
    void add(std::size_t i, std::size_t j, double value) {
        if (i < j) std::swap(i, j);
        if (i < core_) {
            band_[i][i - j] += value;
        } else if (j < core_) {
            border_[j](static_cast<int>(i - core_)) += value;
        } else {
            const auto a = static_cast<int>(i - core_), b = static_cast<int>(j - core_);
            corner_(a, b) += value;
            if (a != b) corner_(b, a) += value;
        }
    }

    /// False when the matrix is not positive definite (to rounding).
    bool factor() {
        for (std::size_t i = 0; i < core_; ++i) {
            const std::size_t reach = std::min<std::size_t>(W, i);
            const double diagonal = band_[i][0];
            for (std::size_t k = reach; k > 0; --k) {
                double sum = band_[i][k];
                for (std::size_t m = k + 1; m <= reach; ++m)
                    sum -= band_[i][m] * band_[i - k][m - k];
                band_[i][k] = sum * band_[i - k][0];
            }
            double pivot = diagonal;
            for (std::size_t m = 1; m <= reach; ++m)
                pivot -= band_[i][m] * band_[i][m];
            if (!(pivot > 1e-13 * diagonal)) return false;
            band_[i][0] = 1.0 / std::sqrt(pivot);  // the inverse: divisions only here
        }
        if (border_.empty()) return true;
        folded_ = border_;
        substitute(folded_);
        Corner schur = corner_;
        for (std::size_t i = 0; i < core_; ++i)
            schur.noalias() -= border_[i] * folded_[i].transpose();
        schur_.compute(0.5 * (schur + schur.transpose().eval()));
        return schur_.info() == Eigen::Success;
    }

    /// Solves in place; `factor` has succeeded and rhs has n entries.
    void solve(std::vector<Vec2>& rhs) const {
        std::vector<Vec2> z(rhs.begin(), rhs.begin() + static_cast<std::ptrdiff_t>(core_));
        substitute(z);
        if (!border_.empty()) {
            Eigen::Matrix<double, W, 2> tail;
            for (int b = 0; b < W; ++b)
                tail.row(b) = rhs[core_ + static_cast<std::size_t>(b)].transpose();
            for (std::size_t i = 0; i < core_; ++i)
                tail.noalias() -= border_[i] * z[i].transpose();
            tail = schur_.solve(tail).eval();
            for (std::size_t i = 0; i < core_; ++i)
                z[i].noalias() -= tail.transpose() * folded_[i];
            for (int b = 0; b < W; ++b)
                rhs[core_ + static_cast<std::size_t>(b)] = tail.row(b).transpose();
        }
        std::copy(z.begin(), z.end(), rhs.begin());
    }

  private:
    using Corner = Eigen::Matrix<double, W, W>;

    template <class Vector>
    void substitute(std::vector<Vector>& v) const {
        for (std::size_t i = 0; i < core_; ++i) {
            for (std::size_t m = 1; m <= std::min<std::size_t>(W, i); ++m)
                v[i] -= band_[i][m] * v[i - m];
            v[i] *= band_[i][0];
        }
        for (std::size_t i = core_; i-- > 0;) {
            v[i] *= band_[i][0];
            for (std::size_t m = 1; m <= std::min<std::size_t>(W, i); ++m)
                v[i - m] -= band_[i][m] * v[i];
        }
    }

    std::size_t n_, core_;
    std::vector<std::array<double, W + 1>> band_;  // row i: A(i, i), A(i, i-1), ...; after factor() the Cholesky factor
    std::vector<Eigen::Matrix<double, W, 1>> border_, folded_;
    Corner corner_;
    Eigen::LLT<Corner> schur_;
};

}  // namespace cmm::fitting
