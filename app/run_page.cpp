// SPDX-License-Identifier: Apache-2.0
#include "app/run_page.hpp"

#include <boost/asio/io_context.hpp>
#include <boost/asio/signal_set.hpp>
#include <csignal>
#include <utility>

#include "acquisition/event_payload.hpp"
#include "acquisition/json_text.hpp"
#include "app/console.hpp"

namespace cmm::app {

web::PageOptions page_options(const PageSettings& settings) {
    web::PageOptions options;
    options.listen = settings.listen;
    options.token_file = settings.token_file;
    options.hosts = settings.hosts;
    options.runs_folder = settings.runs;
    options.version = "cmmlive " + version();
    return options;
}

std::string job_status(double share, const std::string& text, const drivers::Machine& machine) {
    constexpr int share_digits = 4;
    return acquisition::JsonFields()
        .add("share", share, share_digits)
        .add("text", text)
        .raw("link", "{" + acquisition::link_payload(machine.link_stats()) + "}")
        .text();
}

void wait_for_end() {
    boost::asio::io_context context;
    boost::asio::signal_set signals(context, SIGINT, SIGTERM);
    signals.async_wait([](const boost::system::error_code&, int) {});
    context.run();
}

core::Status RunPage::start(const PageSettings& settings, const std::string& folder, acquisition::ScanJob& job,
                            drivers::Machine& machine, acquisition::EventHub& events) {
    if (settings.listen.empty()) return {};
    web::LiveJob live;
    live.folder = folder;
    live.status = [this, &machine] {
        const std::lock_guard guard(mutex_);
        return job_status(share_, text_, machine);
    };
    live.stop = [&job] { job.request_stop(); };
    live.events = &events;
    live.link = [&machine] { return machine.link_stats(); };
    auto server = web::PageServer::start(page_options(settings), std::move(live), &events);
    if (!server) return tl::unexpected(server.error());
    server_ = std::move(*server);
    return {};
}

void RunPage::show(double share, const std::string& text) {
    const std::lock_guard guard(mutex_);
    share_ = share;
    text_ = text;
}

acquisition::OperatorChoice RunPage::end() {
    return server_ ? server_->end_job() : acquisition::OperatorChoice();
}

}  // namespace cmm::app
