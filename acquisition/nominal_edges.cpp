// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "acquisition/nominal_kinds.hpp"

namespace cmm::acquisition {
namespace {

constexpr int heights = 9;  // at which the edges are compared

/// Where a nominal has its edges at a height.
struct Station {
    double z_mm;
    Eigen::Vector2d le_mm, te_mm;
};

class OneLeadingEdge final : public Nominal {
  public:
    OneLeadingEdge(std::shared_ptr<const Nominal> nominal, std::vector<Station> stations)
        : nominal_(std::move(nominal)), stations_(std::move(stations)) {}

    core::Result<NominalContour> cut(double z_mm) const override {
        auto contour = nominal_->cut(z_mm);
        if (!contour || contour->le_mm || contour->te_mm) return contour;
        const auto above = std::find_if(stations_.begin() + 1, stations_.end() - 1,
                                        [&](const Station& station) { return station.z_mm >= z_mm; });
        const Station &low = *(above - 1), &high = *above;
        const double share = std::clamp((z_mm - low.z_mm) / (high.z_mm - low.z_mm), 0.0, 1.0);
        contour->le_mm = (1.0 - share) * low.le_mm + share * high.le_mm;
        contour->te_mm = (1.0 - share) * low.te_mm + share * high.te_mm;
        return contour;
    }
    double z_low_mm() const override { return nominal_->z_low_mm(); }
    double z_high_mm() const override { return nominal_->z_high_mm(); }

  private:
    std::shared_ptr<const Nominal> nominal_;
    std::vector<Station> stations_;  // ascending; two or more
};

}  // namespace

std::shared_ptr<const Nominal> with_one_leading_edge(std::shared_ptr<const Nominal> nominal) {
    std::vector<Station> stations;
    double larger_mm = 0.0;  // the radius of what is called the LE, summed over the heights
    const double low_mm = nominal->z_low_mm(), height_mm = nominal->z_high_mm() - low_mm;
    if (!(height_mm > 0.0) || !std::isfinite(height_mm)) return nominal;
    for (int k = 0; k < heights; ++k) {
        const double z_mm = low_mm + height_mm * (k + 0.5) / heights;
        const auto contour = nominal->cut(z_mm);
        if (!contour) continue;
        if (contour->le_mm || contour->te_mm) return nominal;
        const auto section = fitting::analyse_nominal(contour->points);
        if (!section) continue;
        Station station{z_mm, section->le_point(), section->te_point()};
        double leads_mm = section->le_radius_mm() - section->te_radius_mm();
        if (!stations.empty()) {
            const Station& below = stations.back();
            const auto apart = [&](const Eigen::Vector2d& le, const Eigen::Vector2d& te) {
                return (le - below.le_mm).norm() + (te - below.te_mm).norm();
            };
            if (apart(station.te_mm, station.le_mm) < apart(station.le_mm, station.te_mm)) {
                std::swap(station.le_mm, station.te_mm);
                leads_mm = -leads_mm;
            }
        }
        larger_mm += leads_mm;
        stations.push_back(station);
    }
    if (stations.size() < 2) return nominal;
    if (larger_mm < 0.0)
        for (Station& station : stations)
            std::swap(station.le_mm, station.te_mm);
    return std::make_shared<OneLeadingEdge>(std::move(nominal), std::move(stations));
}

}  // namespace cmm::acquisition
