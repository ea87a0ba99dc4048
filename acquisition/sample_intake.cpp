// SPDX-License-Identifier: Apache-2.0
#include "acquisition/sample_intake.hpp"

#include <utility>

#include "acquisition/event_payload.hpp"

namespace cmm::acquisition {
namespace {

// A section is shown again after so many points or so much time, whichever comes first.
constexpr std::size_t show_every_points = 64;
constexpr std::int64_t show_every_ns = 100'000'000;

}  // namespace

void SampleIntake::begin(std::uint16_t path, std::unique_ptr<LiveSection> section, Completed completed,
                         Follower follower) {
    path_ = path;
    section_ = std::move(section);
    completed_ = std::move(completed);
    follower_ = std::move(follower);
    shown_points_ = section_->points().size();
    shown_at_ns_ = 0;
}

std::unique_ptr<LiveSection> SampleIntake::end() {
    path_ = 0;
    follower_ = {};
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
        if (section_->complete()) completed_(std::move(section_));
    }
    return {};
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
