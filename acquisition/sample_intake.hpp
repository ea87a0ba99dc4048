// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "acquisition/events.hpp"
#include "acquisition/journal.hpp"
#include "acquisition/live_section.hpp"
#include "drivers/machine.hpp"

namespace cmm::acquisition {

/// Where samples enter: first into the journal, then into the live section and whoever predicts the path, then into the
/// event stream. Runs on the machine's executor; costs a constant time a sample. Lives as long as the run.
class SampleIntake final : public drivers::SampleSink {
  public:
    /// Takes the samples of the section under the probe, in order (the predictor of an unknown part).
    using Follower = std::function<core::Status(const core::Sample&)>;
    /// The section has all its points; it is the receiver's now.
    using Completed = std::function<void(std::unique_ptr<LiveSection>)>;
    /// The section will be complete in about `left_ms`, at the pace of its points so far; asked once a section.
    using Nearing = std::function<void(const LiveSection&, double left_ms)>;

    SampleIntake(Journal& journal, EventHub& events) : journal_(journal), events_(events) {}

    /// From now on samples of `path` belong to `section`.
    void begin(std::uint16_t path, std::unique_ptr<LiveSection> section, Completed completed, Follower follower = {},
               Nearing nearing = {});
    /// Takes back a section that did not complete (nullptr when it did).
    std::unique_ptr<LiveSection> end();
    LiveSection* section() { return section_.get(); }
    std::uint64_t received() const { return received_; }

    core::Status on_samples(std::span<const core::Sample> samples) override;
    std::uint64_t durable_sequence() const noexcept override { return journal_.durable_sequence(); }
    core::Result<bool> hasten() override { return journal_.hasten(); }

  private:
    void emit_progress(bool force);
    void look_ahead();
    void tell_if_out();

    Journal& journal_;
    EventHub& events_;
    std::uint16_t path_ = 0;
    std::unique_ptr<LiveSection> section_;
    Completed completed_;
    Follower follower_;
    Nearing nearing_;
    std::size_t paced_from_ = 0;  // points at the first batch
    std::optional<std::int64_t> paced_from_ns_;
    bool told_out_ = false;
    std::uint64_t received_ = 0;
    std::size_t shown_points_ = 0;
    std::int64_t shown_at_ns_ = 0;
};

}  // namespace cmm::acquisition
