// SPDX-License-Identifier: Apache-2.0
#include "app/job_request.hpp"

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <thread>
#include <utility>

#include "acquisition/nominal.hpp"
#include "acquisition/run_results.hpp"
#include "acquisition/traceability.hpp"
#include "app/console.hpp"

namespace cmm::app {
namespace {

std::string new_run_id(const std::string& started_utc) {
    char text[32];
    std::snprintf(text, sizeof text, "-%08x", static_cast<unsigned>(random_seed()));
    return started_utc + text;
}

}  // namespace

std::uint64_t random_seed() {
    std::random_device device;
    return (static_cast<std::uint64_t>(device()) << 32U) | device();
}

core::Result<acquisition::ScanRequest> new_request(acquisition::PartFile part, const std::string& out,
                                                   const drivers::LinkSettings& machine) {
    auto nominal = acquisition::load_nominal(part.nominal);
    if (!nominal) return tl::unexpected(nominal.error());
    acquisition::ScanRequest request;
    request.sources = acquisition::sources_of(part);
    request.part = std::move(part);
    request.nominal = std::move(*nominal);
    request.run_file = out + "/run.cmmrun";
    request.machine_url = machine.endpoint.text();
    request.machine_errors = machine.errors;
    request.software_version = "cmmlive " + version();
    request.started_utc = utc_now();
    request.run_id = new_run_id(request.started_utc);
    return request;
}

void judge_as_chosen(acquisition::ScanOutcome& outcome, const std::string& run_file,
                     acquisition::OperatorChoice choice) {
    auto judged = acquisition::results_of_run(run_file, nullptr, std::move(choice));
    if (!judged) {
        if (!outcome.error) outcome.error = judged.error();
        return;
    }
    judged->complete = judged->complete && outcome.result.complete;
    outcome.result = std::move(*judged);
}

void abort_run(drivers::Machine& machine, bool json) {
    constexpr auto patience = std::chrono::seconds(1);
    const auto before = machine.link_stats();
    core::Error error{core::ErrorCode::cancelled, "aborted before the machine was reached", {}, core::Motion::unknown};
    if (before.bytes_sent > 0) {
        machine.stop(drivers::StopKind::controlled);
        const auto give_up = std::chrono::steady_clock::now() + patience;
        while (machine.link_stats().stops == before.stops && std::chrono::steady_clock::now() < give_up)
            std::this_thread::sleep_for(std::chrono::milliseconds(2));
        const bool told = machine.link_stats().stops > before.stops;
        error.message = told ? "aborted; the machine was told to stop"
                             : "aborted; the machine could not be told to stop, its watchdog does it";
        error.motion = core::Motion::may_be_moving;
    }
    const int code = report(error, json);
    std::fflush(nullptr);
    std::_Exit(code);
}

}  // namespace cmm::app
