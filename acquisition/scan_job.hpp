// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/awaitable.hpp>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/disk_room.hpp"
#include "acquisition/events.hpp"
#include "acquisition/first_touch.hpp"
#include "acquisition/journal.hpp"
#include "acquisition/nominal.hpp"
#include "acquisition/part_file.hpp"
#include "acquisition/part_frame.hpp"
#include "acquisition/plan.hpp"
#include "acquisition/plan_times.hpp"
#include "acquisition/recorded_sections.hpp"
#include "acquisition/sample_intake.hpp"
#include "acquisition/section_finisher.hpp"
#include "acquisition/session.hpp"
#include "acquisition/workers.hpp"
#include "core/clock.hpp"
#include "drivers/framed_machine.hpp"
#include "drivers/machine.hpp"

namespace cmm::acquisition {

struct ScanRequest {
    PartFile part;
    std::shared_ptr<const Nominal> nominal;  ///< nullptr: none
    std::string run_file;                    ///< out/run.cmmrun
    bool resume = false;
    bool touch = false;  ///< by single touches, also where the machine could scan
    std::string machine_url;
    drivers::MachineErrors machine_errors;  ///< as its file says
    std::string software_version;
    std::vector<SourceFile> sources;  ///< of the part (traceability.hpp)
    std::string run_id, started_utc;
    /// Asked while a run waits for a full disk, on a thread of its own that may outlive the job.
    std::function<bool(const std::string& beside, std::int64_t bytes)> disk_has_room = acquisition::disk_has_room;
};

struct ScanOutcome {
    PartResult result;  ///< also of a run that failed: what was measured until then
    std::optional<core::Error> error;
    SectionLatency latency;
    std::uint64_t samples = 0;
};

/// One run: plans, drives the machine section by section, keeps every sample, judges every section while the next is
/// measured. The shell round the table of session.hpp. Coroutines run on the machine's executor, which owns the job's
/// state; what takes long (plans, fits, files) runs on the workers: nothing here holds the executor up. `request_stop`
/// from any thread or signal handler thread.
class ScanJob {
  public:
    ScanJob(ScanRequest request, drivers::Machine& machine, const core::Clock& clock, EventHub& events,
            Workers& workers);
    ~ScanJob();
    ScanJob(const ScanJob&) = delete;
    ScanJob& operator=(const ScanJob&) = delete;

    /// Called on the executor now and then: share done (0...1) and a line of text.
    void on_progress(std::function<void(double, std::string)> show) { show_progress_ = std::move(show); }
    /// Called on the executor: what a person should read, also when nobody watches the progress.
    void on_notice(std::function<void(const std::string&)> show) { show_notice_ = std::move(show); }
    boost::asio::awaitable<ScanOutcome> run();
    void request_stop() noexcept;
    /// Called on the executor once, when the machine turns out to be one that a person moves.
    void on_moved_by_hand(std::function<void()> begin) { moved_by_hand_ = std::move(begin); }
    /// What a person at the host says to such a machine; any thread.
    void tell(drivers::HandSignal signal) noexcept;

  private:
    using Step = boost::asio::awaitable<core::Status>;
    /// Told of a place without contact, and how many in a row that is. An error ends the section.
    using Missed = std::function<core::Status(const drivers::PathPoint&, std::size_t in_row)>;

    boost::asio::awaitable<SessionInput> perform(SessionAction action);
    Step connect();
    Step recover();
    Step begin_run();
    Step resume_run();
    Step reopen_journal();
    Step restore_sections();
    boost::asio::awaitable<core::Result<Eigen::Vector3d>> ready();
    Step take_up();
    Step leave_part();
    boost::asio::awaitable<core::Result<drivers::MachineStatus>> come_to_rest();
    bool may_pass(const core::Error& error) const;
    Step hold();
    void announce_hold(const core::Error& cause);
    void ask_for_room(const core::Error& cause);
    boost::asio::awaitable<core::Result<bool>> has_passed(core::Error& cause);
    boost::asio::awaitable<core::Result<bool>> replace_journal();
    boost::asio::awaitable<bool> ran_into_something(const core::Error& error);
    boost::asio::awaitable<void> back_off(core::Error& error);
    boost::asio::awaitable<core::Result<double>> retract();
    std::optional<Eigen::Vector3d> way_back(const Eigen::Vector3d& where) const;
    Step travel(Eigen::Vector3d from, Eigen::Vector3d to);
    Step home();
    Step qualify();
    core::Status can_align() const;
    Step align();
    void use_frame(const PartFrame& frame);
    void use_errors(const drivers::MachineErrors& errors);
    boost::asio::awaitable<core::Result<std::optional<PartFrame>>> find_frame();
    boost::asio::awaitable<core::Result<fitting::TouchCentres>> touch_datums(double approach_mm);
    core::Status within_travel() const;
    std::optional<Eigen::Vector3d> off_datum(const Eigen::Vector3d& where) const;
    core::Status take_recorded_frame();
    boost::asio::awaitable<core::Result<bool>> approach();
    Step begin_path(JournalPath path, std::size_t points);
    Step scan();
    Step scan_planned(drivers::ScanPath path);
    Step scan_unknown(drivers::ScanPath path);
    Step scan_by_hand(drivers::ScanPath path);
    core::Status measure_as_begun();
    core::Status check() const;
    std::size_t next_planned() const;
    core::Result<std::uint16_t> path_of_touches() const;
    boost::asio::awaitable<core::Result<bool>> find_again();
    core::Status plan_pass();
    void submit_again(std::size_t index);
    Step scan_again();
    void restore_again(std::vector<RecordedSection>& recorded);
    Step touch_planned(std::uint16_t path, drivers::PathSource& source);
    Step touch_along(std::uint16_t path, drivers::PathSource& source, const Missed& note);
    /// How far above a place a touch begins, and how far below it ends without contact.
    struct TouchReach {
        double approach_mm, search_mm;
    };
    boost::asio::awaitable<core::Result<Eigen::Vector3d>> touch(drivers::PathPoint place, TouchReach reach,
                                                                drivers::SampleSink& sink);
    boost::asio::awaitable<core::Result<Entry>> find_part();
    Step stop_machine();
    Step flush();
    boost::asio::awaitable<void> all_judged();
    core::Status prepare();
    Step start_journal(const drivers::RunOrigin& origin);
    void section_completed(std::unique_ptr<LiveSection> section);
    void rehearse(const LiveSection& section, std::span<const drivers::PathPoint> planned, double left_ms);
    void keep_events();
    void report_fault(const core::Error& error);
    void progress(std::string text);
    void notice(const std::string& text);
    bool is_out();
    bool rejected() const;
    drivers::ScanPath next_path() const;
    std::unique_ptr<LiveSection> new_section(std::size_t index) const;
    double share_done() const;
    std::uint64_t samples() const;
    /// Of a section that is driven along a plan; 0: not known beforehand.
    std::size_t expected_points(std::size_t section) const;

    ScanRequest request_;
    drivers::FramedMachine machine_;  // in the frame of the part, once it is known
    EventHub& events_;
    Workers& workers_;
    std::function<void(double, std::string)> show_progress_;
    std::function<void(const std::string&)> show_notice_;
    std::function<void()> moved_by_hand_;
    std::atomic<bool> stop_requested_{false};

    SessionState state_ = SessionState::idle;
    std::optional<core::Error> error_;
    drivers::Capabilities capabilities_;
    std::optional<PartFrame> frame_;  // by datum points
    bool touching_ = false;           // sections are measured by single touches
    bool owner_ = false;              // of the machine, since begin_run
    std::shared_ptr<Journal> journal_;
    std::unique_ptr<SampleIntake> intake_;
    Plan plan_;
    PlanTimes times_;
    std::size_t datums_touched_ = 0;  // over all rounds
    std::vector<SectionSetup> setups_;
    std::vector<std::vector<RecordedPoint>> restored_;  // resume: points of a section that was not finished
    std::vector<bool> done_;
    std::size_t section_ = 0;                   // under the probe
    std::optional<Entry> entry_;                // unknown part: into the last section
    std::optional<Eigen::Vector3d> came_from_;  // a free place, straight behind the motion under way
    /// A stretch that is still to be measured again.
    struct AgainPath {
        std::size_t section;
        std::vector<drivers::PathPoint> points;
        std::size_t first;  // behind those that are measured already
    };
    struct {
        std::uint8_t pass = 0;  // under way, or the last one
        std::deque<AgainPath> paths;
        std::vector<std::vector<RecordedPoint>> measured;  // by section: all points so far
        std::vector<std::vector<RecordedPoint>> there;     // resume: of the pass that was cut off
        bool found = false;                                // by the last planning
    } again_;
    std::unique_ptr<LiveSection> left_over_;  // of the section that was broken off last
    std::optional<core::Error> held_by_;
    DiskQuestion disk_room_;
    bool out_ = false;       // a section proved out of tolerance, its path was cut short
    bool going_on_ = false;  // after a hold: the run file is open, the machine ours
    bool started_ = false, qualified_ = false;
    double waited_s_ = 0.0;
    std::uint64_t held_after_ = 0;  // sample
    std::optional<std::uint64_t> first_durable_;
    std::uint64_t samples_before_ = 0;  // of this process, before the present intake
    std::weak_ptr<Journal> events_kept_in_;
    std::uint16_t last_path_ = 0;
    std::unique_ptr<SectionFinisher> finisher_;
};

}  // namespace cmm::acquisition
