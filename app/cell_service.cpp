// SPDX-License-Identifier: Apache-2.0
#include "app/cell_service.hpp"

#include <algorithm>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <filesystem>
#include <memory>
#include <utility>

#include "acquisition/json_text.hpp"
#include "app/job_request.hpp"
#include "app/mqtt_login.hpp"
#include "app/run_page.hpp"
#include "drivers/endpoint.hpp"

namespace cmm::app {
namespace {

namespace asio = boost::asio;

core::Result<cell::PlcServerOptions> server_options(const CellSettings& settings) {
    const auto place = drivers::Endpoint::parse(settings.plc);
    if (!place) return tl::unexpected(place.error());
    if (place->scheme != "modbus+tcp" || place->options.contains("in_flight")) {
        return core::fail(core::ErrorCode::usage,
                          settings.plc + ": a PLC is served at modbus+tcp://ADDRESS:PORT, with ?unit=N if need be");
    }
    cell::PlcServerOptions options;
    options.address = place->host == "localhost" ? "127.0.0.1" : place->host;
    options.port = place->port;
    options.unit = static_cast<std::uint8_t>(place->integer("unit", 1));
    options.watchdog = core::from_ms(settings.watchdog_ms);
    for (const auto& peer : settings.allow)
        if (auto status = options.peers.add(peer); !status) return tl::unexpected(status.error());
    return options;
}

std::string line_of(const cell::Order& order, const std::string& text) {
    return "run " + std::to_string(order.run) + ", program " + std::to_string(order.program) +
           (order.serial.empty() ? "" : ", " + order.serial) + ": " + text;
}

}  // namespace

CellService::CellService(CellSettings settings, const core::Clock& clock)
    : settings_(std::move(settings)), clock_(clock) {}

core::Status CellService::start() {
    auto link = drivers::link_settings_from(settings_.machine);
    if (!link) return tl::unexpected(link.error());
    link_ = std::move(*link);
    auto programs = find_programs(settings_.parts);
    if (!programs) return tl::unexpected(programs.error());
    programs_ = std::move(*programs);
    std::error_code code;
    std::filesystem::create_directories(settings_.runs, code);
    if (code) return core::fail(core::ErrorCode::journal_io, settings_.runs + ": cannot be made: " + code.message());
    record_file_ = settings_.runs + "/cell.json";
    auto record = cell::load_record(record_file_);
    if (!record) return tl::unexpected(record.error());
    record->order.run = std::max(record->order.run, last_run_in(settings_.runs));
    auto server = server_options(settings_);
    if (!server) return tl::unexpected(server.error());
    if (auto status = start_mqtt(); !status) return status;

    cell::CellFront::Options options;
    options.server = std::move(*server);
    options.cell.watchdog = options.server.watchdog;
    options.cell.restored = std::move(*record);
    for (const auto& [number, file] : programs_)
        options.cell.programs.insert(number);
    host_ = options.server.address;
    cell::CellHost host;
    host.record = [this](const cell::CellRecord& what) { asio::post(context_, [this, what] { keep(what); }); };
    host.run = [this](const cell::Order& order) {
        {
            const std::lock_guard guard(run_mutex_);
            stop_asked_ = false;
        }
        asio::post(context_, [this, order] { run(order); });
    };
    host.stop = [this] {
        const std::lock_guard guard(run_mutex_);
        stop_asked_ = true;
        if (run_) run_->stop();
    };
    auto front = cell::CellFront::start(
        options, std::move(host), clock_, [this](const cell::CellView& view) { tell(view); },
        [this](core::Duration latency) { metrics_.told(latency); });
    if (!front) return tl::unexpected(front.error());
    front_ = std::move(*front);
    return start_page();
}

core::Status CellService::start_mqtt() {
    if (settings_.mqtt.empty()) return {};
    const auto options = mqtt_options(settings_.mqtt, settings_.mqtt_login);
    if (!options) return tl::unexpected(options.error());
    auto notice = [this](const std::string& text) { asio::post(context_, [this, text] { progress_.line(text); }); };
    auto publisher = cell::MqttPublisher::start(*options, std::move(notice));
    if (!publisher) return tl::unexpected(publisher.error());
    mqtt_ = std::move(*publisher);
    return {};
}

/// On the front's thread, after each change.
void CellService::tell(const cell::CellView& view) {
    metrics_.hear(view);
    if (!mqtt_) return;
    const std::string fields = "{" + cell_fields(view) + "}";
    mqtt_->publish("state", fields, true);
    if (view.state == cell::CellState::done) mqtt_->publish("result", fields, true);
}

/// Each decision as its event, and whose it is.
void CellService::tell(const acquisition::Event& event, const cell::Order& order) {
    if (event.kind != acquisition::EventKind::gate_decision) return;
    const std::string part = acquisition::JsonFields()
                                 .add("run", order.run)
                                 .add("program", order.program)
                                 .add("serial", order.serial)
                                 .text();
    mqtt_->publish("decision", "{" + part + "," + acquisition::to_ndjson(event).substr(1), false);
}

core::Status CellService::start_page() {
    if (settings_.page.listen.empty()) return {};
    settings_.page.runs = settings_.runs;
    web::ServiceView view;
    view.cell = [this] {
        return "{" + cell_fields(front_->view()) + ",\"plc\":{\"port\":" + std::to_string(front_->port()) + "," +
               plc_fields(front_->counts()) + "}}";
    };
    view.metrics = [this](web::MetricsText& text) {
        metrics_.print(text, front_->view(), front_->counts());
        if (mqtt_) print_mqtt(text, mqtt_->counts());
    };
    auto page = web::PageServer::start(page_options(settings_.page), {}, nullptr, std::move(view));
    if (!page) return tl::unexpected(page.error());
    page_ = std::move(*page);
    return {};
}

std::string CellService::url() const {
    const bool bracketed = host_.find(':') != std::string::npos;
    return "modbus+tcp://" + (bracketed ? "[" + host_ + "]" : host_) + ":" + std::to_string(front_->port());
}

void CellService::serve() {
    context_.run();
}

/// The handshake goes on also where the disk does not: a result that nobody may hear would be lost for certain.
void CellService::keep(const cell::CellRecord& record) {
    if (const auto status = cell::save_record(record_file_, record); !status)
        progress_.line("cmmlive: " + status.error().text());
    if (record.phase == cell::CellRecord::Phase::done) {
        progress_.line(line_of(record.order, std::string(cell::to_string(record.outcome.result)) +
                                                 (record.outcome.reason == cell::Reason::none ? "" : ", ") +
                                                 std::string(cell::text_of(record.outcome.reason))));
    }
    front_->recorded();
}

void CellService::run(const cell::Order& order) {
    progress_.line(line_of(order, programs_.at(order.program)));
    CellRunHooks hooks;
    hooks.progress = [this](double share, std::size_t section, const std::string& text) {
        front_->progress(share, section);
        if (!text.empty()) show(share, text);
    };
    hooks.rejected = [this](std::size_t section, core::Duration arrived) {
        front_->rejected_for_certain(section, arrived);
    };
    hooks.held = [this](cell::Reason reason) { front_->held(reason); };
    hooks.ended = [this] { ended(); };
    auto made = std::make_unique<CellRun>(context_, link_, clock_, workers_, std::move(hooks));
    CellRun::Order what;
    what.part_file = programs_.at(order.program);
    what.serial = order.serial;
    what.folder = settings_.runs + "/" + run_folder_name(order.run, order.serial);
    what.stop_when_rejected = settings_.stop_when_rejected;
    what.wait_s = settings_.wait_s;
    if (const auto status = made->prepare(what); !status) {
        progress_.line("cmmlive: " + status.error().text());
        const auto code = status.error().code;
        constexpr int wrong_input = 3;
        const auto reason =
            core::exit_code(code) == wrong_input ? cell::Reason::program_invalid : cell::reason_of(code);
        return front_->ended({cell::CellResult::error, reason, false});
    }
    {
        const std::lock_guard guard(run_mutex_);
        run_ = std::move(made);
        if (stop_asked_) run_->stop();
    }
    if (mqtt_) run_->events().listen([this, order](const acquisition::Event& event) { tell(event, order); });
    begin_page();
    run_->begin();
}

void CellService::show(double share, const std::string& text) {
    progress_.show(share, text);
    const std::lock_guard guard(progress_mutex_);
    share_ = share;
    text_ = text;
}

void CellService::begin_page() {
    show(0.0, "begins");
    if (!page_) return;
    web::LiveJob live;
    live.folder = run_->folder();
    live.stop = [run = run_.get()] { run->stop(); };
    live.events = &run_->events();
    live.link = [run = run_.get()] { return run->machine().link_stats(); };
    live.status = [this, run = run_.get()] {
        const std::lock_guard guard(progress_mutex_);
        return job_status(share_, text_, run->machine());
    };
    page_->begin_job(std::move(live), run_->events());
}

/// What an operator decided about points on the page counts for the result as well.
void CellService::ended() {
    if (page_) {
        auto choice = page_->end_job();
        if (!choice.empty()) judge_as_chosen(run_->outcome(), run_->folder() + "/run.cmmrun", std::move(choice));
    }
    front_->ended(cell_outcome(run_->outcome()));
    asio::post(context_, [this] { finish_run(); });
}

void CellService::finish_run() {
    if (run_->outcome().error) progress_.line("cmmlive: " + run_->outcome().error->text());
    if (const auto status = run_->write_files(); !status) progress_.line("cmmlive: " + status.error().text());
    const std::lock_guard guard(run_mutex_);
    run_.reset();
}

void CellService::end_orderly() {
    front_->shut_down();
    asio::post(context_, [this] { end_when_at_rest(); });
}

void CellService::end_when_at_rest() {
    constexpr auto again = std::chrono::milliseconds(20);
    const auto state = front_->view().state;
    const bool rests = state == cell::CellState::waiting || state == cell::CellState::done;
    if (rests && !run_) return work_.reset();
    auto timer = std::make_shared<asio::steady_timer>(context_, again);
    timer->async_wait([this, timer](const boost::system::error_code&) { end_when_at_rest(); });
}

void CellService::abort() {
    {
        const std::lock_guard guard(run_mutex_);
        if (run_) abort_run(run_->machine(), settings_.json);
    }
    std::_Exit(0);
}

}  // namespace cmm::app
