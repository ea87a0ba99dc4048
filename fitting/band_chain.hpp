// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

namespace cmm::fitting {

/// Symmetric band matrices of half bandwidth W, as many as `Lane` holds numbers (double: one; a vector type: several,
/// side by side), as L D L^T. The first rows are eliminated in order; up to W more, `ahead`, which only they reach,
/// are not, and neither is a border of W unknowns that every row may reach. What is eliminated comes off those:
/// `Remainder`. The memory is kept between uses.
template <class Lane, int W>
class BandChain {
  public:
    using Row = std::array<Lane, W + 1>;  ///< A(i, i), A(i, i-1), ...; eliminated: 1/D(i), L(i, i-1), ...
    using Border = std::array<Lane, W>;   ///< A(border b, i); eliminated: D(i) L(border b, i)
    using Square = std::array<std::array<Lane, W>, W>;

    /// All zero; `rows` to be eliminated.
    void reset(std::size_t rows, bool bordered) {
        rows_ = rows;
        bordered_ = bordered;
        band_.assign(bordered ? rows + W : rows, Row{});
        border_.assign(bordered ? rows : 0, Border{});
    }

    std::size_t rows() const { return rows_; }
    /// From `rows()` on those ahead: of them only what couples to the rows before.
    Row& row(std::size_t i) { return band_[i]; }
    Border& border(std::size_t i) { return border_[i]; }

    /// What the rows take from the unknowns that stay: (border b, border c), (ahead a, ahead c), c not above, and
    /// (ahead a, border b).
    struct Remainder {
        Square border{}, ahead{}, across{};
    };

    /// False when a pivot is not positive (to rounding).
    bool eliminate(Remainder& remainder) {
        for (std::size_t i = 0; i < rows_; ++i)
            if (!eliminate_row(i, remainder)) return false;
        if (bordered_)
            for (std::size_t a = 0; a < W; ++a)
                reduce_ahead(a, remainder);
        return true;
    }

    /// Values of the unknowns that stay; of rows, nearest first. A value has a number for each lane (or many: a
    /// vector).
    template <class Value>
    using Values = std::array<Value, W>;

    /// Forward substitution of a right-hand side that `load(i)` and `store(i, value)` reach; what the rows take from
    /// those ahead and from the border comes off `ahead` and `border`, which are zero before.
    template <class Value, class Load, class Store>
    void forward(const Load& load, const Store& store, Values<Value>& ahead, Values<Value>& border) const {
        Values<Value> last = ahead;  // so that it is something
        for (std::size_t i = 0; i < rows_; ++i) {
            Value value = load(i);
            const std::size_t reach = std::min<std::size_t>(W, i);
            for (std::size_t m = reach; m > 0; --m)
                value -= band_[i][m] * last[m - 1];
            const Value scaled = band_[i][0] * value;
            if (bordered_)
                for (std::size_t b = 0; b < W; ++b)
                    border[b] -= border_[i][b] * scaled;
            store(i, scaled);
            push(last, value);
        }
        if (bordered_)
            for (std::size_t a = 0; a < W; ++a)
                for (std::size_t k = a + 1; k <= std::min<std::size_t>(W, rows_ + a); ++k)
                    ahead[a] -= band_[rows_ + a][k] * last[k - a - 1];
    }

    /// Back substitution from the solution ahead and in the border.
    template <class Value, class Load, class Store>
    void backward(const Load& load, const Store& store, const Values<Value>& ahead, const Values<Value>& border) const {
        Values<Value> next = ahead;
        for (std::size_t i = rows_; i-- > 0;) {
            Value value = load(i);
            if (bordered_) {
                Value sum = border_[i][0] * border[0];
                for (std::size_t b = 1; b < W; ++b)
                    sum += border_[i][b] * border[b];
                value -= band_[i][0] * sum;
            }
            const std::size_t reach = bordered_ ? W : std::min<std::size_t>(W, rows_ - 1 - i);
            for (std::size_t m = reach; m > 0; --m)
                value -= band_[i + m][m] * next[m - 1];
            store(i, value);
            push(next, value);
        }
    }

    /// The inverse at the unknowns that stay, as in `Remainder` (but whole squares).
    using Inverse = Remainder;

    /// The band of the inverse (Takahashi, Fagan, Chen 1973): then `inverse(i)` has the elements (i, i), ...,
    /// (i, i + W), ahead included, and `inverse_edge(i)` those with the border.
    void invert(const Inverse& stays) {
        const std::size_t stored = bordered_ ? rows_ + W : rows_;
        inverse_.resize(stored);
        edges_.resize(bordered_ ? stored : 0);
        for (std::size_t a = 0; a < stored - rows_; ++a) {
            for (std::size_t c = a; c < W; ++c)
                inverse_[rows_ + a][c - a] = stays.ahead[c][a];
            edges_[rows_ + a] = stays.across[a];
        }
        for (std::size_t i = rows_; i-- > 0;)
            invert_row(i, stays);
    }
    const Row& inverse(std::size_t i) const { return inverse_[i]; }
    const Border& inverse_edge(std::size_t i) const { return edges_[i]; }
    /// Until the next `invert`: gives its memory back.
    void forget_inverse() {
        inverse_ = {};
        edges_ = {};
    }

  private:
    template <class Item>
    static void push(std::array<Item, W>& window, const Item& newest) {
        for (std::size_t k = W; k-- > 1;)
            window[k] = window[k - 1];
        window[0] = newest;
    }

    static bool positive(double pivot, double diagonal) { return pivot > 1e-13 * diagonal; }
    template <class Lanes>
    static bool positive(const Lanes& pivot, const Lanes& diagonal) {
        bool all = true;
        for (std::size_t k = 0; k < sizeof(Lanes) / sizeof(double); ++k)
            all = all && positive(pivot[k], diagonal[k]);
        return all;
    }

    /// L(i, i-k) D(i-k), k down to `least`, into `u`; row i of L into the row.
    void reduce(std::size_t i, std::size_t least, std::array<Lane, W + 1>& u) {
        Row& row = band_[i];
        const std::size_t reach = std::min<std::size_t>(W, i);
        for (std::size_t k = reach; k >= least; --k) {
            Lane sum = row[k];
            for (std::size_t m = reach; m > k; --m)
                sum -= u[m] * band_[i - k][m - k];
            u[k] = sum;
            row[k] = sum * band_[i - k][0];
        }
    }

    bool eliminate_row(std::size_t i, Remainder& remainder) {
        std::array<Lane, W + 1> u{};
        reduce(i, 1, u);
        Row& row = band_[i];
        const Lane diagonal = row[0];
        Lane pivot = diagonal;
        for (std::size_t k = std::min<std::size_t>(W, i); k > 0; --k)
            pivot -= u[k] * row[k];
        if (!positive(pivot, diagonal)) return false;
        row[0] = 1.0 / pivot;
        if (!bordered_) return true;
        Border column = border_[i];
        for (std::size_t m = std::min<std::size_t>(W, i); m > 0; --m)
            for (std::size_t b = 0; b < W; ++b)
                column[b] -= row[m] * border_[i - m][b];
        border_[i] = column;
        for (std::size_t b = 0; b < W; ++b) {
            const Lane scaled = column[b] * row[0];
            for (std::size_t c = 0; c <= b; ++c)
                remainder.border[b][c] += scaled * column[c];
        }
        return true;
    }

    /// Row a of those ahead. A row before it that does not exist (a short chain) has no share.
    void reduce_ahead(std::size_t a, Remainder& remainder) {
        std::array<Lane, W + 1> u{};
        const std::size_t i = rows_ + a, reach = std::min<std::size_t>(W, i);
        reduce(i, a + 1, u);
        for (std::size_t k = a + 1; k <= reach; ++k) {
            for (std::size_t c = 0; c <= a; ++c)
                remainder.ahead[a][c] += u[k] * band_[rows_ + c][k - (a - c)];
            for (std::size_t b = 0; b < W; ++b)
                remainder.across[a][b] += band_[i][k] * border_[i - k][b];
        }
    }

    void invert_row(std::size_t i, const Inverse& stays) {
        Row row{};
        Border share{};  // the border's part of column i of L
        const std::size_t reach = bordered_ ? W : std::min<std::size_t>(W, rows_ - 1 - i);
        if (bordered_) {
            Border edge{};
            for (std::size_t b = 0; b < W; ++b)
                share[b] = border_[i][b] * band_[i][0];
            for (std::size_t c = 0; c < W; ++c)
                for (std::size_t b = 0; b < W; ++b)
                    edge[b] -= share[c] * stays.border[c][b];
            for (std::size_t m = 1; m <= W; ++m)
                for (std::size_t b = 0; b < W; ++b)
                    edge[b] -= band_[i + m][m] * edges_[i + m][b];
            edges_[i] = edge;
        }
        Lane diagonal = band_[i][0];
        for (std::size_t j = 1; j <= reach; ++j) {
            Lane sum{};
            for (std::size_t m = 1; m <= reach; ++m)
                sum -= band_[i + m][m] * (m < j ? inverse_[i + m][j - m] : inverse_[i + j][m - j]);
            if (bordered_)
                for (std::size_t b = 0; b < W; ++b)
                    sum -= share[b] * edges_[i + j][b];
            row[j] = sum;
            diagonal -= band_[i + j][j] * sum;
        }
        if (bordered_)
            for (std::size_t b = 0; b < W; ++b)
                diagonal -= share[b] * edges_[i][b];
        row[0] = diagonal;
        inverse_[i] = row;
    }

    std::size_t rows_ = 0;
    bool bordered_ = false;
    std::vector<Row> band_, inverse_;
    std::vector<Border> border_, edges_;
};

}  // namespace cmm::fitting
