// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "acquisition/section_setup.hpp"
#include "fitting/live_spline.hpp"

namespace cmm::acquisition {

/// Where the part lies outside its tolerance, known before its section is complete.
struct Exceedance {
    fitting::Zone zone = fitting::Zone::suction;
    Eigen::Vector2d position_mm = Eigen::Vector2d::Zero();  ///< on the part
    double deviation_mm = 0.0;                              ///< signed, positive: too much material
    double guard_mm = 0.0;       ///< of the deviation: what noise may do, and what is no noise
    double limit_mm = 0.0;       ///< full width of the zone, as in the part file
    std::uint64_t sequence = 0;  ///< of the sample
};

/// Watches the smoothed places of a section while it is measured, and says when no other points could make it conform:
/// eleven neighbours in a row, all touched and none in doubt, lie on one side of the nominal beyond half the width of
/// their profile zone, each by more than its guard. The guard holds for all looks at a section together: k sigma, k by
/// Sidak (1967) so that of a part just within tolerance one in a thousand sections is called out at most (normal
/// noise), where there is too much material the error of the 2-D offset (A22), and what machine, probe and temperature
/// may do to all points alike, at the same risk, added. As at a jump of the curvature the
/// smoothed places can be farther off than they say, all of them together, the mean of the eleven samples themselves
/// has to lie out as well, by k of its own standard deviations. A bad point is no neighbour in the row, and runs of bad
/// points are shorter than it. Near the border of an edge the wider limit counts, because the measured edge may end
/// elsewhere than the nominal's; where one of the two carries no limit nothing is said. Nothing is said either of
/// profiles that are filtered, nor where the section or the blade is aligned: what lies out now may come in by it.
/// Constant time a place; one owner.
class ToleranceWatch {
  public:
    static constexpr std::size_t in_a_row = 11;

    /// `setup` outlives the watch. `expected` places are looked at (0: not known).
    ToleranceWatch(const SectionSetup& setup, std::size_t expected);
    /// Places in the order of measurement, each with the sample that was taken there; one that was seen already, or is
    /// not valid, changes nothing. `noise_mm`: standard deviation of a sample.
    void see(const fitting::LiveSpline::Point& place, const Eigen::Vector2d& centre_mm, double noise_mm);
    /// The farthest out of all that is certain.
    const std::optional<Exceedance>& exceedance() const { return worst_; }

  private:
    std::optional<double> limit_at(double s_mm) const;
    std::optional<double> limit_of(fitting::Zone zone) const;
    std::optional<Exceedance> look(const fitting::LiveSpline::Point& place);
    double machine_mm(const Eigen::Vector2d& position_mm, const Eigen::Vector2d& normal, double rise) const;
    bool samples_are_out(double noise_mm) const;

    const SectionSetup* setup_;
    double coverage_, shared_coverage_;
    std::uint64_t seen_ = 0;
    std::optional<double> near_mm_;
    std::size_t row_ = 0;
    bool outside_ = false;  // the row's side
    std::array<Exceedance, in_a_row> last_;
    std::array<double, in_a_row> excess_mm_{};  // of the samples, over the limit and the offset's error
    std::optional<Exceedance> worst_;
};

}  // namespace cmm::acquisition
