// SPDX-License-Identifier: Apache-2.0
#include "fitting/surface_fit.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>
#include <utility>

#include "core/text.hpp"
#include "fitting/closest_point.hpp"
#include "fitting/column_smoother.hpp"
#include "fitting/curvature_joints.hpp"
#include "fitting/cyclic.hpp"
#include "fitting/knot_spacing.hpp"
#include "fitting/row_alignment.hpp"
#include "fitting/row_columns.hpp"
#include "fitting/row_frames.hpp"
#include "fitting/statistics.hpp"

namespace cmm::fitting {
namespace {

using core::ErrorCode;

constexpr std::size_t anchor_count = 2000, most_u_spans = 512;
/// Of the period: cubics through places farther apart are 0.05 um off the pressure side of a turbine between them.
constexpr double longest_span_share = 1.0 / 80.0;
constexpr double as_good_as_on_rows_mm = 1e-4;
constexpr int most_span_halvings = 5;
constexpr double joint_knot_share = 0.1;  // of a span: how near the two knots at a joint are
/// Weights that are tried; the last leaves hardly more than a cubic.
constexpr std::array<double, 10> weights{1e-6, 1e-3, 1e-2, 1e-1, 1.0, 1e1, 1e2, 1e3, 1e4, 1e5};
/// Of the columns that the places on the rows follow, and of how many columns one is asked for it.
constexpr std::array<double, 4> correction_weights{1.0, 1e1, 1e2, 1e3};
constexpr std::size_t columns_asked = 16;
/// Columns to either side that share a weight, as a share of all.
constexpr double window_share = 1.0 / 20.0;
constexpr double least_distance_mm = 1e-3;  // of rows
constexpr double surely_sigmas = 2.0;

tl::unexpected<core::Error> unusable(const std::string& why) {
    return core::fail(ErrorCode::fit_not_evaluable, "surface: " + why);
}

class RowsFitter {
  public:
    RowsFitter(std::span<const SurfaceRow> rows, const SurfaceFitOptions& options)
        : rows_(rows),
          options_(options),
          alignment_(features_of(rows)),
          smoother_(heights(rows), options.beyond_mm),
          frames_(rows.size()) {}

    core::Result<SurfaceFit> run() {
        place_knots();
        lay_out();
        sample();
        if (options_.through_rows) {
            follow_rows();
        } else {
            turn_with_part();
            correct();
        }
        find_normals();
        if (!options_.through_rows)
            strays_ =
                set_aside_strays(smoother_, heights(rows_), normals_, breaks_, window_of(columns_.size()), columns_);
        if (!choose_weights()) return unusable("singular across the rows");
        return assemble();
    }

  private:
    static std::vector<double> heights(std::span<const SurfaceRow> rows) {
        std::vector<double> z;
        for (const SurfaceRow& row : rows)
            z.push_back(row.z_mm());
        return z;
    }
    Vec2 on_row(std::size_t k, double u) const { return rows_[k].at(alignment_.arc_length(k, u)); }

    void place_knots() {
        const double period = alignment_.period();
        const std::size_t usual = usual_row(rows_);
        std::vector<double> u(anchor_count);
        std::vector<Vec2> anchors(anchor_count);
        for (std::size_t i = 0; i < anchor_count; ++i) {
            u[i] = period * static_cast<double>(i) / static_cast<double>(anchor_count);
            anchors[i] = on_row(usual, u[i]);
        }
        const std::vector<double> longest(anchor_count, longest_span_share * period);
        const auto plain = graded_knots(anchors, u, period, options_.span_turn_rad, most_u_spans, longest);
        breaks_ = breaks_with_joints(plain, alignment_.joints(), 2, joint_knot_share, joints_);
    }

    void lay_out() {
        const std::size_t n = breaks_.size() - 1, m = rows_.size();
        places_.assign(m, std::vector<double>(n));
        for (std::size_t k = 0; k < m; ++k)
            for (std::size_t i = 0; i < n; ++i)
                places_[k][i] = alignment_.arc_length(k, breaks_[i]);
        columns_.reset(n, m);
    }

    void sample() {
        for (std::size_t k = 0; k < places_.size(); ++k)
            for (std::size_t i = 0; i < columns_.size(); ++i)
                columns_.set(i, k, frames_.into(k, rows_[k].at(places_[k][i])));
    }

    /// From here on rows are seen from frames that turn with the part.
    void turn_with_part() {
        frames_ = RowFrames(heights(rows_), columns_);
        for (std::size_t k = 0; k < places_.size(); ++k)
            for (std::size_t i = 0; i < columns_.size(); ++i)
                columns_.set(i, k, frames_.into(k, columns_.at(i, k)));
    }

    /// Spans along which a row is farther from the cubics through its places than `as_good_as_on_rows_mm` are halved.
    void follow_rows() {
        std::vector<ClosestPointIndex> indices;
        for (const SurfaceRow& row : rows_)
            indices.emplace_back(row.smooth().curve);
        for (int round = 0; round < most_span_halvings; ++round) {
            const std::vector<char> off = spans_off_rows(indices);
            if (std::find(off.begin(), off.end(), 1) == off.end()) return;
            std::vector<double> finer;
            for (KnotCluster& joint : joints_)
                joint.first += static_cast<std::size_t>(std::count(off.begin(), off.begin() + joint.first, 1));
            for (std::size_t i = 0; i < off.size(); ++i) {
                finer.push_back(breaks_[i]);
                if (off[i] != 0) finer.push_back(0.5 * (breaks_[i] + breaks_[i + 1]));
            }
            finer.push_back(breaks_.back());
            breaks_ = std::move(finer);
            lay_out();
            sample();
        }
    }

    /// Looked at in the middle of each.
    std::vector<char> spans_off_rows(const std::vector<ClosestPointIndex>& rows) const {
        const std::size_t n = columns_.size();
        std::vector<char> off(n, 0);
        const auto axis = CubicAxis::on_breaks(breaks_, true);
        if (!axis) return off;
        const PeriodicInterpolation along(breaks_);
        std::vector<Vec2> places(n);
        for (std::size_t k = 0; k < rows.size(); ++k) {
            for (std::size_t i = 0; i < n; ++i)
                places[i] = columns_.at(i, k);
            const std::vector<Vec2> controls = along.controls(places);
            for (std::size_t i = 0; i < n; ++i) {
                const auto functions = axis->weights(i, 0.5 * (breaks_[i] + breaks_[i + 1])).value;
                Vec2 at = Vec2::Zero();
                for (std::size_t a = 0; a < 4; ++a)
                    at += functions[static_cast<int>(a)] * controls[cyclic(axis->first(i) + a, n)];
                if (rows[k].closest(at).squared > as_good_as_on_rows_mm * as_good_as_on_rows_mm) off[i] = 1;
            }
        }
        return off;
    }

    /// What the smooth columns of a four leave of it at a row.
    RowColumns::Four left_of(std::size_t four, std::size_t row) const {
        return columns_.fours()[four][row] - smoother_.at_row(row, controls_);
    }
    /// The same along the normals.
    Eigen::Array4d off_of(std::size_t four, std::size_t row) const {
        return (normals_.fours()[four][row] * left_of(four, row)).rowwise().sum();
    }
    /// Calls work(lane, column) for each column of a four.
    template <class Work>
    void for_columns_of(std::size_t four, const Work& work) const {
        for (std::size_t i = 4 * four; i < std::min(4 * four + 4, columns_.size()); ++i)
            work(static_cast<Eigen::Index>(i % 4), i);
    }

    /// Parameter correction (seed 001, B12-B13): the places slide along their rows to where smooth columns have them,
    /// so that what is left between a row and the columns is across the surface. A row whose places would pass each
    /// other keeps them. Not of rows that are results: smooth columns do not follow a part's own form, and where one
    /// row slides and the next does not the surface between them leaves it.
    void correct() {
        const std::size_t m = rows_.size();
        if (!smoother_.set_weight(correction_weight())) return;
        find_directions();
        std::vector<std::vector<double>> moved = places_;
        for (std::size_t b = 0; b < columns_.fours().size(); ++b) {
            smoother_.solve(columns_.fours()[b], controls_);
            for (std::size_t k = 0; k < m; ++k) {
                const RowColumns::Four left = left_of(b, k);
                for_columns_of(b, [&](Eigen::Index lane, std::size_t i) {
                    moved[k][i] -= directions_.at(i, k).dot(left.row(lane).matrix());
                });
            }
        }
        for (std::size_t k = 0; k < m; ++k) {
            const bool once_round = moved[k].back() < moved[k].front() + rows_[k].length_mm();
            if (once_round && std::is_sorted(moved[k].begin(), moved[k].end())) places_[k] = std::move(moved[k]);
        }
        sample();
    }

    /// The stiffer the columns, the less do they follow the scatter of the places; where the part is no cubic over z,
    /// stiff ones would miss its lowest and highest rows. By generalised cross-validation.
    double correction_weight() {
        double best = correction_weights.back(), least = std::numeric_limits<double>::infinity();
        for (const double weight : correction_weights) {
            const double free =
                smoother_.set_weight(weight) ? static_cast<double>(rows_.size()) - smoother_.freedom() : 0.0;
            if (free < 0.5) continue;
            double squares = 0.0;
            for (std::size_t b = 0; b < columns_.fours().size(); b += columns_asked / 4) {
                smoother_.solve(columns_.fours()[b], controls_);
                for (std::size_t k = 0; k < rows_.size(); ++k)
                    squares += left_of(b, k).square().sum();
            }
            const double score = squares / (free * free);
            if (score >= least) continue;
            least = score;
            best = weight;
        }
        return best;
    }

    /// Along the rows at the columns. On a row with a dent, whose flanks go elsewhere, as on those beside it: of its
    /// own and what two others have, or foretell at an end, each coordinate is the middle one (unless the differences
    /// of rows are the part's).
    void find_directions() {
        const std::size_t n = columns_.size(), m = rows_.size();
        directions_.reset(n, m);
        std::vector<Vec2> own(m);
        const auto middle = [](double a, double b, double c) {
            return std::max(std::min(a, b), std::min(std::max(a, b), c));
        };
        for (std::size_t i = 0; i < n; ++i) {
            for (std::size_t k = 0; k < m; ++k)
                own[k] = (columns_.at(cyclic(i + 1, n), k) - columns_.at(cyclic(i + n - 1, n), k)).normalized();
            for (std::size_t k = 0; k < m; ++k)
                directions_.set(i, k, own[k]);
            if (m < 3 || options_.through_rows) continue;
            const auto set_middle = [&](std::size_t k, const Vec2& one, const Vec2& other) {
                const Vec2& at = own[k];
                directions_.set(i, k, {middle(one.x(), at.x(), other.x()), middle(one.y(), at.y(), other.y())});
            };
            for (std::size_t k = 1; k + 1 < m; ++k)
                set_middle(k, own[k - 1], own[k + 1]);
            set_middle(0, own[1], 2.0 * own[1] - own[2]);
            set_middle(m - 1, own[m - 2], 2.0 * own[m - 2] - own[m - 3]);
        }
    }

    /// For the scatter: from the directions along and the neighbours across. Of the unit normal only what lies in the
    /// rows' plane, where all distances are.
    void find_normals() {
        const std::size_t n = columns_.size(), m = rows_.size();
        normals_.reset(n, m);
        find_directions();
        for (std::size_t i = 0; i < n; ++i)
            for (std::size_t k = 0; k < m; ++k) {
                const Vec2 along = directions_.at(i, k);
                const std::size_t above = std::min(k + 1, m - 1), below = k > 0 ? k - 1 : 0;
                const Vec2 across = frames_.turned_into(k, on_part(i, above) - on_part(i, below));
                const double rise = rows_[above].z_mm() - rows_[below].z_mm();
                const Vec3 normal = Vec3(along.y() * rise, -along.x() * rise, cross(along, across)).normalized();
                normals_.set(i, k, normal.head<2>());
            }
    }

    /// A column at a row, in the rows' own coordinates.
    Vec2 on_part(std::size_t column, std::size_t row) const { return frames_.out_of(row, columns_.at(column, row)); }

    /// Columns to either side that are looked at together.
    static std::size_t window_of(std::size_t columns) {
        return std::max<std::size_t>(1, static_cast<std::size_t>(window_share * static_cast<double>(columns)));
    }

    struct Score {
        std::vector<double> of_column;  // none: not to be had with so few rows
        double freedom = 0.0;
    };
    using Scores = std::array<Score, weights.size()>;

    /// Generalised cross-validation (Craven and Wahba 1979) over windows of columns.
    bool choose_weights() {
        const std::size_t n = columns_.size(), m = rows_.size();
        chosen_.assign(n, 0);
        std::vector<double> squares(n), kept(n, 0.0);
        Scores scores;
        const auto window = window_of(n);
        scatter_.standard_mm.assign(n, 0.0);
        scatter_.leverage.resize(weights.size());
        freedom_.assign(n, 0.0);
        for (std::size_t w = 0; w < weights.size(); ++w) {
            if (!smoother_.set_weight(weights[w])) continue;  // too little for so few rows
            if (options_.through_rows && freedom_[0] > 0.0) break;
            const double free = static_cast<double>(m) - smoother_.freedom();
            scores[w] = {std::vector<double>(n), smoother_.freedom()};
            for (std::size_t k = 0; k < m; ++k)
                scatter_.leverage[w].push_back(smoother_.leverage(k));
            for (std::size_t b = 0; b < columns_.fours().size(); ++b) {
                smoother_.solve(columns_.fours()[b], controls_);
                Eigen::Array4d sums = Eigen::Array4d::Zero();
                for (std::size_t k = 0; k < m; ++k)
                    sums += off_of(b, k).square();
                for_columns_of(b, [&](Eigen::Index lane, std::size_t i) { squares[i] = sums[lane]; });
            }
            for (std::size_t i = 0; i < n; ++i) {
                double sum = 0.0;
                for (std::size_t j = 0; j <= 2 * window; ++j)
                    sum += squares[cyclic(cyclic(i + n - window, n) + j, n)];
                const double score = free > 0.5 ? sum / (free * free) : std::numeric_limits<double>::infinity();
                scores[w].of_column[i] = score;
                if (freedom_[i] > 0.0 && !(score < scores[chosen_[i]].of_column[i])) continue;
                chosen_[i] = w;
                freedom_[i] = smoother_.freedom();
                kept[i] = squares[i] / std::max(free, 0.5);
                scatter_.standard_mm[i] = std::sqrt(sum / (static_cast<double>(2 * window + 1) * std::max(free, 0.5)));
            }
        }
        // Two columns that almost coincide are smoothed alike, or the surface would turn between them.
        for (const KnotCluster& joint : joints_) {
            chosen_[joint.first + 1] = chosen_[joint.first];
            freedom_[joint.first + 1] = freedom_[joint.first];
            scatter_.standard_mm[joint.first + 1] = scatter_.standard_mm[joint.first];
        }
        scatter_.weight = softest_as_good(scores);
        row_sigma_ = std::sqrt(std::accumulate(kept.begin(), kept.end(), 0.0) / static_cast<double>(n));
        return std::find(freedom_.begin(), freedom_.end(), 0.0) == freedom_.end();
    }

    /// How little columns may have to be smoothed, by what they scatter: the score of the softest weight is not surely
    /// more than the least. Of two fits of m values by f and f + d parameters the sums of squares differ by chance with
    /// a variance of 2 d, in those of a value.
    std::vector<std::size_t> softest_as_good(const Scores& scores) const {
        const auto m = static_cast<double>(rows_.size());
        double freedom_along = 0.0;
        for (const SurfaceRow& row : rows_)
            freedom_along += row.smooth().freedom / m;
        const double independent = std::max(1.0, 2.0 * window_share * freedom_along);  // columns in a window
        std::vector<std::size_t> softest = chosen_;
        for (std::size_t i = 0; i < softest.size(); ++i) {
            const Score& chosen = scores[chosen_[i]];
            const auto as_good = [&](const Score& softer) {
                if (softer.of_column.empty()) return false;
                const double by_chance =
                    std::sqrt(2.0 * (softer.freedom - chosen.freedom) / independent) / (m - chosen.freedom);
                return softer.of_column[i] <= chosen.of_column[i] * (1.0 + surely_sigmas * by_chance);
            };
            while (softest[i] > 0 && as_good(scores[softest[i] - 1]))
                --softest[i];
        }
        return softest;
    }

    /// Every column becomes what its weight makes of it at the rows, in the rows' own coordinates.
    void smooth_columns() {
        for (std::size_t w = 0; w < weights.size(); ++w) {
            if (std::find(chosen_.begin(), chosen_.end(), w) == chosen_.end()) continue;
            smoother_.set_weight(weights[w]);
            for (std::size_t b = 0; b < columns_.fours().size(); ++b) {
                bool any = false;
                for_columns_of(b, [&](Eigen::Index, std::size_t i) { any = any || chosen_[i] == w; });
                if (!any) continue;
                smoother_.solve(columns_.fours()[b], controls_);
                for (std::size_t k = 0; k < rows_.size(); ++k) {
                    const RowColumns::Four at_row = smoother_.at_row(k, controls_);
                    for_columns_of(b, [&](Eigen::Index lane, std::size_t i) {
                        if (chosen_[i] == w) columns_.set(i, k, frames_.out_of(k, at_row.row(lane).matrix()));
                    });
                }
            }
        }
    }

    core::Result<SurfaceFit> assemble() {
        const std::size_t n = columns_.size(), m = smoother_.axis().controls();
        std::vector<std::vector<Vec2>> across(m, std::vector<Vec2>(n));
        if (!options_.through_rows) smooth_columns();
        for (std::size_t w = 0; w < weights.size() && !smoother_.set_weight(weights[w]);)
            ++w;
        for (std::size_t b = 0; b < columns_.fours().size(); ++b) {
            smoother_.solve(columns_.fours()[b], controls_);
            for_columns_of(b, [&](Eigen::Index lane, std::size_t i) {
                for (std::size_t j = 0; j < m; ++j)
                    across[j][i] = controls_[j].row(lane).matrix();
            });
        }
        auto axis = CubicAxis::on_breaks(breaks_, true);
        if (!axis) return tl::unexpected(axis.error());
        std::vector<Vec3> controls(n * m);
        const PeriodicInterpolation along(breaks_);
        for (std::size_t j = 0; j < m; ++j) {
            const std::vector<Vec2> row = along.controls(across[j]);
            const double height = smoother_.axis().abscissa(j);  // so that z = v, to rounding
            for (std::size_t i = 0; i < n; ++i)
                controls[j * n + i] = {row[i].x(), row[i].y(), height};
        }
        auto surface = Surface::make(std::move(*axis), smoother_.axis(), std::move(controls));
        if (!surface) return tl::unexpected(surface.error());
        return SurfaceFit{std::move(*surface), std::move(freedom_), row_sigma_,
                          std::move(scatter_), std::move(strays_),  alignment_.joints()};
    }

    std::span<const SurfaceRow> rows_;
    const SurfaceFitOptions& options_;
    RowAlignment alignment_;
    ColumnSmoother smoother_;
    RowFrames frames_;
    std::vector<double> breaks_;
    std::vector<KnotCluster> joints_;
    std::vector<std::vector<double>> places_;  // arc lengths, by row, then by break
    RowColumns columns_, directions_, normals_;
    std::vector<std::size_t> chosen_;
    std::vector<double> freedom_;
    std::vector<Stray> strays_;
    std::vector<RowColumns::Four> controls_;
    double row_sigma_ = 0.0;
    RowScatter scatter_;
};

}  // namespace

core::Status check_rows(std::span<const SurfaceRow> rows) {
    for (std::size_t k = 1; k < rows.size(); ++k) {
        const SurfaceRow &below = rows[k - 1], &above = rows[k];
        const std::string name = "the row at z " + core::fixed(above.z_mm(), 3);
        if (std::abs(above.z_mm() - below.z_mm()) < least_distance_mm)
            return unusable(name + " is the one below again");
        if (above.z_mm() < below.z_mm()) return unusable(name + " lies below its predecessor: the rows cross");
        const double shorter = 0.5 * std::min(above.length_mm(), below.length_mm());
        if ((above.le() - below.le()).norm() > shorter || (above.te() - below.te()).norm() > shorter ||
            (above.te() - above.le()).dot(below.te() - below.le()) <= 0.0)
            return unusable(name + " does not continue the one below");
    }
    return {};
}

core::Result<SurfaceFit> fit_surface(std::span<const SurfaceRow> rows, const SurfaceFitOptions& options) {
    if (!(options.span_turn_rad > 0.0) || !(options.beyond_mm >= 0.0) || !std::isfinite(options.beyond_mm))
        return unusable("options out of range");
    if (rows.size() < 2) return unusable("needs 2 rows, got " + std::to_string(rows.size()));
    if (auto status = check_rows(rows); !status) return tl::unexpected(status.error());
    return RowsFitter(rows, options).run();
}

}  // namespace cmm::fitting
