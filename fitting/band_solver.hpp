// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
#include <utility>
#include <vector>

namespace cmm::fitting {

/// Symmetric positive definite band matrix of half bandwidth W, open or cyclic, as L D L^T (no square roots, one
/// division a row). Cyclic: the last W unknowns are a border below a plain band, so the cost stays O(n W^2).
/// Right-hand sides are anything with + - and * by a number: double, Vec2, Vector3d. `reset` keeps the memory, so a
/// solver that is used again allocates nothing. Value type, one owner. Cyclic matrices need n > 2 W.
template <int W>
class BandSolver {
  public:
    /// The lower triangle of W + 1 neighbouring unknowns: block[a][c] belongs to (first + a, first + c), c <= a.
    using Block = std::array<std::array<double, W + 1>, W + 1>;

    BandSolver() = default;
    BandSolver(std::size_t n, bool cyclic) { reset(n, cyclic); }

    /// All zero, of a new size.
    void reset(std::size_t n, bool cyclic) {
        size_ = n;
        core_ = cyclic ? n - W : n;
        band_.assign(core_, Row{});
        border_.assign(cyclic ? core_ : 0, Border{});
        corner_.setZero();
    }

    std::size_t size() const { return size_; }

    /// Adds to A(i, j) and A(j, i); i and j are neighbours within W (round the end when cyclic).
    void add(std::size_t i, std::size_t j, double value) {
        if (i < j) std::swap(i, j);
        if (i < core_) {
            band_[i][i - j] += value;
        } else if (j < core_) {
            border_[j][i - core_] += value;
        } else {
            corner_(static_cast<int>(i - core_), static_cast<int>(j - core_)) += value;
        }
    }

    /// Adds what one span of a spline contributes; `first` + W may pass the end of a cyclic matrix.
    void add_block(std::size_t first, const Block& block) {
        const bool inside = first + W < core_;
        for (std::size_t a = 0; a <= W; ++a)
            for (std::size_t c = 0; c <= a; ++c)
                if (inside)
                    band_[first + a][a - c] += block[a][c];
                else
                    add((first + a) % size_, (first + c) % size_, block[a][c]);
    }

    /// False when the matrix is not positive definite (to rounding).
    bool factor() {
        const bool cyclic = !border_.empty();
        std::array<double, W + 1> u{};  // L(i, i-k) D(i-k)
        for (std::size_t i = 0; i < core_; ++i) {
            Row& row = band_[i];
            const std::size_t reach = std::min<std::size_t>(W, i);
            const double diagonal = row[0];
            double pivot = diagonal;
            for (std::size_t k = reach; k > 0; --k) {
                double sum = row[k];
                for (std::size_t m = reach; m > k; --m)
                    sum -= u[m] * band_[i - k][m - k];
                u[k] = sum;
                row[k] = sum * band_[i - k][0];
                pivot -= sum * row[k];
            }
            if (!(pivot > 1e-13 * diagonal)) return false;
            row[0] = 1.0 / pivot;
            if (cyclic) eliminate_border(i, reach);
        }
        if (!cyclic) return true;
        corner_factor_.compute(corner_);
        return corner_factor_.info() == Eigen::Success;
    }

    /// Solves in place; `factor` has succeeded and rhs has size() entries.
    template <class Value>
    void solve(std::span<Value> rhs) const {
        for (std::size_t i = 1; i < core_; ++i) {
            const std::size_t reach = std::min<std::size_t>(W, i);
            for (std::size_t m = reach; m > 0; --m)
                rhs[i] -= band_[i][m] * rhs[i - m];
        }
        if (!border_.empty()) solve_border(rhs);
        for (std::size_t i = 0; i < core_; ++i)
            rhs[i] *= band_[i][0];
        if (!border_.empty())
            for (std::size_t i = 0; i < core_; ++i)
                for (std::size_t b = 0; b < W; ++b)
                    rhs[i] -= band_[i][0] * border_[i][b] * rhs[core_ + b];
        for (std::size_t i = core_; i-- > 0;)
            for (std::size_t m = 1; m <= std::min<std::size_t>(W, i); ++m)
                rhs[i - m] -= band_[i][m] * rhs[i];
    }

    /// A row of the upper band: elements (i, i), (i, i + 1), ..., (i, i + W), round the end when cyclic.
    using Row = std::array<double, W + 1>;

    /// The band of the inverse (Takahashi, Fagan, Chen 1973), O(n W^2); `factor` has succeeded. `inverse` keeps its
    /// memory.
    void invert(std::vector<Row>& inverse) {
        inverse.assign(size_, Row{});
        const Corner corner =
            border_.empty() ? Corner(Corner::Zero()) : Corner(corner_factor_.solve(Corner::Identity()));
        across_.resize(border_.size());
        for (std::size_t i = core_; i-- > 0;)
            invert_row(i, corner, inverse);
        for (std::size_t p = 0; p < size_ - core_; ++p)
            for (std::size_t m = 0; m <= W; ++m) {
                const std::size_t j = core_ + p + m;
                inverse[core_ + p][m] =
                    j < size_ ? corner(static_cast<int>(p), static_cast<int>(j - core_)) : across_[j - size_][p];
            }
    }

  private:
    using Border = std::array<double, W>;
    using Corner = Eigen::Matrix<double, W, W>;

    /// Column i of the border becomes D(i) times its part of L; the corner loses the column's share.
    void eliminate_border(std::size_t i, std::size_t reach) {
        Border& column = border_[i];
        for (std::size_t m = reach; m > 0; --m)
            for (std::size_t b = 0; b < W; ++b)
                column[b] -= band_[i][m] * border_[i - m][b];
        for (std::size_t b = 0; b < W; ++b)
            for (std::size_t c = 0; c <= b; ++c)
                corner_(static_cast<int>(b), static_cast<int>(c)) -= column[b] * band_[i][0] * column[c];
    }

    /// Row i of the inverse from the rows after it; across_[i][b] is its element (i, core + b).
    void invert_row(std::size_t i, const Corner& corner, std::vector<Row>& inverse) {
        const std::size_t reach = std::min<std::size_t>(W, core_ - 1 - i);
        Row& row = inverse[i];
        Border edge{}, share{};  // share: the border's part of column i of L
        if (!border_.empty()) {
            for (std::size_t b = 0; b < W; ++b)
                share[b] = border_[i][b] * band_[i][0];
            for (std::size_t b = 0; b < W; ++b)
                for (std::size_t c = 0; c < W; ++c)
                    edge[b] -= share[c] * corner(static_cast<int>(b), static_cast<int>(c));
            for (std::size_t m = 1; m <= reach; ++m)
                for (std::size_t b = 0; b < W; ++b)
                    edge[b] -= band_[i + m][m] * across_[i + m][b];
            across_[i] = edge;
        }
        double diagonal = band_[i][0];
        for (std::size_t j = 1; j <= reach; ++j) {
            double sum = 0.0;
            for (std::size_t m = 1; m <= reach; ++m)
                sum -= band_[i + m][m] * (m < j ? inverse[i + m][j - m] : inverse[i + j][m - j]);
            if (!border_.empty())
                for (std::size_t b = 0; b < W; ++b)
                    sum -= share[b] * across_[i + j][b];
            row[j] = sum;
            diagonal -= band_[i + j][j] * sum;
        }
        if (!border_.empty())
            for (std::size_t b = 0; b < W; ++b) {
                diagonal -= share[b] * edge[b];
                if (i + W >= core_ + b) row[core_ + b - i] = edge[b];
            }
        row[0] = diagonal;
    }

    template <class Value>
    void solve_border(std::span<Value> rhs) const {
        for (std::size_t i = 0; i < core_; ++i)
            for (std::size_t b = 0; b < W; ++b)
                rhs[core_ + b] -= border_[i][b] * band_[i][0] * rhs[i];
        const auto& lower = corner_factor_.matrixLLT();
        for (int b = 0; b < W; ++b) {
            for (int c = 0; c < b; ++c)
                rhs[core_ + static_cast<std::size_t>(b)] -= lower(b, c) * rhs[core_ + static_cast<std::size_t>(c)];
            rhs[core_ + static_cast<std::size_t>(b)] *= 1.0 / lower(b, b);
        }
        for (int b = W; b-- > 0;) {
            for (int c = b + 1; c < W; ++c)
                rhs[core_ + static_cast<std::size_t>(b)] -= lower(c, b) * rhs[core_ + static_cast<std::size_t>(c)];
            rhs[core_ + static_cast<std::size_t>(b)] *= 1.0 / lower(b, b);
        }
    }

    std::size_t size_ = 0, core_ = 0;
    std::vector<Row> band_;       // row i: A(i, i), A(i, i-1), ...; after factor() 1/D(i), L(i, i-1), ...
    std::vector<Border> across_;  // of the inverse
    std::vector<Border> border_;  // column i: A(core + b, i); after factor() D(i) L(core + b, i)
    Corner corner_ = Corner::Zero();
    Eigen::LLT<Corner> corner_factor_;
};

}  // namespace cmm::fitting
