// SPDX-License-Identifier: Apache-2.0
#include "app/scan_runner.hpp"

#include <unistd.h>

#include <boost/asio/co_spawn.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/strand.hpp>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <optional>

#include "acquisition/exports.hpp"
#include "acquisition/scan_job.hpp"
#include "app/browser.hpp"
#include "app/console.hpp"
#include "app/hand_commands.hpp"
#include "app/job_request.hpp"
#include "app/machines.hpp"
#include "app/run_page.hpp"
#include "app/stop_signals.hpp"
#include "core/text.hpp"

namespace cmm::app {
namespace {

namespace asio = boost::asio;

core::Status prepare_folder(const std::string& out, bool resume) {
    std::error_code code;
    std::filesystem::create_directories(out, code);
    if (code) return core::fail(core::ErrorCode::journal_io, out + ": the folder cannot be made: " + code.message());
    const std::string run_file = out + "/run.cmmrun";
    const bool exists = std::filesystem::exists(run_file, code);
    if (resume && !exists) return core::fail(core::ErrorCode::input_missing, run_file + ": there is no run to resume");
    if (!resume && exists) {
        return core::fail(core::ErrorCode::usage,
                          run_file + ": holds a run already; go on with it by --resume, or choose another --out");
    }
    return {};
}

core::Result<acquisition::ScanRequest> make_request(const RunnerOptions& options,
                                                    const drivers::LinkSettings& machine) {
    auto part = options.known_part ? core::Result<acquisition::PartFile>(*options.known_part)
                                   : acquisition::load_part_to_measure(options.part);
    if (!part) return tl::unexpected(part.error());
    if (options.wait_s >= 0.0) part->scan.wait_s = options.wait_s;
    if (options.stop_when_rejected) part->scan.stop_when_rejected = true;
    auto request = new_request(std::move(*part), options.out, machine);
    if (!request) return request;
    request->resume = options.resume;
    request->touch = options.touch;
    return request;
}

}  // namespace

int print_result(const acquisition::PartResult& result, const std::string& out, bool json) {
    const int code = exit_code(result.verdict());
    if (json) {
        std::printf("%s\n", acquisition::result_json(result).c_str());
    } else {
        std::printf("%s", acquisition::summary_text(result).c_str());
        if (!out.empty()) std::printf("files: %s (open report.html)\n", out.c_str());
    }
    return code;
}

int run_main_job(const RunnerOptions& options) {
    const auto fail = [&](const core::Error& error) { return report(error, options.json); };
    auto link = drivers::link_settings_from(options.machine);
    if (!link) return fail(link.error());
    if (auto status = prepare_folder(options.out, options.resume); !status) return fail(status.error());
    auto request = make_request(options, *link);
    if (!request) return fail(request.error());
    auto event_file = EventFile::open(options.events);
    if (!event_file) return fail(event_file.error());

    const core::SystemClock clock;
    acquisition::EventHub events(clock);
    if (*event_file) events.listen([file = *event_file](const acquisition::Event& event) { file->write(event); });

    asio::io_context context;
    const auto strand = asio::make_strand(context);
    const auto registry = machine_registry();
    auto machine = registry.make(*link, drivers::DriverContext{strand, clock, random_seed()});
    if (!machine) return fail(machine.error());

    Progress progress(options.json && ::isatty(STDERR_FILENO) == 0);
    if (!options.title.empty()) progress.line(options.title);
    acquisition::Workers workers;
    RunPage page;
    std::optional<acquisition::ScanOutcome> outcome;
    acquisition::OperatorChoice choice;
    std::optional<ShownPage> shown;
    {
        acquisition::ScanJob job(std::move(*request), **machine, clock, events, workers);
        if (auto status = page.start(options.page, options.out, job, **machine, events); !status)
            return fail(status.error());
        if (!page.url().empty()) progress.line("page: " + page.url());
        if (!page.url().empty() && options.page.show) shown.emplace(page.url(), options.out);
        job.on_progress([&](double share, const std::string& text) {
            progress.show(share, text);
            page.show(share, text);
        });
        std::optional<HandCommands> commands;
        job.on_moved_by_hand([&] {
            progress.line(
                "a person moves this machine: Enter takes a point (if it can be asked), e and Enter ends the "
                "section, Ctrl-C the run");
            commands.emplace([&](drivers::HandSignal signal) { job.tell(signal); });
        });
        job.on_notice([&](const std::string& text) { progress.line(text); });

        const StopSignals signals([&] { job.request_stop(); }, [&] { abort_run(**machine, options.json); });
        auto done = [&](const std::exception_ptr& thrown, acquisition::ScanOutcome result) {
            if (thrown) std::rethrow_exception(thrown);
            outcome = std::move(result);
        };
        asio::co_spawn(strand, job.run(), done);
        context.run();
        choice = page.end();
    }
    if (!choice.empty()) judge_as_chosen(*outcome, options.out + "/run.cmmrun", std::move(choice));

    if (outcome->samples > 0 || !outcome->result.sections.empty()) {
        if (auto status = acquisition::write_outputs(outcome->result, options.out); !status && !outcome->error) {
            outcome->error = status.error();
        }
    }
    const auto stay = [&](int code) {
        if (options.page.stay && !page.url().empty()) {
            std::fflush(stdout);
            progress.line("the page stays until Ctrl-C: " + page.url());
            wait_for_end();
        }
        return code;
    };
    if (outcome->error) return stay(fail(*outcome->error));
    progress.show(1.0, "done");
    const auto worded = [](const acquisition::LatencySummary& latency) {
        return "p50 " + core::fixed(latency.p50_ms, 1) + " ms, p99 " + core::fixed(latency.p99_ms, 1) + " ms, max " +
               core::fixed(latency.max_ms, 1) + " ms";
    };
    progress.line(std::to_string(outcome->samples) + " points; after its last point a section's contour: " +
                  worded(outcome->latency.closed) + "; its decision: " + worded(outcome->latency.decided));
    return stay(print_result(outcome->result, options.scratch ? "" : options.out, options.json));
}

}  // namespace cmm::app
