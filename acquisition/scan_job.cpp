// SPDX-License-Identifier: Apache-2.0
#include "acquisition/scan_job.hpp"

#include <algorithm>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/this_coro.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <chrono>
#include <cmath>
#include <utility>

#include "acquisition/event_payload.hpp"
#include "acquisition/json_text.hpp"
#include "acquisition/part_characteristics.hpp"
#include "acquisition/plan_check.hpp"
#include "acquisition/recorded_machine.hpp"
#include "acquisition/touch_way.hpp"
#include "drivers/until_durable.hpp"

namespace cmm::acquisition {
namespace {

std::string latency_json(const LatencySummary& latency) {
    return "{" +
           JsonFields()
               .add("count", latency.count)
               .add("p50", latency.p50_ms, 3)
               .add("p99", latency.p99_ms, 3)
               .add("max", latency.max_ms, 3)
               .text() +
           "}";
}

}  // namespace

ScanJob::ScanJob(ScanRequest request, drivers::Machine& machine, const core::Clock& clock, EventHub& events,
                 Workers& workers)
    : request_(std::move(request)),
      machine_(machine),
      events_(events),
      workers_(workers),
      finisher_(std::make_unique<SectionFinisher>(events, clock, workers)) {}

ScanJob::~ScanJob() = default;

void ScanJob::request_stop() noexcept {
    stop_requested_ = true;
    machine_.stop(drivers::StopKind::controlled);
}

boost::asio::awaitable<ScanOutcome> ScanJob::run() {
    SessionInput input = SessionInput::start;
    while (true) {
        const SessionStep next = step(state_, input);
        state_ = next.state;
        if (next.action == SessionAction::report || !next.accepted) break;
        input = co_await perform(next.action);
        const bool going_on =
            input == SessionInput::succeeded && state_ != SessionState::stopping && state_ != SessionState::flushing;
        if (stop_requested_ && going_on) input = SessionInput::stop_requested;
    }
    finisher_->complete(!error_ && !done_.empty() && std::find(done_.begin(), done_.end(), false) == done_.end());
    co_await all_judged();
    ScanOutcome outcome;
    outcome.result.sections = finisher_->take_all();
    outcome.latency = finisher_->latency();
    outcome.samples = samples();
    outcome.error = error_;
    // A person who ends the last section by hand has ended the run, not broken it off.
    const bool all_there = std::find(done_.begin(), done_.end(), false) == done_.end() && again_.paths.empty();
    if (!error_ && stop_requested_ && !all_there)
        outcome.error = core::Error{core::ErrorCode::cancelled, "stopped on request", {}, core::Motion::stopped};
    outcome.result.part_name = request_.part.name;
    outcome.result.part_serial = request_.part.serial;
    outcome.result.started_utc = request_.started_utc;
    outcome.result.run_id = request_.run_id;
    outcome.result.machine = capabilities_.model + " " + capabilities_.serial + " (" + request_.machine_url + ")";
    outcome.result.software_version = request_.software_version;
    outcome.result.sources = request_.sources;
    outcome.result.plan_hash = plan_.hash;
    outcome.result.ball_radius_mm = request_.part.stylus.radius_mm;
    outcome.result.has_nominal = request_.nominal != nullptr;
    outcome.result.part_frame = frame_;
    outcome.result.decision_rule = request_.part.gate.rule.worded();
    outcome.result.uncertainty = request_.part.uncertainty;
    outcome.result.complete = !outcome.error && outcome.result.sections.size() == plan_.paths.size();
    add_part_characteristics(request_.part.gate.characteristics, request_.part.gate.rule, outcome.result);
    for (const auto& characteristic : outcome.result.characteristics)
        events_.emit(EventKind::characteristic_updated, 0.0, characteristic_payload(characteristic));
    const std::string verdict(to_string(outcome.result.verdict()));
    if (journal_ && (outcome.result.complete || (!outcome.error && rejected()))) {
        auto finish = [this, verdict] { return journal_->finish_run(verdict); };
        if (auto status = co_await workers_.run(std::move(finish)); !status) outcome.error = status.error();
    }
    events_.emit(EventKind::link_stats, 0.0, link_payload(machine_.link_stats()));
    events_.emit(EventKind::run_stopped, 0.0,
                 JsonFields()
                     .add("verdict", verdict)
                     .add("complete", outcome.result.complete)
                     .add("samples", outcome.samples)
                     .raw("section_final_latency_ms", latency_json(outcome.latency.closed))
                     .raw("decision_latency_ms", latency_json(outcome.latency.decided))
                     .text());
    co_return outcome;
}

boost::asio::awaitable<SessionInput> ScanJob::perform(SessionAction action) {
    core::Status status;
    switch (action) {
        case SessionAction::connect:
            status = co_await connect();
            break;
        case SessionAction::recover:
            status = co_await recover();
            break;
        case SessionAction::home:
            status = co_await home();
            break;
        case SessionAction::qualify:
            status = co_await qualify();
            break;
        case SessionAction::align:
            status = co_await align();
            break;
        case SessionAction::scan:
            status = co_await scan();
            break;
        case SessionAction::wait:
            status = co_await hold();
            break;
        case SessionAction::stop_machine:
            status = co_await stop_machine();
            break;
        case SessionAction::flush:
            status = co_await flush();
            break;
        case SessionAction::approach: {
            const auto more = co_await approach();
            if (more && !*more) co_return SessionInput::no_path_left;
            if (!more) status = tl::unexpected(more.error());
            break;
        }
        case SessionAction::none:
        case SessionAction::report:
            break;
    }
    if (status) co_return SessionInput::succeeded;
    core::Error error = status.error();
    if (held_by_ || may_pass(error)) {
        held_by_ = std::move(error);
        co_return SessionInput::held;
    }
    const bool contact = co_await ran_into_something(error);
    if (contact) co_await back_off(error);
    report_fault(error);
    co_return SessionInput::failed;
}

void ScanJob::report_fault(const core::Error& error) {
    if (!error_) error_ = error;
    JsonFields fields;
    fields.add("code", core::to_string(error.code))
        .add("message", error.text())
        .add("motion", core::to_string(error.motion));
    fields.add("state", to_string(state_)).add("section", section_).add("path", last_path_);
    fields.add("samples", samples());
    fields.raw("link", "{" + link_payload(machine_.link_stats()) + "}");
    events_.emit(EventKind::machine_fault, 0.0, fields.text());
}

ScanJob::Step ScanJob::connect() {
    auto found = co_await machine_.connect();
    if (!found) co_return tl::unexpected(found.error());
    capabilities_ = *found;
    if (!capabilities_.moves && moved_by_hand_) moved_by_hand_();
    auto work = [this] { return prepare(); };
    co_return co_await workers_.run_long(std::move(work));
}

core::Status ScanJob::prepare() {
    const auto chosen = measures_by_touches(capabilities_, request_.touch);
    if (!chosen) return tl::unexpected(chosen.error());
    touching_ = *chosen;
    if (request_.nominal == nullptr) bound_by_travel(request_.part, capabilities_);
    auto plan = make_plan(request_.part, request_.nominal.get(), &capabilities_);
    if (!plan) return tl::unexpected(plan.error());
    plan_ = std::move(*plan);
    if (auto status = can_align(); !status) return status;
    if (auto status = check(); !status) return status;
    use_errors(capabilities_.recorded_errors.or_else(request_.machine_errors));
    for (std::size_t i = 0; i < plan_.paths.size(); ++i) {
        auto setup = make_section_setup(request_.part, request_.nominal.get(), i, plan_.paths[i].z_mm);
        if (!setup) return tl::unexpected(setup.error());
        setups_.push_back(std::move(*setup));
    }
    times_ = plan_times(plan_, touching_);
    restored_.resize(setups_.size());
    again_.measured.resize(setups_.size());
    again_.there.resize(setups_.size());
    done_.assign(setups_.size(), false);
    return {};
}

/// By how much the machine may err: by its file, or of a run that is gone on with, or played again, as it was then.
void ScanJob::use_errors(const drivers::MachineErrors& errors) {
    if (errors == request_.part.uncertainty.machine) return;
    request_.part.uncertainty.machine = errors;
    for (auto& setup : setups_)
        setup.fields = fitting::ErrorFields(request_.part.uncertainty.errors(), setup.z_mm);
}

core::Status ScanJob::check() const {
    return require_sound(check_plan(plan_, request_.part, request_.nominal.get(), &capabilities_, touching_));
}

ScanJob::Step ScanJob::start_journal(const drivers::RunOrigin& origin) {
    Journal::Header header;
    header.run_id = request_.run_id;
    header.started_utc = request_.started_utc;
    header.part_path = request_.part.path;
    header.part_text = request_.part.text;
    header.machine_url = request_.machine_url;
    header.machine_model = capabilities_.model;
    header.machine_serial = capabilities_.serial;
    header.software_version = request_.software_version;
    header.plan_hash = plan_.hash;
    header.lsb_mm = capabilities_.lsb_mm;
    header.capabilities = capability_numbers(capabilities_);
    header.capabilities[touches_key] = touching_ ? 1.0 : 0.0;
    add_errors(request_.part.uncertainty.machine, header.capabilities);
    header.boot_id = origin.boot_id;
    header.sequence_shift = origin.sequence_shift;
    header.ball_radius_mm = request_.part.stylus.radius_mm;
    auto create = [file = request_.run_file, header] { return Journal::create(file, header); };
    auto journal = co_await workers_.run(std::move(create));
    if (!journal) co_return tl::unexpected(journal.error());
    journal_ = std::move(*journal);
    co_return core::Status{};
}

/// What happened goes into the run file as well; what can be told again from the samples does not.
void ScanJob::keep_events() {
    if (events_kept_in_.lock() == journal_) return;
    events_kept_in_ = journal_;
    events_.listen([journal = std::weak_ptr<Journal>(journal_)](const Event& event) {
        if (event.kind == EventKind::sample_batch || event.kind == EventKind::section_updated) return;
        // A disk that fails shows at the next flush; an event must not end the run.
        if (const auto open = journal.lock()) (void)open->add_event(event.seq, to_string(event.kind), to_ndjson(event));
    });
}

ScanJob::Step ScanJob::home() {
    auto now = co_await machine_.state();
    if (!now) co_return tl::unexpected(now.error());
    if (now->homed) co_return core::Status{};
    // Nobody knows where the part is from here, and the way to the references may lead through it.
    if (now->in_contact) {
        co_return core::fail(core::ErrorCode::machine_position,
                             "the probe touches something and the machine has no references", core::Motion::stopped);
    }
    progress("homing");
    co_return co_await machine_.home();
}

ScanJob::Step ScanJob::qualify() {
    auto now = co_await machine_.state();
    if (!now) co_return tl::unexpected(now.error());
    // Each run qualifies anew, but for a controller that only touches: it knows nothing of the stylus (LinuxCNC).
    const bool once = request_.resume || qualified_ || (touching_ && !capabilities_.scans_paths);
    if ((now->qualified && once) || !capabilities_.moves) co_return core::Status{};
    progress("qualifying the stylus");
    const auto status = co_await machine_.qualify(request_.part.stylus.radius_mm);
    qualified_ = status.has_value();
    co_return status;
}

ScanJob::Step ScanJob::stop_machine() {
    machine_.stop(drivers::StopKind::controlled);
    // The link may be what failed: then the controller's own watchdog has stopped it, and there is nothing to ask.
    auto now = co_await machine_.state();
    if (!now) co_return tl::unexpected(now.error());
    if (now->in_motion) {
        if (error_) error_->motion = core::Motion::may_be_moving;
        co_return core::fail(core::ErrorCode::machine_fault, "the machine still moves after the stop",
                             core::Motion::may_be_moving);
    }
    co_return core::Status{};
}

boost::asio::awaitable<void> ScanJob::all_judged() {
    boost::asio::steady_timer pause(co_await boost::asio::this_coro::executor);
    while (!finisher_->idle()) {
        pause.expires_after(std::chrono::milliseconds(1));
        co_await pause.async_wait(boost::asio::use_awaitable);
    }
}

ScanJob::Step ScanJob::flush() {
    core::Status flushed;
    if (journal_) flushed = co_await drivers::until_durable(*journal_);
    if (!flushed && may_pass(flushed.error())) {
        held_by_ = flushed.error();
        co_return flushed;
    }
    if (left_over_) finisher_->submit(std::move(left_over_));
    if (!owner_) co_return flushed;
    // Without the release the next host waits for the watchdog; a link that is gone cannot carry it.
    auto released = co_await machine_.end_run();
    if (flushed && !released && !error_) co_return released;
    co_return flushed;
}

std::size_t ScanJob::expected_points(std::size_t section) const {
    return capabilities_.moves ? plan_.paths[section].points.size() : 0;
}

/// Sections count alike, the alignment for its share of the time.
double ScanJob::share_done() const {
    if (done_.empty()) return 0.0;
    const double sections =
        static_cast<double>(std::count(done_.begin(), done_.end(), true)) / static_cast<double>(done_.size());
    if (times_.alignment_s == 0.0 || !capabilities_.recorded_frame.empty()) return sections;
    const auto usual = static_cast<double>(usual_datum_rounds * plan_.datum_touches.size());
    const double aligned = frame_ ? 1.0 : std::min(1.0, static_cast<double>(datums_touched_) / usual);
    return std::lerp(sections, aligned, times_.alignment_s / times_.total_s);
}

/// The verdict is certain, and the run shall end with it.
bool ScanJob::rejected() const {
    return request_.part.scan.stop_when_rejected && (out_ || finisher_->rejected());
}

std::uint64_t ScanJob::samples() const {
    return samples_before_ + (intake_ ? intake_->received() : 0);
}

void ScanJob::notice(const std::string& text) {
    if (show_notice_) show_notice_(text);
}

void ScanJob::progress(std::string text) {
    if (show_progress_) show_progress_(share_done(), std::move(text));
}

}  // namespace cmm::acquisition
