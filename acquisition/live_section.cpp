// SPDX-License-Identifier: Apache-2.0
#include "acquisition/live_section.hpp"

#include <algorithm>
#include <cmath>

namespace cmm::acquisition {

LiveSection::LiveSection(const SectionSetup& setup, double lsb_mm, const core::PartFromMachine& part_from_machine,
                         std::size_t expected)
    : setup_(&setup),
      lsb_mm_(lsb_mm),
      part_from_machine_(part_from_machine),
      expected_(expected),
      watch_(setup, expected) {
    points_.reserve(expected > 0 ? expected : 2048);
}

void LiveSection::take(const RecordedPoint& point) {
    if (point.pass > 0) return take_again(point);
    if (!points_.empty() && point.sequence <= points_.back().sequence) return take_late(point);
    points_.push_back(point);
    length_mm_ += step_to(points_.size() - 1);
    count(point);
    follow(point);
    watch();
}

void LiveSection::take_again(const RecordedPoint& point) {
    const auto place =
        std::lower_bound(points_.begin(), points_.end(), point.sequence,
                         [](const RecordedPoint& known, std::uint64_t sequence) { return known.sequence < sequence; });
    if (place != points_.end() && place->sequence == point.sequence) return;
    if (point.verdict.reason == fitting::RejectReason::no_contact) ++no_contact_;
    points_.insert(place, point);
}

/// The place that later points hardly change any more, and the sample that was taken there.
void LiveSection::watch() {
    const auto place = curve_.point(fitting::LiveSpline::lag);
    if (!place.valid || points_.size() <= fitting::LiveSpline::lag) return;
    auto at = points_.end() - 1 - static_cast<std::ptrdiff_t>(fitting::LiveSpline::lag);
    if (at->sequence != place.sequence) {
        at = std::find_if(points_.begin(), points_.end(),
                          [&](const RecordedPoint& point) { return point.sequence == place.sequence; });
        if (at == points_.end()) return;
    }
    watch_.see(place, at->centre_mm.head<2>(), curve_.noise_mm());
}

void LiveSection::take_late(const RecordedPoint& point) {
    const auto place =
        std::lower_bound(points_.begin(), points_.end(), point.sequence,
                         [](const RecordedPoint& known, std::uint64_t sequence) { return known.sequence < sequence; });
    if (place->sequence == point.sequence) return;
    const auto index = static_cast<std::size_t>(place - points_.begin());
    length_mm_ -= step_to(index);
    points_.insert(place, point);
    length_mm_ += step_to(index) + step_to(index + 1);
    count(point);
    if (follow(point) != fitting::LiveSpline::Taken::stale) return;
    curve_ = fitting::LiveSpline(fitting::MaterialSide::left);
    for (const auto& known : points_)
        follow(known);
}

void LiveSection::count(const RecordedPoint& point) {
    if (point.verdict.reason == fitting::RejectReason::no_contact) {
        ++no_contact_;
    } else {
        judge(point.centre_mm.head<2>());
    }
}

fitting::LiveSpline::Taken LiveSection::follow(const RecordedPoint& point) {
    return curve_.add(point.sequence, point.centre_mm.head<2>(), point.verdict.reason != fitting::RejectReason::none);
}

double LiveSection::step_to(std::size_t index) const {
    if (index == 0 || points_[index].verdict.reason == fitting::RejectReason::no_contact) return 0.0;
    return (points_[index].centre_mm - points_[index - 1].centre_mm).norm();
}

void LiveSection::restore(const std::vector<RecordedPoint>& points) {
    for (const auto& point : points)
        take(point);
}

void LiveSection::add(std::span<const core::Sample> samples) {
    for (const auto& sample : samples) {
        RecordedPoint point;
        point.sequence = sample.sequence;
        point.flags = sample.flags;
        point.pass = pass_;
        point.centre_mm = part_from_machine_(core::Position<core::MachineFrame>{core::centre_mm(sample, lsb_mm_)}).mm;
        if ((sample.flags & core::sample_flag::no_contact) != 0)
            point.verdict.reason = fitting::RejectReason::no_contact;
        take(point);
        last_host_time_ = core::Duration(sample.host_time_ns);
        last_machine_time_s_ = static_cast<double>(sample.machine_time_us) * 1e-6;
    }
}

void LiveSection::judge(const Eigen::Vector2d& centre_mm) {
    if (!setup_->nominal) return;
    const auto foot = setup_->nominal->section.curve().closest(setup_->at_20_c(centre_mm), foot_hint_mm_);
    foot_hint_mm_ = foot.s_mm;
    recent_[judged_++ % recent_.size()] = foot.distance_mm - setup_->ball_radius_mm;
    if (judged_ < recent_.size()) return;
    auto window = recent_;
    std::nth_element(window.begin(), window.begin() + 3, window.end());
    if (!worst_mm_ || std::abs(window[3]) > std::abs(*worst_mm_)) worst_mm_ = window[3];
}

LiveSnapshot LiveSection::snapshot() const {
    LiveSnapshot now;
    now.points = points_.size();
    now.no_contact = no_contact_;
    now.length_mm = length_mm_;
    now.worst_deviation_mm = worst_mm_;
    if (points_.empty()) return now;
    now.state = complete() ? LiveSnapshot::State::closed : LiveSnapshot::State::open;
    now.last_mm = points_.back().centre_mm;
    now.curve = curve_.newest();
    now.noise_mm = curve_.noise_mm();
    if (points_.size() > 1) now.predicted = curve_.predict(step_to(points_.size() - 1));
    return now;
}

}  // namespace cmm::acquisition
