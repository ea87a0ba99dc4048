// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <utility>

#include "acquisition/contour_sampling.hpp"
#include "acquisition/nom_file.hpp"
#include "acquisition/nominal_kinds.hpp"
#include "acquisition/profile_starts.hpp"

namespace cmm::acquisition {
namespace {

using Eigen::Vector2d;

constexpr double at_section_mm = 1e-3;
constexpr double repeated_mm = 1e-6;

std::vector<Vector2d> outline_of(const NomSection& section) {
    std::vector<Vector2d> outline;
    outline.reserve(section.points_mm.size());
    for (const auto& point : section.points_mm)
        outline.emplace_back(point.head<2>());
    return outline;
}

/// Counter-clockwise, without a last point that repeats the first: as the loft has it, so that point k of both is one.
void put_in_order(NomSection& section) {
    auto& points = section.points_mm;
    while (points.size() > 1 && (points.front() - points.back()).norm() < repeated_mm) {
        points.pop_back();
        section.normals.pop_back();
        if (!section.tolerances.empty()) section.tolerances.pop_back();
    }
    if (signed_area(outline_of(section)) >= 0.0) return;
    std::reverse(points.begin(), points.end());
    std::reverse(section.normals.begin(), section.normals.end());
    std::reverse(section.tolerances.begin(), section.tolerances.end());
}

/// Of a closed polygon: the share of its length at each point.
std::vector<double> shares_of(const std::vector<Vector2d>& outline) {
    std::vector<double> share{0.0};
    for (std::size_t i = 0; i < outline.size(); ++i)
        share.push_back(share.back() + (outline[(i + 1) % outline.size()] - outline[i]).norm());
    const double total = share.back();
    share.pop_back();
    for (double& one : share)
        one /= total;
    return share;
}

double part_way(double a, double b, double w) {
    return (1.0 - w) * a + w * b;
}

PointTolerance part_way(const PointTolerance& a, const PointTolerance& b, double w) {
    return {part_way(a.below_mm, b.below_mm, w), part_way(a.above_mm, b.above_mm, w)};
}

std::optional<Vector2d> part_way(const std::optional<Vector2d>& a, const std::optional<Vector2d>& b, double w) {
    if (!a || !b) return std::nullopt;
    return Vector2d((1.0 - w) * *a + w * *b);
}

/// Of a section, from the place on where the contours of the loft begin: shares of its length, tolerances.
struct Column {
    std::vector<double> shares;
    std::vector<PointTolerance> tolerances;
};

std::vector<Column> columns_of(const std::vector<NomSection>& sections) {
    std::vector<std::vector<Vector2d>> outlines;
    std::transform(sections.begin(), sections.end(), std::back_inserter(outlines), outline_of);
    const auto starts = profile_starts(outlines);
    const auto begun = [](auto& row, std::size_t start) {
        if (!row.empty()) std::rotate(row.begin(), row.begin() + static_cast<std::ptrdiff_t>(start), row.end());
    };
    std::vector<Column> columns;
    for (std::size_t k = 0; k < sections.size(); ++k) {
        begun(outlines[k], starts.first[k]);
        columns.push_back({shares_of(outlines[k]), sections[k].tolerances});
        begun(columns.back().tolerances, starts.first[k]);
    }
    return columns;
}

class NomNominal final : public Nominal {
  public:
    /// Sections in ascending order, put in order; `lofted` of the same.
    NomNominal(std::vector<NomSection> sections, std::shared_ptr<const Nominal> lofted)
        : sections_(std::move(sections)), lofted_(std::move(lofted)) {
        const std::size_t n = sections_.front().points_mm.size();
        same_number_ = std::all_of(sections_.begin(), sections_.end(),
                                   [n](const NomSection& section) { return section.points_mm.size() == n; });
        if (same_number_) columns_ = columns_of(sections_);
    }

    core::Result<NominalContour> cut(double z_mm) const override {
        auto contour = lofted_->cut(z_mm);
        if (!contour) return contour;
        std::size_t above = 0;
        while (above < sections_.size() && sections_[above].z_mm < z_mm - at_section_mm)
            ++above;
        above = std::min(above, sections_.size() - 1);
        const NomSection& upper = sections_[above];
        if (above == 0 || upper.z_mm <= z_mm + at_section_mm) {
            contour->le_mm = upper.nose_mm;
            contour->te_mm = upper.tail_mm;
            if (!upper.skewed && contour->points.size() == upper.points_mm.size()) take_own(upper, *contour);
            return contour;
        }
        const NomSection& lower = sections_[above - 1];
        const double w = (z_mm - lower.z_mm) / (upper.z_mm - lower.z_mm);
        contour->le_mm = part_way(lower.nose_mm, upper.nose_mm, w);
        contour->te_mm = part_way(lower.tail_mm, upper.tail_mm, w);
        if (auto status = take_tolerances_between(above, w, *contour); !status) return tl::unexpected(status.error());
        return contour;
    }
    double z_low_mm() const override { return lofted_->z_low_mm(); }
    double z_high_mm() const override { return lofted_->z_high_mm(); }

  private:
    /// The file says the surface's normals at its own points.
    static void take_own(const NomSection& section, NominalContour& contour) {
        contour.tolerances = section.tolerances;
        contour.leans_rad.clear();
        contour.lean_rad = 0.0;
        for (const auto& normal : section.normals) {
            contour.leans_rad.push_back(std::asin(std::clamp(normal.z(), -1.0, 1.0)));
            contour.lean_rad = std::max(contour.lean_rad, std::abs(contour.leans_rad.back()));
        }
    }

    /// Linear in height between the points of one number, and in length along the contour.
    core::Status take_tolerances_between(std::size_t above, double w, NominalContour& contour) const {
        if (sections_[above - 1].tolerances.empty() || sections_[above].tolerances.empty()) return {};
        if (!same_number_) return several_numbers(above);
        const Column &lower = columns_[above - 1], &upper = columns_[above];
        const std::size_t n = lower.shares.size();
        const auto knot = [&](std::size_t i) { return i < n ? part_way(lower.shares[i], upper.shares[i], w) : 1.0; };
        const auto tolerance = [&](std::size_t i) {
            return part_way(lower.tolerances[i % n], upper.tolerances[i % n], w);
        };
        std::size_t i = 0;
        for (const double share : shares_of(contour.points)) {
            while (i + 1 < n && knot(i + 1) <= share)
                ++i;
            const double span = knot(i + 1) - knot(i);
            const double along = span > 0.0 ? std::clamp((share - knot(i)) / span, 0.0, 1.0) : 0.0;
            contour.tolerances.push_back(part_way(tolerance(i), tolerance(i + 1), along));
        }
        return {};
    }

    /// Only where all have one number of points does the loft join them point by point.
    core::Status several_numbers(std::size_t above) const {
        const NomSection& lower = sections_[above - 1];
        const std::size_t n = lower.points_mm.size();
        const auto other = std::find_if(sections_.begin(), sections_.end(),
                                        [n](const NomSection& section) { return section.points_mm.size() != n; });
        return core::fail(core::ErrorCode::plan_invalid,
                          "tolerances by point hold between sections " + lower.name + " and " + sections_[above].name +
                              " only where all sections have one number of points (" + std::to_string(n) +
                              ", section " + other->name + " " + std::to_string(other->points_mm.size()) +
                              "): measure at the heights of the sections");
    }

    std::vector<NomSection> sections_;
    std::vector<Column> columns_;  // where all sections have one number of points
    std::shared_ptr<const Nominal> lofted_;
    bool same_number_ = false;
};

}  // namespace

core::Result<std::shared_ptr<const Nominal>> nom_nominal(NomFile file) {
    std::stable_sort(file.sections.begin(), file.sections.end(),
                     [](const NomSection& a, const NomSection& b) { return a.z_mm < b.z_mm; });
    std::vector<PointSection> outlines;
    for (auto& section : file.sections) {
        put_in_order(section);
        outlines.push_back({section.name, section.points_mm, {}, {}});
    }
    auto lofted = sections_nominal(std::move(outlines), Span::z);
    if (!lofted) return lofted;
    return std::make_shared<const NomNominal>(std::move(file.sections), std::move(*lofted));
}

}  // namespace cmm::acquisition
