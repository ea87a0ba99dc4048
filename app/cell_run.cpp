// SPDX-License-Identifier: Apache-2.0
#include "app/cell_run.hpp"

#include <boost/asio/co_spawn.hpp>
#include <boost/asio/strand.hpp>
#include <exception>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <utility>

#include "acquisition/exports.hpp"
#include "app/cell_programs.hpp"
#include "app/job_request.hpp"
#include "app/machines.hpp"

namespace cmm::app {
namespace {

namespace asio = boost::asio;
using acquisition::Decision;
using acquisition::EventKind;
using cell::CellResult;
using cell::Reason;

bool moves_perhaps(core::Motion motion) {
    return motion == core::Motion::may_be_moving || motion == core::Motion::unknown;
}

core::Status new_folder(const std::string& folder) {
    std::error_code code;
    if (std::filesystem::create_directory(folder, code)) return {};
    return core::fail(core::ErrorCode::journal_io,
                      folder + ": cannot be made: " + (code ? code.message() : "it is there already"));
}

}  // namespace

cell::Outcome cell_outcome(const acquisition::ScanOutcome& outcome) {
    if (outcome.error)
        return {CellResult::error, cell::reason_of(outcome.error->code), moves_perhaps(outcome.error->motion)};
    switch (outcome.result.verdict()) {
        case Decision::accept:
            return {CellResult::accepted, Reason::conforming, false};
        case Decision::reject:
            return {CellResult::rejected,
                    outcome.result.complete ? Reason::out_of_tolerance : Reason::out_while_measuring, false};
        case Decision::reported:
            return {CellResult::measured, Reason::none, false};
        case Decision::undecided:
        case Decision::not_evaluable:
            break;
    }
    return {CellResult::undecided, Reason::undecided, false};
}

CellRun::CellRun(asio::io_context& context, const drivers::LinkSettings& link, const core::Clock& clock,
                 acquisition::Workers& workers, CellRunHooks hooks)
    : strand_(asio::make_strand(context)),
      link_(link),
      clock_(clock),
      workers_(workers),
      hooks_(std::move(hooks)),
      events_(clock) {}

core::Status CellRun::prepare(const Order& order) {
    auto part = part_with_serial(order.part_file, order.serial);
    if (!part) return tl::unexpected(part.error());
    if (order.wait_s >= 0.0) part->scan.wait_s = order.wait_s;
    if (order.stop_when_rejected) part->scan.stop_when_rejected = true;
    auto request = new_request(std::move(*part), order.folder, link_);
    if (!request) return tl::unexpected(request.error());
    auto machine = machine_registry().make(link_, drivers::DriverContext{strand_, clock_, random_seed()});
    if (!machine) return tl::unexpected(machine.error());
    if (auto status = new_folder(order.folder); !status) return status;
    folder_ = order.folder;
    machine_ = std::move(*machine);
    job_ = std::make_unique<acquisition::ScanJob>(std::move(*request), *machine_, clock_, events_, workers_);
    job_->on_progress([this](double share, const std::string& text) {
        share_ = share;
        hooks_.progress(share_, section_, text);
    });
    events_.listen([this](const acquisition::Event& event) { hear(event); });
    return {};
}

asio::awaitable<void> CellRun::go() {
    outcome_ = co_await job_->run();
    hooks_.ended();
}

void CellRun::begin() {
    asio::co_spawn(strand_, go(), [](const std::exception_ptr& thrown) {
        if (thrown) std::rethrow_exception(thrown);
    });
}

core::Status CellRun::write_files() const {
    if (outcome_->samples == 0 && outcome_->result.sections.empty()) return {};
    return acquisition::write_outputs(outcome_->result, folder_);
}

/// A section that is rejected for certain, while it is measured or behind its last point, settles the verdict
/// (docs/cli.md).
void CellRun::hear(const acquisition::Event& event) {
    if (event.kind == EventKind::resume) return hooks_.held(Reason::none);
    const bool hold = event.kind == EventKind::hold;
    const bool path = event.kind == EventKind::path_started, section = event.kind == EventKind::section_final;
    if (!hold && !path && !section && event.kind != EventKind::gate_decision) return;
    const auto fields = nlohmann::json::parse("{" + event.payload + "}", nullptr, false);
    if (hold) return hooks_.held(cell::reason_of(std::string_view(fields.value("code", ""))));
    if (path) {
        section_ = fields.value("section", std::size_t{0}) + 1;
        return hooks_.progress(share_, section_, "");
    }
    const auto latency = fields.find("latency_ms");
    const bool timed = latency != fields.end() && latency->is_number();
    if (section) {
        latency_ms_ = timed ? latency->get<double>() : 0.0;
        return;
    }
    if (fields.value("decision", "") != "reject") return;
    if (!fields.value("while_measuring", false) && !fields.value("certain", false)) return;
    const auto arrived = clock_.now() - core::from_ms(timed ? latency->get<double>() : latency_ms_);
    hooks_.rejected(fields.value("section", std::size_t{0}) + 1, arrived);
}

}  // namespace cmm::app
