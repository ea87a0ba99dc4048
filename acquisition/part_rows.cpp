// SPDX-License-Identifier: Apache-2.0
#include "acquisition/part_rows.hpp"

#include <algorithm>
#include <limits>
#include <numeric>
#include <optional>
#include <string>
#include <utility>

#include "fitting/smoothing.hpp"
#include "fitting/surface_fit.hpp"
#include "fitting/surface_index.hpp"

namespace cmm::acquisition {
namespace {

using fitting::GapBridge, fitting::Surface, fitting::SurfaceRow, fitting::Zone;

constexpr std::size_t fewest_whole = 2;
/// Standard deviation of a place that other sections foretell: next to nothing beside a place of the contour.
constexpr double foretold_sigma_mm = 0.01;
/// Steps of the contour that differ by more are a crowd's and the wide one's beside it.
constexpr double least_share_of_step = 0.08;

/// The contour that was measured, in its order.
std::vector<Eigen::Vector2d> measured_points(const SectionResult& section) {
    std::vector<Eigen::Vector2d> points;
    for (const auto& point : section.fit->contour)
        if (point.measured) points.push_back(point.position_mm);
    return points;
}

/// Goes through the points that are kept, in the given order of their indices, and drops those that lie nearer to
/// the last than a fraction of the step before.
/// @param stays Points that are not dropped. From one to the next is a gap, whose width says nothing of the steps.
void keep_apart(const std::vector<Eigen::Vector2d>& points, const std::vector<char>& stays,
                const std::vector<std::size_t>& order, std::vector<char>& kept) {
    double before_mm = 0.0;
    for (std::size_t i = 1; i < points.size(); ++i)
        before_mm += (points[i] - points[i - 1]).norm() / static_cast<double>(points.size());
    std::optional<std::size_t> last;
    for (const std::size_t i : order) {
        if (kept[i] == 0) continue;
        const double step_mm = last ? (points[i] - points[*last]).norm() : before_mm;
        const bool over_a_gap = last && stays[i] != 0 && stays[*last] != 0;
        kept[i] = stays[i] != 0 || step_mm >= least_share_of_step * before_mm ? 1 : 0;
        if (kept[i] == 0) continue;
        if (!over_a_gap) before_mm = step_mm;
        last = i;
    }
}

/// Where the ball's way is nearly as bent as the ball its contacts crowd, and lie apart beside that: a curve through
/// the whole crowd would run wild there. The ends of gaps stay.
void thin_out(std::vector<Eigen::Vector2d>& points, std::vector<GapBridge>& bridges) {
    std::vector<char> stays(points.size(), 0), keeps(points.size(), 1);
    for (const GapBridge& bridge : bridges)
        stays[bridge.before] = stays[(bridge.before + 1) % points.size()] = 1;
    std::vector<std::size_t> order(points.size());
    std::iota(order.begin(), order.end(), 0);
    keep_apart(points, stays, order, keeps);
    std::reverse(order.begin(), order.end());
    keep_apart(points, stays, order, keeps);
    std::vector<Eigen::Vector2d> kept;
    std::vector<std::size_t> index;
    for (std::size_t i = 0; i < points.size(); ++i) {
        if (keeps[i] != 0) kept.push_back(points[i]);
        index.push_back(kept.size() - 1);
    }
    for (GapBridge& bridge : bridges)
        bridge.before = index[bridge.before];
    points = std::move(kept);
}

/// Over each gap the way of a surface at the section's height, moved evenly from what the gap's one end is off it to
/// what the other is. Points are counted as measured_points has them.
std::vector<GapBridge> bridges_along(const Surface& surface, const fitting::SurfaceIndex& index,
                                     const SectionResult& section) {
    const auto& contour = section.fit->contour;
    const double period = surface.u().back() - surface.u().front();
    const auto there = [&](double u) -> Eigen::Vector2d { return surface.position({u, section.z_mm}).head<2>(); };
    const auto place_of = [&](const Eigen::Vector2d& at) {
        return index.closest({at.x(), at.y(), section.z_mm}).place.u;
    };
    std::vector<GapBridge> bridges;
    for (const ContourGap& gap : section.gaps()) {
        const Eigen::Vector2d &from = contour[gap.before].position_mm, &to = contour[gap.behind].position_mm;
        const double begin = place_of(from), onwards = place_of(to) - begin;
        const double width = onwards < 0.0 ? onwards + period : onwards;
        const Eigen::Vector2d off_before = from - there(begin), off_behind = to - there(begin + width);
        const auto before = contour.begin() + static_cast<std::ptrdiff_t>(gap.before);
        const auto measured = std::count_if(contour.begin(), before, [](const auto& point) { return point.measured; });
        GapBridge bridge{static_cast<std::size_t>(measured), {}};
        const std::size_t steps = (gap.behind + contour.size() - gap.before) % contour.size();
        for (std::size_t i = 1; i < steps; ++i) {
            const double share = static_cast<double>(i) / static_cast<double>(steps);
            const Eigen::Vector2d off = (1.0 - share) * off_before + share * off_behind;
            bridge.points.push_back({there(begin + share * width) + off, foretold_sigma_mm});
        }
        bridges.push_back(std::move(bridge));
    }
    return bridges;
}

class RowMaker {
  public:
    explicit RowMaker(std::span<const SectionResult* const> sections) : sections_(sections), rows_(sections.size()) {}

    core::Result<std::vector<SurfaceRow>> run() {
        const auto whole = [](const SectionResult* section) { return section->gaps().empty(); };
        const auto known = static_cast<std::size_t>(std::count_if(sections_.begin(), sections_.end(), whole));
        for (std::size_t k = 0; k < sections_.size(); ++k) {
            if (known >= fewest_whole && !whole(sections_[k])) continue;
            if (auto status = make(k, contour_positions(*sections_[k]), {}); !status)
                return tl::unexpected(status.error());
        }
        for (auto next = reached(); !next.empty(); next = reached())
            if (auto status = bridge(next); !status) return tl::unexpected(status.error());
        std::vector<SurfaceRow> rows;
        for (auto& row : rows_)
            rows.push_back(std::move(*row));
        return rows;
    }

  private:
    /// Sections without a row that lie between others; when there are none, the next one below or above.
    std::vector<std::size_t> reached() const {
        const auto is_made = [](const auto& row) { return row.has_value(); };
        const auto first = static_cast<std::size_t>(std::find_if(rows_.begin(), rows_.end(), is_made) - rows_.begin());
        const auto end = rows_.size() -
                         static_cast<std::size_t>(std::find_if(rows_.rbegin(), rows_.rend(), is_made) - rows_.rbegin());
        std::vector<std::size_t> next;
        for (std::size_t k = first; k < end; ++k)
            if (!rows_[k]) next.push_back(k);
        if (next.empty() && first > 0) next.push_back(first - 1);
        if (next.empty() && end < rows_.size()) next.push_back(end);
        return next;
    }

    core::Status bridge(const std::vector<std::size_t>& next) {
        std::vector<SurfaceRow> known;
        for (const auto& row : rows_)
            if (row) known.push_back(*row);
        const double below = known.front().z_mm() - sections_[next.front()]->z_mm;
        const double above = sections_[next.back()]->z_mm - known.back().z_mm();
        fitting::SurfaceFitOptions options;
        options.beyond_mm = std::max({0.0, below, above});
        const auto fit = fitting::fit_surface(known, options);
        if (!fit) return tl::unexpected(fit.error());
        const fitting::SurfaceIndex index(fit->surface);
        for (const std::size_t k : next) {
            const SectionResult& section = *sections_[k];
            auto bridges = bridges_along(fit->surface, index, section);
            if (auto status = make(k, measured_points(section), std::move(bridges)); !status) return status;
        }
        return {};
    }

    core::Status make(std::size_t k, std::vector<Eigen::Vector2d> points, std::vector<GapBridge> bridges) {
        const SectionResult& section = *sections_[k];
        thin_out(points, bridges);
        auto curve = fitting::smooth_closed(points, bridges);
        auto row = curve ? SurfaceRow::make(std::move(*curve), section.z_mm, 0.0, nose_of(section, Zone::le),
                                            nose_of(section, Zone::te))
                         : core::Result<SurfaceRow>(tl::unexpected(curve.error()));
        if (!row) return tl::unexpected(std::move(row.error()).with_context("section " + section.name));
        rows_[k] = std::move(*row);
        return {};
    }

    /// Where it was not measured, that of the nearest section where it was.
    Eigen::Vector2d nose_of(const SectionResult& section, Zone edge) const {
        const SectionResult* nearest = &section;
        const auto away = [&](const SectionResult* other) {
            return other->nose_mm(edge) ? std::abs(other->z_mm - section.z_mm)
                                        : std::numeric_limits<double>::infinity();
        };
        for (const SectionResult* other : sections_)
            if (away(other) < away(nearest)) nearest = other;
        return edge == Zone::le ? nearest->fit->le_point_mm : nearest->fit->te_point_mm;
    }

    std::span<const SectionResult* const> sections_;
    std::vector<std::optional<SurfaceRow>> rows_;
};

}  // namespace

core::Result<std::vector<fitting::SurfaceRow>> part_rows(std::span<const SectionResult* const> sections) {
    return RowMaker(sections).run();
}

}  // namespace cmm::acquisition
