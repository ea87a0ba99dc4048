// SPDX-License-Identifier: Apache-2.0
// The part of a scan job on a machine that a person moves: what is asked of the person, and when a section has ended.
#include <cmath>
#include <utility>

#include "acquisition/hand_lap.hpp"
#include "acquisition/json_text.hpp"
#include "acquisition/scan_job.hpp"
#include "core/text.hpp"

namespace cmm::acquisition {
namespace {

/// Between the machine and the intake: keeps points of other heights apart, shows lines that mean nothing.
class HandIntake final : public drivers::HandSink {
  public:
    struct Section {
        std::size_t index;
        double z_mm, tolerance_mm, lsb_mm;
    };
    using Notice = std::function<void(const std::string&)>;
    HandIntake(SampleIntake& intake, EventHub& events, Section section, Notice notice)
        : intake_(intake), events_(events), section_(section), notice_(std::move(notice)) {}

    core::Status on_samples(std::span<const core::Sample> samples) override {
        for (core::Sample sample : samples) {
            const double off_mm = core::centre_mm(sample, section_.lsb_mm).z() - section_.z_mm;
            if (std::abs(off_mm) > section_.tolerance_mm) {
                sample.flags |= core::sample_flag::apart;
                notice_("point " + std::to_string(sample.sequence) + " lies " + core::fixed(off_mm, 3) +
                        " mm off the height of " + section_text(section_.index, section_.z_mm) + ": kept, not used");
            }
            if (auto taken = intake_.on_samples(std::span(&sample, 1)); !taken) return taken;
        }
        return {};
    }
    std::uint64_t durable_sequence() const noexcept override { return intake_.durable_sequence(); }
    core::Result<bool> hasten() override { return intake_.hasten(); }
    void on_garbled(std::string_view line, std::string_view why) override {
        ++garbled_;
        const std::string text = printable(line);
        events_.emit(EventKind::line_garbled, 0.0,
                     JsonFields()
                         .add("section", section_.index)
                         .add("line", text)
                         .add("why", why)
                         .add("count", garbled_)
                         .text());
        notice_("line not understood, the " + std::to_string(garbled_) + ". of this section: \"" + text + "\" (" +
                std::string(why) + ")");
    }

  private:
    /// A foreign line on the terminal and in JSON: plain ASCII.
    static std::string printable(std::string_view line) {
        std::string text;
        for (const char c : line.substr(0, 80))
            text += c >= ' ' && c <= '~' ? c : '?';
        return text;
    }

    SampleIntake& intake_;
    EventHub& events_;
    Section section_;
    Notice notice_;
    std::size_t garbled_ = 0;
};

}  // namespace

ScanJob::Step ScanJob::scan_by_hand(drivers::ScanPath path) {
    const double z_mm = setups_[section_].z_mm;
    notice(section_text(section_, z_mm) +
           ": take its points counter-clockwise; it ends when the start is passed, or by the word of a person");
    HandLap lap;
    for (const auto& point : restored_[section_])
        lap.add(point.centre_mm.head<2>());
    SampleIntake::Completed completed = [this](std::unique_ptr<LiveSection> section) {
        section_completed(std::move(section));
    };
    SampleIntake::Follower follower = [this, &lap](const core::Sample& sample) {
        lap.add(core::centre_mm(sample, capabilities_.lsb_mm).head<2>());
        if (!lap.closed() || intake_->section() == nullptr) return core::Status{};
        intake_->section()->close_after(intake_->section()->points().size() + 1);
        machine_.tell(drivers::HandSignal::end_section);
        return core::Status{};
    };
    intake_->begin(path.id, new_section(section_), std::move(completed), std::move(follower));
    HandIntake::Notice show = [this](const std::string& text) { notice(text); };
    const HandIntake::Section here{section_, z_mm, request_.part.scan.search_mm, capabilities_.lsb_mm};
    HandIntake sink(*intake_, events_, here, std::move(show));
    auto received = co_await machine_.receive(path, sink);
    if (!received) co_return tl::unexpected(received.error());
    // Not begun, so that --resume begins it.
    if (stop_requested_ && intake_->section() != nullptr && intake_->section()->points().empty())
        co_return core::fail(core::ErrorCode::cancelled, "stopped on request", core::Motion::not_concerned);
    co_return core::Status{};
}

void ScanJob::tell(drivers::HandSignal signal) noexcept {
    machine_.tell(signal);
}

}  // namespace cmm::acquisition
