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
/// `Remainder`. The memory is kept between uses. W rows of nothing stand before the first and behind the last, so that
/// every row has as many neighbours.
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
        band_.assign(W + rows + W, Row{});
        border_.assign(bordered ? W + rows : 0, Border{});
    }

    std::size_t rows() const { return rows_; }
    /// From `rows()` on those ahead: of them only what couples to the rows before.
    Row& row(std::size_t i) { return band_[W + i]; }
    Border& border(std::size_t i) { return border_[W + i]; }

    /// What the rows take from the unknowns that stay: (border b, border c), (ahead a, ahead c), c not above, and
    /// (ahead a, border b).
    struct Remainder {
        Square border{}, ahead{}, across{};
    };

    /// False when a pivot is not positive (to rounding).
    bool eliminate(Remainder& remainder) {
        return bordered_ ? eliminate<true>(remainder) : eliminate<false>(remainder);
    }

    /// Values of the unknowns that stay; of rows, nearest first. A value has a number for each lane (or many: a
    /// vector).
    template <class Value>
    using Values = std::array<Value, W>;

    /// Forward substitution of a right-hand side that `load(i)` and `store(i, value)` reach; what the rows take from
    /// those ahead and from the border comes off `ahead` and `border`, which are zero before.
    template <class Value, class Load, class Store>
    void forward(const Load& load, const Store& store, Values<Value>& ahead, Values<Value>& border) const {
        Values<Value> last = ahead;
        for (std::size_t i = 0; i < rows_; ++i) {
            const Row& row = band_[W + i];
            Value value = load(i);
            for (std::size_t m = W; m > 0; --m)
                value -= row[m] * last[m - 1];
            const Value scaled = row[0] * value;
            if (bordered_)
                for (std::size_t b = 0; b < W; ++b)
                    border[b] -= border_[W + i][b] * scaled;
            store(i, scaled);
            push(last, value);
        }
        for (std::size_t a = 0; a < W; ++a)
            for (std::size_t k = a + 1; k <= W; ++k)
                ahead[a] -= band_[W + rows_ + a][k] * last[k - a - 1];
    }

    /// Back substitution from the solution ahead and in the border.
    template <class Value, class Load, class Store>
    void backward(const Load& load, const Store& store, const Values<Value>& ahead, const Values<Value>& border) const {
        Values<Value> next = ahead;
        for (std::size_t i = rows_; i-- > 0;) {
            Value value = load(i);
            if (bordered_) {
                const Border& own = border_[W + i];
                Value sum = own[0] * border[0];
                for (std::size_t b = 1; b < W; ++b)
                    sum += own[b] * border[b];
                value -= band_[W + i][0] * sum;
            }
            for (std::size_t m = W; m > 0; --m)
                value -= band_[W + i + m][m] * next[m - 1];
            store(i, value);
            push(next, value);
        }
    }

    /// The inverse at the unknowns that stay, as in `Remainder` (but whole squares).
    using Inverse = Remainder;

    /// The band of the inverse (Takahashi, Fagan, Chen 1973): then `inverse(i)` has the elements (i, i), ...,
    /// (i, i + W), ahead included, and `inverse_edge(i)` those with the border.
    void invert(const Inverse& stays) {
        inverse_.resize(rows_ + W);
        edges_.resize(bordered_ ? rows_ + W : 0);
        for (std::size_t a = 0; a < W; ++a) {
            inverse_[rows_ + a] = Row{};
            if (!bordered_) continue;
            for (std::size_t c = a; c < W; ++c)
                inverse_[rows_ + a][c - a] = stays.ahead[c][a];
            edges_[rows_ + a] = stays.across[a];
        }
        if (bordered_)
            invert_rows<true>(stays);
        else
            invert_rows<false>(stays);
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
    static void reduce(Row* row, std::size_t least, Row& u) {
        for (std::size_t k = W; k >= least; --k) {
            Lane sum = (*row)[k];
            for (std::size_t m = W; m > k; --m)
                sum -= u[m] * (*(row - k))[m - k];
            u[k] = sum;
            (*row)[k] = sum * (*(row - k))[0];
        }
    }

    template <bool Bordered>
    bool eliminate(Remainder& remainder) {
        Remainder taken = remainder;
        for (std::size_t i = W; i < W + rows_; ++i) {
            Row u{};
            reduce(&band_[i], 1, u);
            Row& row = band_[i];
            const Lane diagonal = row[0];
            Lane pivot = diagonal;
            for (std::size_t k = W; k > 0; --k)
                pivot -= u[k] * row[k];
            if (!positive(pivot, diagonal)) return false;
            row[0] = 1.0 / pivot;
            if constexpr (Bordered) {
                Border column = border_[i];
                for (std::size_t m = W; m > 0; --m)
                    for (std::size_t b = 0; b < W; ++b)
                        column[b] -= row[m] * border_[i - m][b];
                border_[i] = column;
                for (std::size_t b = 0; b < W; ++b) {
                    const Lane scaled = column[b] * row[0];
                    for (std::size_t c = 0; c <= b; ++c)
                        taken.border[b][c] += scaled * column[c];
                }
            }
        }
        if constexpr (Bordered)
            for (std::size_t a = 0; a < W; ++a)
                reduce_ahead(a, taken);
        remainder = taken;
        return true;
    }

    /// Row a of those ahead.
    void reduce_ahead(std::size_t a, Remainder& remainder) {
        Row u{};
        Row* const row = &band_[W + rows_ + a];
        reduce(row, a + 1, u);
        for (std::size_t k = a + 1; k <= W; ++k) {
            for (std::size_t c = 0; c <= a; ++c)
                remainder.ahead[a][c] += u[k] * band_[W + rows_ + c][k - (a - c)];
            for (std::size_t b = 0; b < W; ++b)
                remainder.across[a][b] += (*row)[k] * border_[W + rows_ + a - k][b];
        }
    }

    template <bool Bordered>
    void invert_rows(const Inverse& stays) {
        for (std::size_t i = rows_; i-- > 0;) {
            std::array<Lane, W + 1> l;  // column i of L
            for (std::size_t m = 1; m <= W; ++m)
                l[m] = band_[W + i + m][m];
            Row row{};
            Border share{};  // the border's part of it
            Lane diagonal = band_[W + i][0];
            if constexpr (Bordered) {
                Border edge{};
                for (std::size_t b = 0; b < W; ++b)
                    share[b] = border_[W + i][b] * diagonal;
                for (std::size_t c = 0; c < W; ++c)
                    for (std::size_t b = 0; b < W; ++b)
                        edge[b] -= share[c] * stays.border[c][b];
                for (std::size_t m = W; m > 0; --m)
                    for (std::size_t b = 0; b < W; ++b)
                        edge[b] -= l[m] * edges_[i + m][b];
                edges_[i] = edge;
                for (std::size_t b = 0; b < W; ++b)
                    diagonal -= share[b] * edge[b];
            }
            for (std::size_t j = W; j > 0; --j) {
                Lane sum{};
                if constexpr (Bordered)
                    for (std::size_t b = 0; b < W; ++b)
                        sum -= share[b] * edges_[i + j][b];
                for (std::size_t m = W; m > 0; --m)
                    sum -= l[m] * (m < j ? inverse_[i + m][j - m] : inverse_[i + j][m - j]);
                row[j] = sum;
                diagonal -= l[j] * sum;
            }
            row[0] = diagonal;
            inverse_[i] = row;
        }
    }

    std::size_t rows_ = 0;
    bool bordered_ = false;
    std::vector<Row> band_, inverse_;
    std::vector<Border> border_, edges_;
};

}  // namespace cmm::fitting
