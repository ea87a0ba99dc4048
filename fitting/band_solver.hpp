// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "fitting/band_chain.hpp"
#include "fitting/ring_band.hpp"

namespace cmm::fitting {

/// Symmetric positive definite band matrix of half bandwidth W, open or cyclic, as L D L^T (no square roots, one
/// division a row). Right-hand sides: double or Eigen vectors. `reset` keeps the
/// memory, so a solver that is used again allocates nothing. Value type, one owner. Cyclic matrices need n > 2 W.
template <int W>
class BandSolver {
  public:
    /// The lower triangle of W + 1 neighbouring unknowns: block[a][c] belongs to (first + a, first + c), c <= a.
    using Block = std::array<std::array<double, W + 1>, W + 1>;
    /// Half of a row of the band.
    using Row = std::array<double, W + 1>;

    BandSolver() = default;
    BandSolver(std::size_t n, bool cyclic) { reset(n, cyclic); }

    /// All zero, of a new size.
    void reset(std::size_t n, bool cyclic) {
        cyclic_ = cyclic;
        if (cyclic)
            ring_.reset(n);
        else
            chain_.reset(n, false);
    }

    std::size_t size() const { return cyclic_ ? ring_.size() : chain_.rows(); }

    /// Adds to A(i, j) and A(j, i); i and j are neighbours within W (round the end when cyclic).
    void add(std::size_t i, std::size_t j, double value) {
        if (cyclic_) return ring_.add(i, j, value);
        if (i < j) std::swap(i, j);
        chain_.row(i)[i - j] += value;
    }

    /// The lower half of a row: elements (i, i), (i, i - 1), ..., (i, i - W), round the beginning when cyclic.
    void add_row(std::size_t i, const Row& row) {
        if (cyclic_) return ring_.add_row(i, row);
        for (std::size_t k = 0; k <= std::min<std::size_t>(W, i); ++k)
            chain_.row(i)[k] += row[k];
    }

    /// Adds what one span of a spline contributes; `first` + W may pass the end of a cyclic matrix.
    template <class Lower>
    void add_block(std::size_t first, const Lower& block) {
        if (cyclic_) return ring_.add_block(first, block);
        for (std::size_t a = 0; a <= W; ++a)
            for (std::size_t c = 0; c <= a; ++c)
                chain_.row(first + a)[a - c] += block[a][c];
    }

    /// False when the matrix is not positive definite (to rounding).
    bool factor() {
        if (cyclic_) return ring_.factor();
        typename BandChain<double, W>::Remainder none;
        return chain_.eliminate(none);
    }

    /// Solves in place; `factor` has succeeded and rhs has size() entries.
    template <class Value>
    void solve(std::span<Value> rhs) const {
        if (cyclic_) return ring_.solve(rhs);
        std::array<Value, W> none;
        if constexpr (std::is_same_v<Value, double>)
            none.fill(0.0);
        else
            none.fill(Value::Zero());
        const auto load = [rhs](std::size_t i) -> const Value& { return rhs[i]; };
        const auto store = [rhs](std::size_t i, const Value& value) { rhs[i] = value; };
        chain_.template forward<Value>(load, store, none, none);
        chain_.template backward<Value>(load, store, none, none);
    }

    /// The upper half of the band of the inverse, O(n W^2): elements (i, i), (i, i + 1), ..., (i, i + W), round the end
    /// when cyclic; `factor` has succeeded. `inverse` keeps its memory.
    void invert(std::vector<Row>& inverse) {
        if (cyclic_) return ring_.invert(inverse);
        inverse.resize(chain_.rows());
        chain_.invert({});
        for (std::size_t i = 0; i < inverse.size(); ++i)
            inverse[i] = chain_.inverse(i);
    }
    /// What `invert` needed: gives its memory back.
    void forget_inverse() {
        chain_.forget_inverse();
        ring_.forget_inverse();
    }

  private:
    bool cyclic_ = false;
    BandChain<double, W> chain_;
    RingBand<W> ring_;
};

}  // namespace cmm::fitting
