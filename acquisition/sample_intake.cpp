// SPDX-License-Identifier: Apache-2.0
#include "acquisition/sample_intake.hpp"

#include <utility>

#include "acquisition/event_payload.hpp"

namespace cmm::acquisition {
namespace {

// A section is shown again after so many points or so much time, whichever comes first.
constexpr std::size_t show_every_points = 64;
constexpr std::int64_t show_every_ns = 100'000'000;

constexpr double nearing_ms = 50.0;

}  // namespace

void SampleIntake::begin(std::uint16_t path, std::unique_ptr<LiveSection> section, Completed completed,
                         Follower follower, Nearing nearing) {
    path_ = path;
    section_ = std::move(section);
    completed_ = std::move(completed);
    follower_ = std::move(follower);
    nearing_ = std::move(nearing);
    paced_from_ns_.reset();
    told_out_ = false;
    shown_points_ = section_->points().size();
    shown_at_ns_ = 0;
}

std::unique_ptr<LiveSection> SampleIntake::end() {
    path_ = 0;
    follower_ = {};
    nearing_ = {};
    return std::move(section_);
}

core::Status SampleIntake::on_samples(std::span<const core::Sample> samples) {
    if (auto status = journal_.append(samples); !status) return status;
    received_ += samples.size();
    std::size_t first = 0;
    while (first < samples.size() && section_ != nullptr) {
        // Touches and what was left of another path go into the journal only.
        if (samples[first].path != path_ || !core::of_section(samples[first])) {
            ++first;
            continue;
        }
        std::size_t last = first;
        while (last < samples.size() && samples[last].path == path_ && core::of_section(samples[last])) {
            if (follower_) {
                if (auto status = follower_(samples[last]); !status) return status;
            }
            ++last;
        }
        const auto batch = samples.subspan(first, last - first);
        section_->add(batch);
        events_.emit(EventKind::sample_batch, section_->last_machine_time_s(),
                     batch_payload(section_->setup().index, batch.front().sequence, batch.size()));
        first = last;
        emit_progress(section_->complete());
        look_ahead();
        tell_if_out();
        if (section_->complete()) completed_(std::move(section_));
    }
    return {};
}

void SampleIntake::look_ahead() {
    const std::size_t points = section_->points().size(), missing = section_->missing();
    const std::int64_t now_ns = section_->last_sample_host_time()->count();
    if (!paced_from_ns_) {
        paced_from_ns_ = now_ns;
        paced_from_ = points;
    }
    if (!nearing_ || missing == 0 || points == paced_from_) return;
    const double point_ms =
        static_cast<double>(now_ns - *paced_from_ns_) * 1e-6 / static_cast<double>(points - paced_from_);
    const double left_ms = point_ms * static_cast<double>(missing);
    if (left_ms <= nearing_ms) std::exchange(nearing_, {})(*section_, left_ms);
}

void SampleIntake::tell_if_out() {
    if (told_out_ || !section_->exceedance()) return;
    told_out_ = true;
    events_.emit(EventKind::gate_decision, section_->last_machine_time_s(),
                 exceedance_payload(section_->setup().index, *section_->exceedance(),
                                    events_.age_ms(*section_->last_sample_host_time())));
}

void SampleIntake::emit_progress(bool force) {
    const std::size_t points = section_->points().size();
    const std::int64_t now_ns = section_->last_sample_host_time()->count();
    if (!force && points < shown_points_ + show_every_points && now_ns < shown_at_ns_ + show_every_ns) return;
    shown_points_ = points;
    shown_at_ns_ = now_ns;
    events_.emit(EventKind::section_updated, section_->last_machine_time_s(),
                 snapshot_payload(section_->setup().index, section_->snapshot()));
}

}  // namespace cmm::acquisition
