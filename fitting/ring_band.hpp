// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "fitting/band_chain.hpp"

namespace cmm::fitting {

/// Symmetric positive definite matrix of half bandwidth W whose band goes round the end. Two groups of W neighbouring
/// unknowns part the ring into two chains, which are eliminated side by side in the lanes of a vector register: half
/// as many steps, each of which waits for the one before. Ring: chain of lane 0, first group, chain of lane 1, second
/// group; each group lies ahead of one chain and is the border behind the other. Needs n > 2 W.
template <int W>
class RingBand {
  public:
    using Row = std::array<double, W + 1>;  ///< half of a row of the band

    void reset(std::size_t n) {
        size_ = n;
        const std::size_t chained = n - 2 * W;
        spare_ = chained % 2;
        chain_.reset((chained + spare_) / 2, true);
        group_.setZero();
        // The shorter chain begins with a row that nothing depends on.
        if (spare_ != 0) chain_.row(0)[0][1] = 1.0;
    }

    std::size_t size() const { return size_; }

    /// Adds to A(i, j) and A(j, i); i and j are neighbours within W round the end.
    void add(std::size_t i, std::size_t j, double value) {
        Place a = place(i), b = place(j);
        if (a.grouped && b.grouped) {
            group_(static_cast<int>(std::max(a.at, b.at)), static_cast<int>(std::min(a.at, b.at))) += value;
            return;
        }
        if (a.grouped) std::swap(a, b);
        if (!b.grouped) {
            if (a.at < b.at) std::swap(a, b);
            chain_.row(a.at)[a.at - b.at][a.lane] += value;
        } else if (is_ahead(b, a.lane)) {
            const std::size_t row = chain_.rows() + b.at % W;
            chain_.row(row)[row - a.at][a.lane] += value;
        } else {
            chain_.border(a.at)[b.at % W][a.lane] += value;
        }
    }

    /// The lower half of a row: elements (i, i), (i, i - 1), ..., (i, i - W), round the beginning.
    void add_row(std::size_t i, const Row& row) {
        const Place self = place(i);
        if (!self.grouped && self.at >= W + spare_) {
            for (std::size_t k = 0; k <= W; ++k)
                chain_.row(self.at)[k][self.lane] += row[k];
            return;
        }
        for (std::size_t k = 0; k <= W; ++k)
            add(i, i >= k ? i - k : i + size_ - k, row[k]);
    }

    /// The lower triangle of W + 1 neighbouring unknowns from `first` on, round the end: block[a][c], c <= a.
    template <class Block>
    void add_block(std::size_t first, const Block& block) {
        const Place begin = place(first), end = place(first + W < size_ ? first + W : first + W - size_);
        if (!begin.grouped && !end.grouped && begin.lane == end.lane && begin.at + W == end.at) {
            for (std::size_t a = 0; a <= W; ++a)
                for (std::size_t c = 0; c <= a; ++c)
                    chain_.row(begin.at + a)[a - c][begin.lane] += block[a][c];
            return;
        }
        for (std::size_t a = 0; a <= W; ++a)
            for (std::size_t c = 0; c <= a; ++c)
                add((first + a) % size_, (first + c) % size_, block[a][c]);
    }

    /// False when the matrix is not positive definite (to rounding).
    bool factor() {
        typename Chain::Remainder taken;
        if (!chain_.eliminate(taken)) return false;
        // Lane 0 has the first group ahead and the second one behind, lane 1 the other way round.
        for (int a = 0; a < W; ++a)
            for (int c = 0; c < W; ++c) {
                const auto row = static_cast<std::size_t>(a), column = static_cast<std::size_t>(c);
                if (c <= a) {
                    group_(a, c) -= taken.ahead[row][column][0] + taken.border[row][column][1];
                    group_(W + a, W + c) -= taken.ahead[row][column][1] + taken.border[row][column][0];
                }
                group_(W + c, a) -= taken.across[row][column][0];
                group_(W + a, c) -= taken.across[row][column][1];
            }
        group_factor_.compute(group_);
        return group_factor_.info() == Eigen::Success;
    }

    /// Solves in place; `factor` has succeeded and rhs has size() entries.
    template <class Value>
    void solve(std::span<Value> rhs) const {
        if constexpr (std::is_same_v<Value, double>)
            solve_components(rhs.data(), 1);
        else
            for (int k = 0; k < Value::SizeAtCompileTime; ++k)
                solve_components(rhs.data()->data() + k, sizeof(Value) / sizeof(double));
    }

    /// The band of the inverse, O(n W^2); `factor` has succeeded. `inverse` keeps its memory.
    void invert(std::vector<Row>& inverse) {
        inverse.resize(size_);
        const Group stays = group_factor_.solve(Group::Identity());
        typename Chain::Inverse lanes;
        for (int a = 0; a < W; ++a)
            for (int c = 0; c < W; ++c) {
                const auto row = static_cast<std::size_t>(a), column = static_cast<std::size_t>(c);
                lanes.ahead[row][column] = Pair{stays(a, c), stays(W + a, W + c)};
                lanes.border[row][column] = Pair{stays(W + a, W + c), stays(a, c)};
                lanes.across[row][column] = Pair{stays(a, W + c), stays(W + a, c)};
            }
        chain_.invert(lanes);
        for (std::size_t i = 0; i < chain_.rows(); ++i)
            for (std::size_t m = 0; m <= W; ++m)
                inverse[i][m] = chain_.inverse(i)[m][0];
        for (std::size_t i = spare_; i < chain_.rows(); ++i)
            for (std::size_t m = 0; m <= W; ++m)
                inverse[second() + i][m] = chain_.inverse(i)[m][1];
        for (std::size_t p = 0; p < W; ++p)
            for (const std::size_t own : {chain_.rows() + p, size_ - W + p})
                for (std::size_t m = 0; m <= W; ++m) {
                    const Place self = place(own), other = place((own + m) % size_);
                    inverse[own][m] = other.grouped ? stays(static_cast<int>(self.at), static_cast<int>(other.at))
                                                    : chain_.inverse_edge(other.at)[p][other.lane];
                }
    }

    void forget_inverse() { chain_.forget_inverse(); }

  private:
    using Pair = double __attribute__((vector_size(16)));
    using Chain = BandChain<Pair, W>;
    using Group = Eigen::Matrix<double, 2 * W, 2 * W>;

    /// Where an unknown stands: row `at` of a lane, or number `at` of the grouped ones.
    struct Place {
        bool grouped;
        std::size_t lane, at;
    };
    Place place(std::size_t i) const {
        const std::size_t rows = chain_.rows();
        if (i < rows) return {false, 0, i};
        if (i < rows + W) return {true, 0, i - rows};
        if (i < size_ - W) return {false, 1, i - second()};
        return {true, 1, i - (size_ - 2 * W)};
    }
    static bool is_ahead(const Place& grouped, std::size_t lane) { return (grouped.at < W) == (lane == 0); }
    /// What row 0 of the second lane would have for an index.
    std::size_t second() const { return chain_.rows() + W - spare_; }

    void solve_components(double* rhs, std::size_t stride) const {
        double* const other = rhs + second() * stride;
        const std::size_t spare = spare_, rows = chain_.rows();
        const auto load = [=](std::size_t i) { return Pair{rhs[i * stride], i < spare ? 0.0 : other[i * stride]}; };
        const auto store = [=](std::size_t i, const Pair& value) {
            rhs[i * stride] = value[0];
            if (i >= spare) other[i * stride] = value[1];
        };
        std::array<Pair, W> ahead{}, border{};
        chain_.template forward<Pair>(load, store, ahead, border);
        Eigen::Matrix<double, 2 * W, 1> grouped;
        double* const first_group = rhs + rows * stride;
        double* const second_group = rhs + (size_ - W) * stride;
        for (int b = 0; b < W; ++b) {
            const auto k = static_cast<std::size_t>(b);
            grouped[b] = first_group[k * stride] + ahead[k][0] + border[k][1];
            grouped[W + b] = second_group[k * stride] + ahead[k][1] + border[k][0];
        }
        group_factor_.solveInPlace(grouped);
        for (int b = 0; b < W; ++b) {
            const auto k = static_cast<std::size_t>(b);
            first_group[k * stride] = grouped[b];
            second_group[k * stride] = grouped[W + b];
            ahead[k] = Pair{grouped[b], grouped[W + b]};
            border[k] = Pair{grouped[W + b], grouped[b]};
        }
        chain_.template backward<Pair>(load, store, ahead, border);
    }

    std::size_t size_ = 0, spare_ = 0;
    Chain chain_;
    Group group_ = Group::Zero();
    Eigen::LLT<Group> group_factor_{group_};  // one without a matrix has a state that a copy may not read
};

}  // namespace cmm::fitting
