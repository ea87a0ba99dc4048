// SPDX-License-Identifier: Apache-2.0
#include "fitting/stray_rows.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <utility>

#include "fitting/column_smoother.hpp"
#include "fitting/cyclic.hpp"
#include "fitting/row_columns.hpp"
#include "fitting/statistics.hpp"

namespace cmm::fitting {
namespace {

constexpr std::size_t rows_to_stray = 6;  // one of so many may lie apart
constexpr double stray_weight = 1.0;      // of the columns that it lies apart from
constexpr double stray_sigmas = 8.0, least_stray_mm = 3e-3;
constexpr double seen_share = 0.5;      // of that, beside a stray
constexpr double least_freedom = 0.05;  // of a row: 1 less its leverage
constexpr double local_share = 0.15;    // of the columns: along more of them an end of the blade is otherwise
constexpr std::size_t next_rows = 6;    // that tell of the form over z
constexpr double form_factor = 5.0;     // how unevenly the form over z may differ from a cubic
constexpr double median_of_normal = 0.6745;

/// How far a smooth column that is no cubic over z may be off the cubic through the four rows nearest to one: least
/// between them, most at the lowest and the highest row, which are foretold from one side.
class FormOverRows {
  public:
    explicit FormOverRows(std::span<const double> z) : z_(z) {}

    /// By the fourth divided differences of the next rows above or below, whichever promise less; 0 where there are
    /// none.
    double off_cubic(const RowColumns& columns, std::size_t column, std::size_t k) const {
        double least = std::numeric_limits<double>::infinity();
        if (k + next_rows < z_.size())
            least = std::max(fourth_difference(columns, column, k + 1), fourth_difference(columns, column, k + 2));
        if (k >= next_rows)
            least = std::min(
                least, std::max(fourth_difference(columns, column, k - 5), fourth_difference(columns, column, k - 6)));
        return std::isfinite(least) ? least * reach(k) : 0.0;
    }

  private:
    double fourth_difference(const RowColumns& columns, std::size_t column, std::size_t first) const {
        Vec2 sum = Vec2::Zero();
        for (std::size_t a = first; a < first + 5; ++a) {
            double product = 1.0;
            for (std::size_t b = first; b < first + 5; ++b)
                if (b != a) product *= z_[a] - z_[b];
            sum += columns.at(column, a) / product;
        }
        return sum.norm();
    }
    double reach(std::size_t k) const {
        std::vector<double> distances;
        for (const double z : z_)
            distances.push_back(std::abs(z - z_[k]));
        std::partial_sort(distances.begin(), distances.begin() + 5, distances.end());
        return std::accumulate(distances.begin() + 1, distances.begin() + 5, 1.0, std::multiplies<>());
    }

    std::span<const double> z_;
};

class StrayRows {
  public:
    StrayRows(const ColumnSmoother& smoother, std::span<const double> z, const RowColumns& normals,
              std::span<const double> breaks, RowColumns& columns)
        : smoother_(smoother),
          form_(z),
          normals_(normals),
          breaks_(breaks),
          columns_(columns),
          rows_(columns.fours().front().size()),
          off_(columns.size(), std::vector<double>(rows_)),
          set_aside_(columns.size(), 0) {
        measure_all();
    }

    std::vector<Stray> set_aside(std::size_t window) {
        find_most(window);
        find_standing();
        for (std::size_t i = 0; i < columns_.size(); ++i)
            while (has_room(i)) {
                // What is less off than an end that stands may be so by its doing.
                const std::size_t k = worst_of(i);
                if (!strays(i, k, 1.0) || stands_[k] != 0) break;
                set_aside(i, k);
            }
        // It goes on into the columns beside, down to where it is hardly seen.
        for (std::size_t next = 0; next < found_.size(); ++next) {
            const auto [i, k] = found_[next];
            for (const std::size_t beside : {after(i), before(i)})
                if (has_room(beside) && strays(beside, k, seen_share)) set_aside(beside, k);
        }
        return std::move(strays_);
    }

  private:
    std::size_t after(std::size_t i) const { return cyclic(i + 1, columns_.size()); }
    std::size_t before(std::size_t i) const { return cyclic(i + columns_.size() - 1, columns_.size()); }
    bool has_room(std::size_t i) const { return set_aside_[i] < rows_ / rows_to_stray; }
    double freedom(std::size_t k) const { return std::max(1.0 - smoother_.leverage(k), least_freedom); }

    /// How far the rows are off, over their standard deviations if the scatter is 1.
    void measure(std::size_t four) {
        smoother_.solve(columns_.fours()[four], controls_);
        for (std::size_t k = 0; k < rows_; ++k) {
            const RowColumns::Four left = columns_.fours()[four][k] - smoother_.at_row(k, controls_);
            const Eigen::Array4d off = (normals_.fours()[four][k] * left).rowwise().sum() / std::sqrt(freedom(k));
            for (std::size_t i = 4 * four; i < std::min(4 * four + 4, columns_.size()); ++i)
                off_[i][k] = off[static_cast<Eigen::Index>(i - 4 * four)];
        }
    }
    void measure_all() {
        for (std::size_t four = 0; four < columns_.fours().size(); ++four)
            measure(four);
    }

    std::size_t worst_of(std::size_t i) const {
        const auto less = [](double a, double b) { return std::abs(a) < std::abs(b); };
        return static_cast<std::size_t>(std::max_element(off_[i].begin(), off_[i].end(), less) - off_[i].begin());
    }

    /// By more than a share of what the scatter allows, and the form of the part over z.
    bool strays(std::size_t i, std::size_t k, double share) const {
        const double off = std::abs(off_[i][k]);
        return off >= share * most_[i] && off >= share * most_by_form(i, k);
    }
    double most_by_form(std::size_t i, std::size_t k) const {
        return form_factor * form_.off_cubic(columns_, i, k) * std::sqrt(freedom(k));
    }

    /// Puts a row of a column where all others have it.
    void replace(std::size_t i, std::size_t k) {
        const Vec2 normal = normals_.at(i, k);
        const double off_mm = off_[i][k] / std::sqrt(freedom(k));
        columns_.set(i, k, columns_.at(i, k) - off_mm / normal.squaredNorm() * normal);
    }

    /// By the scatter in the columns about, each without its worst row: a dent covers whole windows of columns, which
    /// stand close where it is.
    void find_most(std::size_t window) {
        const std::size_t n = columns_.size();
        const RowColumns whole = columns_;
        std::vector<std::size_t> worst(n);
        for (std::size_t i = 0; i < n; ++i) {
            worst[i] = worst_of(i);
            replace(i, worst[i]);
        }
        const auto off = off_;
        measure_all();
        std::vector<double> median(n), near;
        for (std::size_t i = 0; i < n; ++i) {
            near.clear();
            for (std::size_t k = 0; k < rows_; ++k)
                if (k != worst[i]) near.push_back(std::abs(off_[i][k]));
            median[i] = nth_smallest(near, near.size() / 2);
        }
        most_.resize(n);
        for (std::size_t i = 0; i < n; ++i) {
            near.clear();
            for (std::size_t j = 0; j <= 2 * window; ++j)
                near.push_back(median[cyclic(cyclic(i + n - window, n) + j, n)]);
            most_[i] = std::max(stray_sigmas * nth_smallest(near, window) / median_of_normal, least_stray_mm);
        }
        columns_ = whole;
        off_ = off;
    }

    void find_standing() {
        const std::size_t n = columns_.size();
        std::vector<std::size_t> columns_off(rows_, 0);
        for (std::size_t i = 0; i < n; ++i)
            if (const std::size_t k = worst_of(i); std::abs(off_[i][k]) >= seen_share * most_[i]) ++columns_off[k];
        stands_.assign(rows_, 0);
        const auto most_columns = static_cast<std::size_t>(local_share * static_cast<double>(n));
        for (const std::size_t end : {std::size_t{0}, rows_ - 1})
            stands_[end] = static_cast<char>(columns_off[end] > most_columns);
    }

    void set_aside(std::size_t i, std::size_t k) {
        const Vec2 place = columns_.at(i, k);
        const double reach =
            std::max((columns_.at(after(i), k) - place).norm(), (columns_.at(before(i), k) - place).norm());
        strays_.push_back({k, breaks_[i], reach, std::max(most_[i], most_by_form(i, k))});
        found_.emplace_back(i, k);
        replace(i, k);
        ++set_aside_[i];
        measure(i / 4);
    }

    const ColumnSmoother& smoother_;
    FormOverRows form_;
    const RowColumns& normals_;
    std::span<const double> breaks_;
    RowColumns& columns_;
    std::size_t rows_;
    std::vector<std::vector<double>> off_;  // by column, then by row
    std::vector<std::size_t> set_aside_;    // of each column
    std::vector<double> most_;              // by column: what is farther off strays
    std::vector<char> stands_;              // by row
    std::vector<std::pair<std::size_t, std::size_t>> found_;
    std::vector<Stray> strays_;
    std::vector<RowColumns::Four> controls_;
};

}  // namespace

std::vector<Stray> set_aside_strays(ColumnSmoother& smoother, std::span<const double> z, const RowColumns& normals,
                                    std::span<const double> breaks, std::size_t window, RowColumns& columns) {
    if (columns.fours().empty() || columns.fours().front().size() < rows_to_stray || !smoother.set_weight(stray_weight))
        return {};
    return StrayRows(smoother, z, normals, breaks, columns).set_aside(window);
}

}  // namespace cmm::fitting
