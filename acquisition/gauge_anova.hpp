// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

namespace cmm::acquisition {

/// Values of one characteristic: every part measured equally often by every appraiser. A value type.
class GaugeValues {
  public:
    GaugeValues(std::size_t parts, std::size_t appraisers, std::size_t trials)
        : parts_(parts), appraisers_(appraisers), trials_(trials), values_(parts * appraisers * trials, 0.0) {}
    double& at(std::size_t part, std::size_t appraiser, std::size_t trial) {
        return values_[place(part, appraiser, trial)];
    }
    double at(std::size_t part, std::size_t appraiser, std::size_t trial) const {
        return values_[place(part, appraiser, trial)];
    }
    std::size_t parts() const { return parts_; }
    std::size_t appraisers() const { return appraisers_; }
    std::size_t trials() const { return trials_; }

  private:
    std::size_t place(std::size_t part, std::size_t appraiser, std::size_t trial) const {
        return (part * appraisers_ + appraiser) * trials_ + trial;
    }
    std::size_t parts_, appraisers_, trials_;
    std::vector<double> values_;
};

/// A row of the table of variance.
struct AnovaRow {
    double squares = 0.0, freedom = 0.0;
    double mean() const { return freedom > 0.0 ? squares / freedom : 0.0; }
};

/// A standard deviation in the unit of the values, 0 where the estimate of its variance is negative, with its two-sided
/// 95 % interval.
struct GaugeComponent {
    double deviation = 0.0, low = 0.0, high = 0.0;
};

/// What makes measured values differ. Of one appraiser there is no reproducibility, of one part no part variation;
/// `total` wants parts.
struct GaugeComponents {
    AnovaRow parts, appraisers, interaction, repeats;
    std::optional<double> interaction_p;  ///< probability of an F as large without interaction; none: one of either
    bool pooled = false;                  ///< the interaction counts as repeatability
    GaugeComponent repeatability;         ///< EV
    std::optional<GaugeComponent> reproducibility, interacting, part_variation, total;  ///< AV, INT, PV, TV
    GaugeComponent gauge;                                                               ///< GRR: EV, AV and INT

    /// GRR as a share of the total variation. None: of one part, or nothing varies.
    std::optional<double> share_of_total() const;
    /// Six times GRR as a share of the width of a tolerance.
    double share_of_tolerance(double width) const { return 6.0 * gauge.deviation / width; }
    /// Distinct categories, floor(1.41 PV / GRR). None: of one part, or GRR is 0.
    std::optional<double> categories() const;
};

/// Random effects by the analysis of variance, crossed and balanced: AIAG, Measurement Systems Analysis, 4th edition
/// 2010, appendix A; the interaction is pooled with the repeats where its p is above 0.25. Intervals: chi-square for
/// one mean square, otherwise modified large samples (Graybill and Wang 1980 for sums, Ting et al. 1990 for
/// differences), as Burdick, Borror and Montgomery 2003, J. Quality Technology 35(4), sections 2 and 3. Needs two
/// trials; asserts.
GaugeComponents analyse_gauge(const GaugeValues& values);

}  // namespace cmm::acquisition
