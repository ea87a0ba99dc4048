// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <boost/asio/co_spawn.hpp>
#include <boost/asio/io_context.hpp>
#include <exception>
#include <functional>

#include "acquisition/scan_job.hpp"
#include "acquisition/traceability.hpp"
#include "tests/acquisition/fake_machine.hpp"
#include "tests/acquisition/temp_folder.hpp"

/// A run on the fake machine, for the tests of the scan job.
namespace cmm::acquisition {

using core::ErrorCode;

/// The same blade, but the job has no nominal: it is found by touches and followed.
inline std::string unknown_part_text() {
    return R"([part]
name = "unknown"
[nominal]
kind = "none"
[stylus]
radius_mm = 1.0
[scan]
heights_mm = [20, 40]
pitch_mm = 1.0
box_mm = [-25, -25, 25, 25]
)";
}

struct Ran {
    ScanOutcome outcome;
    std::vector<Event> events;
    const Event* find(EventKind kind) const {
        for (const auto& event : events)
            if (event.kind == kind) return &event;
        return nullptr;
    }
};

struct ScanJobTest : ::testing::Test {
    core::ManualClock clock;
    TempFolder folder;
    std::string file = folder.path("run.cmmrun");
    FakeMachine machine{clock};
    SessionPart job;
    std::string text = session_part_text();
    bool touch = false;
    drivers::MachineErrors machine_errors;
    std::function<void(ScanJob&)> with_job;
    std::function<bool(const std::string&, std::int64_t)> disk_has_room;

    ScanRequest request(bool resume) const {
        ScanRequest made;
        made.part = parse_part_file(text, "blade.toml").value();
        made.nominal = load_nominal(made.part.nominal).value();
        made.sources = sources_of(made.part);
        made.run_file = file;
        made.resume = resume;
        made.touch = touch;
        if (disk_has_room) made.disk_has_room = disk_has_room;
        made.machine_url = "test:";
        made.machine_errors = machine_errors;
        made.software_version = "test";
        made.run_id = resume ? "run-2" : "run-1";
        made.started_utc = "2025-01-02T03:04:05Z";
        return made;
    }
    Ran run(bool resume = false) {
        boost::asio::io_context context;
        EventHub events(clock);
        const EventLog log(events);
        Workers workers(1);
        ScanJob scan(request(resume), machine, clock, events, workers);
        if (with_job) with_job(scan);
        Ran ran;
        auto done = [&](const std::exception_ptr& thrown, ScanOutcome outcome) {
            if (thrown) std::rethrow_exception(thrown);
            ran.outcome = std::move(outcome);
        };
        boost::asio::co_spawn(context, scan.run(), done);
        context.run();
        ran.events = log.all();
        return ran;
    }
    std::size_t points() const { return job.plan.paths[0].points.size() + job.plan.paths[1].points.size(); }
    std::size_t durable() const {
        auto journal = Journal::read(file);
        EXPECT_TRUE(journal) << journal.error().text();
        return journal ? (*journal)->samples().value().size() : 0;
    }
    /// A run that loses its link after so many samples, then a machine that works again.
    void broken_run(std::size_t cut_after, std::size_t cut_keeps) {
        machine.cut_after = cut_after;
        machine.cut_keeps = cut_keeps;
        const auto first = run();
        ASSERT_TRUE(first.outcome.error);
        EXPECT_EQ(first.outcome.error->code, ErrorCode::transport_closed);
        EXPECT_EQ(durable(), cut_after);
        forget();
        machine.cut_after = 0;
    }
    void forget() {
        machine.calls.clear();
        machine.moves.clear();
        machine.stops = 0;
        machine.fail_at.clear();
    }
};

}  // namespace cmm::acquisition
