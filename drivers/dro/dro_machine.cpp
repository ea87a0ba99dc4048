// SPDX-License-Identifier: Apache-2.0
#include "drivers/dro/dro_machine.hpp"

#include <atomic>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <limits>
#include <string>
#include <utility>

#include "drivers/dro/dro_reader.hpp"
#include "drivers/dro/line_format.hpp"
#include "drivers/occupied.hpp"
#include "drivers/until_durable.hpp"

namespace cmm::drivers::dro {
namespace {

namespace asio = boost::asio;
using core::ErrorCode;
using core::Result;
using core::Status;

constexpr auto look_every = std::chrono::milliseconds(2);  // a person takes a few points a second
constexpr double reopen_every_ms = 100.0;

Status cannot_move() {
    return core::fail(ErrorCode::machine_refused,
                      "this machine cannot move: a person moves it, the host only listens (dro+serial)",
                      core::Motion::not_concerned);
}

class DroMachine final : public Machine {
  public:
    DroMachine(const LinkSettings& settings, LineFormat format, const DriverContext& context)
        : settings_(settings),
          clock_(context.clock),
          timer_(context.executor),
          reader_(SerialSettings::of(settings.endpoint, Parity::none), std::move(format), context.clock) {}

    asio::awaitable<Result<Capabilities>> connect() override;
    asio::awaitable<Result<RunOrigin>> begin_run(std::optional<RunOrigin> resume) override;
    asio::awaitable<Status> end_run() override { co_return Status{}; }
    asio::awaitable<Status> home() override { co_return cannot_move(); }
    asio::awaitable<Status> qualify(double /*ball_radius_mm*/) override { co_return cannot_move(); }
    asio::awaitable<Status> move(Eigen::Vector3d /*centre_mm*/, double /*speed_mm_s*/) override {
        co_return cannot_move();
    }
    asio::awaitable<Result<Eigen::Vector3d>> touch(Eigen::Vector3d /*target_mm*/, double /*speed_mm_s*/,
                                                   double /*retract_mm*/, SampleSink& /*sink*/) override {
        co_return tl::unexpected(cannot_move().error());
    }
    asio::awaitable<Result<ScanResult>> scan(ScanPath /*path*/, PathSource& /*source*/, SampleSink& /*sink*/) override {
        co_return tl::unexpected(cannot_move().error());
    }
    asio::awaitable<Result<ScanResult>> receive(ScanPath path, HandSink& sink) override;
    void tell(HandSignal signal) noexcept override;
    asio::awaitable<Result<std::uint64_t>> drain(SampleSink& /*sink*/) override { co_return sequence_; }
    asio::awaitable<Result<MachineStatus>> state() override;
    asio::awaitable<Status> clear_fault(bool /*emergency_released*/) override;
    void stop(StopKind kind) noexcept override;
    LinkStats link_stats() const override { return reader_.log().stats(); }
    void set_trace(std::function<void(std::string_view)> line) override { reader_.log().set_trace(std::move(line)); }

  private:
    asio::awaitable<Status> keep_open();
    asio::awaitable<void> pause();
    Status hear(const Heard& heard, const ScanPath& path, HandSink& sink, ScanResult& result);
    void ask_for_points();
    bool ended() const { return section_ended_ || stopped_; }
    double now_ms() const { return 1e3 * core::seconds(clock_.now()); }

    LinkSettings settings_;
    const core::Clock& clock_;
    asio::steady_timer timer_;
    DroReader reader_;
    bool occupied_ = false;
    std::atomic<bool> section_ended_{false}, stopped_{false};
    std::atomic<unsigned> points_wanted_{0};
    double request_due_ms_ = 0.0;
    core::Duration begun_{};
    std::uint64_t sequence_ = 0;
    std::uint16_t path_ = 0;
    std::array<std::int32_t, 3> counts_{};
};

asio::awaitable<Result<Capabilities>> DroMachine::connect() {
    if (auto opened = reader_.open(); !opened) co_return tl::unexpected(opened.error());
    begun_ = clock_.now();
    Capabilities machine;
    machine.model = "digital readout";
    machine.serial = settings_.endpoint.path;
    machine.moves = false;
    machine.lsb_mm = settings_.dro.lsb_mm();
    const double reach_mm = machine.lsb_mm * std::numeric_limits<std::int32_t>::max();
    machine.limit_min_mm.setConstant(-reach_mm);
    machine.limit_max_mm.setConstant(reach_mm);
    co_return machine;
}

asio::awaitable<Result<RunOrigin>> DroMachine::begin_run(std::optional<RunOrigin> resume) {
    if (occupied_) co_return tl::unexpected(busy_error());
    sequence_ = resume ? resume->last_sequence : 0;
    reader_.forget();
    co_return RunOrigin{0, 0, sequence_};
}

asio::awaitable<void> DroMachine::pause() {
    timer_.expires_after(look_every);
    co_await timer_.async_wait(asio::use_awaitable);
}

/// A plug that was pulled is waited for as long as the settings say.
asio::awaitable<Status> DroMachine::keep_open() {
    if (!reader_.lost()) co_return Status{};
    const double give_up_ms = now_ms() + settings_.reconnect_ms;
    double due_ms = now_ms();
    while (!ended()) {
        if (now_ms() >= due_ms) {
            const auto opened = reader_.open();
            if (opened) {
                reader_.log().count([](LinkStats& stats) { ++stats.reconnects; });
                co_return Status{};
            }
            if (now_ms() >= give_up_ms) {
                co_return core::fail(ErrorCode::transport_closed, "the port is gone: " + opened.error().message,
                                     core::Motion::not_concerned);
            }
            due_ms = now_ms() + reopen_every_ms;
        }
        co_await pause();
    }
    co_return Status{};
}

void DroMachine::ask_for_points() {
    const auto& dro = settings_.dro;
    unsigned wanted = points_wanted_.exchange(0);
    if (dro.request.empty()) return;
    if (dro.request_every_ms > 0.0 && now_ms() >= request_due_ms_) {
        request_due_ms_ = now_ms() + dro.request_every_ms;
        ++wanted;
    }
    for (; wanted > 0; --wanted)
        reader_.send(dro.request);
}

Status DroMachine::hear(const Heard& heard, const ScanPath& path, HandSink& sink, ScanResult& result) {
    switch (heard.content.kind) {
        case LineContent::Kind::no_point:
            return {};
        case LineContent::Kind::end:
            section_ended_ = true;
            return {};
        case LineContent::Kind::garbled:
            sink.on_garbled(heard.text, heard.content.why);
            return {};
        case LineContent::Kind::point:
            break;
    }
    core::Sample sample;
    sample.sequence = ++sequence_;
    sample.machine_time_us = std::chrono::duration_cast<std::chrono::microseconds>(heard.at - begun_).count();
    sample.host_time_ns = heard.at.count();
    sample.counts = counts_ = heard.content.counts;
    sample.path = path.id;
    if (result.first_sequence == 0) result.first_sequence = sample.sequence;
    result.last_sequence = sample.sequence;
    ++result.points_passed;
    return sink.on_samples(std::span(&sample, 1));
}

asio::awaitable<Result<ScanResult>> DroMachine::receive(ScanPath path, HandSink& sink) {
    if (occupied_) co_return tl::unexpected(busy_error());
    const Occupied occupied(occupied_);
    ScanResult result;
    path_ = path.id;
    section_ended_ = false;
    while (!ended()) {
        ask_for_points();
        bool silent = true;
        // One by one: with the point that closes the section the rest belongs to the next one.
        for (auto heard = reader_.next(); heard; heard = ended() ? std::nullopt : reader_.next()) {
            silent = false;
            if (auto taken = hear(*heard, path, sink, result); !taken) co_return tl::unexpected(taken.error());
        }
        if (!silent) continue;
        // Only now: what was heard before the port went is heard out.
        if (auto open = co_await keep_open(); !open) {
            core::Error error = std::move(open.error());
            co_return tl::unexpected(std::move(error));
        }
        co_await pause();
    }
    if (auto kept = co_await until_durable(sink); !kept) co_return tl::unexpected(kept.error());
    co_return result;
}

void DroMachine::tell(HandSignal signal) noexcept {
    if (signal == HandSignal::take_point) ++points_wanted_;
    if (signal == HandSignal::end_section) section_ended_ = true;
}

asio::awaitable<Result<MachineStatus>> DroMachine::state() {
    MachineStatus status;
    status.homed = status.qualified = status.owned = status.owned_by_us = true;
    const double lsb_mm = settings_.dro.lsb_mm();
    status.position_mm = Eigen::Vector3d(counts_[0], counts_[1], counts_[2]) * lsb_mm;
    status.path = path_;
    status.newest_sequence = status.acknowledged_sequence = sequence_;
    co_return status;
}

asio::awaitable<Status> DroMachine::clear_fault(bool /*emergency_released*/) {
    stopped_ = false;
    co_return Status{};
}

void DroMachine::stop(StopKind /*kind*/) noexcept {
    stopped_ = true;
    reader_.log().count([](LinkStats& stats) { ++stats.stops; });
}

}  // namespace

Result<std::unique_ptr<Machine>> make_dro_machine(const LinkSettings& settings, const DriverContext& context) {
    if (settings.endpoint.word("pty", "no") == "yes")
        return core::fail(ErrorCode::usage, "pty=yes is for `cmmlive sim --listen`: a host opens a port that is there");
    auto format = LineFormat::compile(settings.dro);
    if (!format) return tl::unexpected(format.error());
    return std::make_unique<DroMachine>(settings, std::move(*format), context);
}

}  // namespace cmm::drivers::dro
