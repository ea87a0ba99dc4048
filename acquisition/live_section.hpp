// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "acquisition/section_setup.hpp"
#include "acquisition/tolerance_watch.hpp"
#include "core/clock.hpp"
#include "core/frame.hpp"
#include "core/sample.hpp"
#include "fitting/live_spline.hpp"

namespace cmm::acquisition {

/// What is known of a section at one moment. A value.
struct LiveSnapshot {
    enum class State { empty, open, closed };
    State state = State::empty;
    std::size_t points = 0;
    std::size_t no_contact = 0;
    double length_mm = 0.0;                             ///< travelled by the ball centre
    Eigen::Vector3d last_mm = Eigen::Vector3d::Zero();  ///< last ball centre, part frame
    std::optional<double>
        worst_deviation_mm;  ///< provisional, against the nominal: largest median of 7 neighbours, so that bad
                             ///< points and runs of three do not count; nothing before 7 points
    fitting::LiveSpline::Point curve;           ///< at the newest point; its curvature is positive where it is convex
    fitting::LiveSpline::Prediction predicted;  ///< the next point, when the step stays as it is
    double noise_mm = 0.0;                      ///< standard deviation of a point across the path, estimated
};

/// The section under the probe, fed sample by sample: keeps every point, knows how far it is and how it stands against
/// the nominal, and what its curve does next. `add` costs a constant time a sample. A sample that comes twice counts
/// once; one that comes late is put where its sequence belongs (linear in the section only when more than
/// LiveSpline::depth samples overtook it). Of the live values nothing enters the fit of the closed
/// section: that is made from `points` alone. Never throws, never blocks; one owner.
class LiveSection {
  public:
    /// `expected` points close the section (0: unknown until `close_after`). `setup` outlives the section.
    LiveSection(const SectionSetup& setup, double lsb_mm, const core::PartFromMachine& part_from_machine,
                std::size_t expected);

    void add(std::span<const core::Sample> samples);
    /// Points of an earlier path of this section (resume); before the first `add`.
    void restore(const std::vector<RecordedPoint>& points);
    /// For an unknown part: the number of points is known now.
    void close_after(std::size_t expected) { expected_ = expected; }
    /// The lap is done; so many points of a pass over stretches of it follow. They are kept, and no more: the live
    /// curve goes on along the lap only.
    void measure_again(std::uint8_t pass, std::size_t more) {
        pass_ = pass;
        expected_ = points_.size() + more;
    }
    bool complete() const { return expected_ > 0 && points_.size() >= expected_; }

    /// Points until it is complete; 0: it is, or nobody knows.
    std::size_t missing() const { return expected_ > points_.size() ? expected_ - points_.size() : 0; }

    LiveSnapshot snapshot() const;
    /// Out of tolerance for certain, whatever points come.
    const std::optional<Exceedance>& exceedance() const { return watch_.exceedance(); }
    const std::vector<RecordedPoint>& points() const { return points_; }
    const SectionSetup& setup() const { return *setup_; }
    /// Nothing when all points were restored.
    std::optional<core::Duration> last_sample_host_time() const { return last_host_time_; }
    double last_machine_time_s() const { return last_machine_time_s_; }

  private:
    void take(const RecordedPoint& point);
    void take_late(const RecordedPoint& point);
    void take_again(const RecordedPoint& point);
    void watch();
    void count(const RecordedPoint& point);
    fitting::LiveSpline::Taken follow(const RecordedPoint& point);
    double step_to(std::size_t index) const;
    void judge(const Eigen::Vector2d& centre_mm);

    const SectionSetup* setup_;
    double lsb_mm_;
    core::PartFromMachine part_from_machine_;
    std::size_t expected_;
    std::uint8_t pass_ = 0;
    std::vector<RecordedPoint> points_;
    fitting::LiveSpline curve_{fitting::MaterialSide::left};  // every path runs counter-clockwise
    std::size_t no_contact_ = 0;
    double length_mm_ = 0.0;
    std::optional<core::Duration> last_host_time_;
    double last_machine_time_s_ = 0.0;
    std::optional<double> foot_hint_mm_;
    std::array<double, 7> recent_{};
    std::size_t judged_ = 0;
    std::optional<double> worst_mm_;
    ToleranceWatch watch_;
};

}  // namespace cmm::acquisition
