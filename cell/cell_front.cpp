// SPDX-License-Identifier: Apache-2.0
#include "cell/cell_front.hpp"

#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <mutex>
#include <thread>
#include <tuple>
#include <utility>

namespace cmm::cell {
namespace {

namespace asio = boost::asio;

constexpr auto tick_every = std::chrono::milliseconds(20);

/// What a PLC sees of a view; the share of the work is no news.
auto visible(const CellView& view) {
    return std::make_tuple(view.state, view.order.run, view.outcome.result, view.outcome.reason,
                           view.rejected_for_certain, view.plc_lives, view.held_by);
}

}  // namespace

struct CellFront::Impl final : RegisterAccess {
    Impl(const Options& options, CellHost host, const core::Clock& the_clock, Changed the_changed, Told the_told)
        : clock(the_clock),
          changed(std::move(the_changed)),
          told(std::move(the_told)),
          cell(options.cell, std::move(host)),
          context(1),
          timer(context) {}
    ~Impl() override {
        context.stop();
        if (thread.joinable()) thread.join();
    }

    ModbusException read(std::size_t address, std::span<std::uint16_t> to) override { return cell.read(address, to); }
    ModbusException write(std::size_t address, std::span<const std::uint16_t> from) override {
        const auto outcome = cell.write(address, from, clock.now());
        publish();
        return outcome;
    }
    void tick() {
        cell.tick(clock.now());
        publish();
        timer.expires_after(tick_every);
        timer.async_wait([this](const boost::system::error_code& code) {
            if (!code) tick();
        });
    }
    /// On the thread, and shown afterwards.
    template <class Work>
    void post(Work work) {
        asio::post(context, [this, work = std::move(work)] {
            work();
            publish();
        });
    }
    void publish() {
        const auto now = cell.view();
        const auto counted = server ? server->counts() : PlcServerCounts();
        bool news = false;
        {
            const std::lock_guard guard(mutex);
            news = !shown || visible(now) != visible(view);
            view = now;
            counts = counted;
            shown = true;
        }
        if (news && changed) changed(now);
    }

    const core::Clock& clock;
    Changed changed;
    Told told;
    Cell cell;
    mutable std::mutex mutex;
    CellView view;  // of these two copies
    PlcServerCounts counts;
    bool shown = false;
    asio::io_context context;
    asio::steady_timer timer;
    std::unique_ptr<PlcServer> server;
    std::uint16_t port = 0;
    std::thread thread;
};

CellFront::CellFront(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
CellFront::~CellFront() = default;

core::Result<std::unique_ptr<CellFront>> CellFront::start(const Options& options, CellHost host,
                                                          const core::Clock& clock, Changed changed, Told told) {
    auto impl = std::make_unique<Impl>(options, std::move(host), clock, std::move(changed), std::move(told));
    auto server = PlcServer::start(impl->context.get_executor(), options.server, *impl, clock);
    if (!server) return tl::unexpected(server.error());
    impl->server = std::move(*server);
    impl->port = impl->server->port();
    impl->thread = std::thread([at = impl.get()] {
        at->tick();
        at->context.run();
    });
    return std::unique_ptr<CellFront>(new CellFront(std::move(impl)));
}

void CellFront::recorded() {
    impl_->post([at = impl_.get()] { at->cell.recorded(); });
}

void CellFront::rejected_for_certain(std::size_t section, core::Duration arrived) {
    impl_->post([at = impl_.get(), section, arrived] {
        const bool news = !at->cell.view().rejected_for_certain;
        at->cell.rejected_for_certain(section);
        if (news && at->told) at->told(at->clock.now() - arrived);
    });
}

void CellFront::progress(double share, std::size_t section) {
    impl_->post([at = impl_.get(), share, section] { at->cell.progress(share, section); });
}

void CellFront::held(Reason reason) {
    impl_->post([at = impl_.get(), reason] { at->cell.held(reason); });
}

void CellFront::ended(const Outcome& outcome) {
    impl_->post([at = impl_.get(), outcome] { at->cell.ended(outcome); });
}

void CellFront::shut_down() {
    impl_->post([at = impl_.get()] { at->cell.shut_down(); });
}

std::uint16_t CellFront::port() const {
    return impl_->port;
}

CellView CellFront::view() const {
    const std::lock_guard guard(impl_->mutex);
    return impl_->view;
}

PlcServerCounts CellFront::counts() const {
    const std::lock_guard guard(impl_->mutex);
    return impl_->counts;
}

}  // namespace cmm::cell
