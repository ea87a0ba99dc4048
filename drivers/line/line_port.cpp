// SPDX-License-Identifier: Apache-2.0
#include "drivers/line/line_port.hpp"

#include <algorithm>
#include <atomic>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <chrono>
#include <functional>
#include <string>
#include <thread>
#include <utility>

#include "core/rng.hpp"
#include "drivers/as_result.hpp"
#include "drivers/controller/controller_machine.hpp"
#include "drivers/line/conversation.hpp"
#include "drivers/line/line_messages.hpp"

namespace cmm::drivers::line {
namespace {

namespace asio = boost::asio;
using controller::Round;
using Steady = std::chrono::steady_clock;

constexpr double first_backoff_ms = 2.0;
constexpr double longest_backoff_ms = 100.0;
// A stop waits for the text being written: neither it nor a reply may keep the line for longer.
constexpr double longest_on_line_ms = 60.0;
constexpr std::size_t bytes_per_point = 55;
constexpr std::size_t bytes_per_sample = 8;
constexpr std::size_t longest_status = 260;
constexpr std::string_view busy_code = "6";

enum class Question : std::uint8_t { identity, command, window, samples, status };

/// As many as fit into the longest time on the line.
std::size_t fitting(double byte_ms, std::size_t bytes_each, std::size_t most) {
    const double room = longest_on_line_ms / (byte_ms * static_cast<double>(bytes_each));
    return std::clamp<std::size_t>(static_cast<std::size_t>(room), 1, most);
}

}  // namespace

/// One question at a time: a round has one window and one block at most (Port::reach). Everything but the atomics
/// belongs to the thread of `io_`.
class LinePort::Impl {
  public:
    Impl(const LinkSettings& settings, const DriverContext& context)
        : executor_(context.executor),
          clock_(context.clock),
          serial_(SerialSettings::of(settings.endpoint, Parity::none)),
          settings_timeout_ms_(settings.response_timeout_ms),
          timeout_ms_(settings.response_timeout_ms),
          reconnect_ms_(settings.reconnect_ms),
          rng_(core::Rng::keyed(context.seed, 1, 0)) {
        thread_ = std::thread([this] { io_.run(); });
    }
    ~Impl() {
        io_.stop();
        thread_.join();
    }
    Impl(const Impl&) = delete;
    Impl& operator=(const Impl&) = delete;

    asio::awaitable<core::Result<Capabilities>> open();
    asio::awaitable<core::Status> serve(Round& round);
    void want_stop(int kind, Steady::time_point requested);
    double now_ms() const { return core::seconds(clock_.now()) * 1e3; }

    asio::any_io_executor executor_;
    const core::Clock& clock_;
    SerialSettings serial_;
    asio::io_context io_{1};
    Conversation conversation_{io_, serial_};
    std::atomic<bool> opened_{false};
    std::atomic<double> last_answer_ms_{0.0};

  private:
    asio::awaitable<void> acquire();
    void release();
    asio::awaitable<core::Result<Message>> ask(Question question, const Round& round);
    asio::awaitable<core::Status> answer(Question question, Round& round);
    asio::awaitable<core::Status> persist(Question question, Round& round);
    asio::awaitable<core::Status> reopen();
    asio::awaitable<core::Result<Capabilities>> read_identity();
    asio::awaitable<void> wait(double ms);
    std::string wording(Question question, const Round& round);
    std::size_t longest_reply(Question question) const;
    core::Status settle(Question question, const Message& message, Round& round);
    core::Status settle_refusal(Question question, const Message& message, Round& round);
    core::Status check_boot(std::uint16_t boot_id);
    std::size_t samples_per_frame() const { return fitting(serial_.byte_ms(), bytes_per_sample, 64); }

    double settings_timeout_ms_, timeout_ms_, reconnect_ms_;
    core::Rng rng_;
    asio::executor_work_guard<asio::io_context::executor_type> work_{io_.get_executor()};
    asio::steady_timer turn_{io_, Steady::time_point::max()};
    bool taken_ = false;
    std::uint16_t watchdog_ = 0;
    double lsb_mm_ = 0.0;
    std::uint32_t boot_id_ = 0;
    bool stop_matters_ = false;  // before the first connection there is nobody to stop
    std::thread thread_;         // last: everything else exists when it starts
};

asio::awaitable<void> LinePort::Impl::acquire() {
    while (taken_)
        co_await turn_.async_wait(as_result);
    taken_ = true;
}

void LinePort::Impl::release() {
    taken_ = false;
    turn_.cancel_one();
}

asio::awaitable<void> LinePort::Impl::wait(double ms) {
    asio::steady_timer timer(io_);
    timer.expires_after(core::from_ms(ms));
    co_await timer.async_wait(as_result);
}

std::string LinePort::Impl::wording(Question question, const Round& round) {
    switch (question) {
        case Question::identity:
            return "ID";
        case Question::command:
            return command_body(*round.command);
        case Question::window:
            return window_body(round.windows.front().window, lsb_mm_);
        case Question::samples:  // repeated or not, each must look alive to the controller
            return "SA " + std::to_string(++watchdog_) + " " + std::to_string(round.blocks.front().acknowledge) + " " +
                   std::to_string(round.blocks.front().from) + " " + std::to_string(samples_per_frame());
        case Question::status:
            return "ST";
    }
    return {};
}

std::size_t LinePort::Impl::longest_reply(Question question) const {
    return question == Question::samples ? 64 + bytes_per_sample * samples_per_frame() : longest_status;
}

asio::awaitable<core::Result<Message>> LinePort::Impl::ask(Question question, const Round& round) {
    std::function<std::string()> body = [&] { return wording(question, round); };
    auto message = co_await conversation_.ask(std::move(body), longest_reply(question), timeout_ms_);
    if (message) last_answer_ms_ = now_ms();
    co_return message;
}

core::Status LinePort::Impl::check_boot(std::uint16_t boot_id) {
    if (boot_id == boot_id_) return {};
    opened_ = false;
    return core::fail(core::ErrorCode::machine_fault,
                      "the controller at " + serial_.device + " was restarted (boot id " + std::to_string(boot_id_) +
                          ", now " + std::to_string(boot_id) + "): samples it had not yet delivered are lost");
}

core::Status LinePort::Impl::settle_refusal(Question question, const Message& message, Round& round) {
    round.refusal = "code " + message.text;
    const auto fate = message.text == busy_code ? Round::Fate::busy : Round::Fate::refused;
    if (question == Question::command) {
        round.command_fate = fate;
    } else if (question == Question::window) {
        round.windows.front().fate = fate;
    } else {
        return core::fail(core::ErrorCode::protocol_invalid, "the controller refuses a question with " + round.refusal);
    }
    return {};
}

core::Status LinePort::Impl::settle(Question question, const Message& message, Round& round) {
    if (message.kind == Message::Kind::refusal) return settle_refusal(question, message, round);
    const bool fits = (message.kind == Message::Kind::samples) == (question == Question::samples);
    if (!fits) return core::fail(core::ErrorCode::protocol_invalid, "the answer is not of the kind that was asked for");
    if (question == Question::samples) {
        auto samples = decode_samples(message.payload);
        if (!samples) return tl::unexpected(samples.error());
        Round::BlockTurn& turn = round.blocks.front();
        turn.block = samples->block;
        turn.samples = std::move(samples->samples);
        turn.answered = true;
        return check_boot(samples->boot_id);
    }
    if (question == Question::status) {
        const auto status = decode_status(message.text);
        if (!status) return tl::unexpected(status.error());
        round.status = status->block;
        return check_boot(status->boot_id);
    }
    (question == Question::command ? round.command_fate : round.windows.front().fate) = Round::Fate::done;
    return {};
}

asio::awaitable<core::Status> LinePort::Impl::answer(Question question, Round& round) {
    if (!conversation_.is_open()) {
        const auto again = co_await reopen();
        if (!again) co_return again;
    }
    const auto message = co_await ask(question, round);
    if (!message) co_return tl::unexpected(message.error());
    const auto settled = settle(question, *message, round);
    if (settled || message->kind != Message::Kind::refusal) co_return settled;
    // A controller that was restarted does not know the samples that we acknowledge.
    const auto found = co_await read_identity();
    if (!found) co_return tl::unexpected(found.error());
    const auto same = check_boot(static_cast<std::uint16_t>(found->boot_id));
    co_return same ? settled : same;
}

asio::awaitable<core::Result<Capabilities>> LinePort::Impl::read_identity() {
    const Round nothing;
    const auto message = co_await ask(Question::identity, nothing);
    if (!message) co_return tl::unexpected(message.error());
    auto found = message->kind == Message::Kind::answer
                     ? decode_identity(message->text)
                     : core::Result<Capabilities>(
                           core::fail(core::ErrorCode::protocol_mismatch, "the device that answers does not know ID"));
    if (!found) found.error().with_context("at " + serial_.device);
    co_return found;
}

/// The port was lost, or answered no more: the same start of the same controller must answer.
asio::awaitable<core::Status> LinePort::Impl::reopen() {
    const std::string why = conversation_.open();
    if (!why.empty()) co_return core::fail(core::ErrorCode::transport_connect, why);
    conversation_.log().count([](LinkStats& stats) { ++stats.reconnects; });
    const auto found = co_await read_identity();
    if (!found) co_return tl::unexpected(found.error());
    co_return check_boot(static_cast<std::uint16_t>(found->boot_id));
}

asio::awaitable<core::Status> LinePort::Impl::persist(Question question, Round& round) {
    double give_up_ms = 0.0;
    double backoff_ms = first_backoff_ms;
    for (;;) {
        auto status = co_await answer(question, round);
        if (status || !core::retryable(status.error().code)) co_return status;
        const double now = now_ms();
        if (give_up_ms == 0.0) give_up_ms = now + reconnect_ms_;
        if (now >= give_up_ms) co_return status;
        const double pause_ms = backoff_ms * rng_.uniform(0.5, 1.0);
        co_await wait(pause_ms);
        backoff_ms = std::min(2.0 * backoff_ms, longest_backoff_ms);
    }
}

asio::awaitable<core::Status> LinePort::Impl::serve(Round& round) {
    co_await acquire();
    core::Status status;
    if (!opened_) status = core::fail(core::ErrorCode::transport_closed, "not connected to " + serial_.device);
    if (status && round.command != nullptr) status = co_await persist(Question::command, round);
    if (status && !round.windows.empty()) status = co_await persist(Question::window, round);
    if (status && !round.blocks.empty()) status = co_await persist(Question::samples, round);
    if (status && round.ask_status) status = co_await persist(Question::status, round);
    release();
    co_return status;
}

asio::awaitable<core::Result<Capabilities>> LinePort::Impl::open() {
    co_await acquire();
    opened_ = false;
    timeout_ms_ = settings_timeout_ms_;
    const std::string why = conversation_.open();
    core::Result<Capabilities> found = core::fail(core::ErrorCode::transport_connect, why);
    if (why.empty()) found = co_await read_identity();
    if (found) {
        opened_ = stop_matters_ = true;
        boot_id_ = found->boot_id;
        lsb_mm_ = found->lsb_mm;
        // Several replies may get lost before the controller's watchdog stops the machine. A question that is repeated
        // too early does no harm: its answer carries the same tag.
        if (found->watchdog_ms > 0.0) timeout_ms_ = std::min(settings_timeout_ms_, found->watchdog_ms / 10.0);
    }
    release();
    co_return found;
}

void LinePort::Impl::want_stop(int kind, Steady::time_point requested) {
    if (stop_matters_) conversation_.want_stop(kind, requested);
}

LinePort::LinePort(const LinkSettings& settings, const DriverContext& context)
    : impl_(std::make_unique<Impl>(settings, context)) {}
LinePort::~LinePort() = default;

asio::awaitable<core::Result<Capabilities>> LinePort::open() {
    auto work = impl_->open();
    co_return co_await asio::co_spawn(impl_->io_, std::move(work), asio::use_awaitable);
}

asio::awaitable<core::Status> LinePort::run(Round& round) {
    auto work = impl_->serve(round);
    co_return co_await asio::co_spawn(impl_->io_, std::move(work), asio::use_awaitable);
}

asio::awaitable<void> LinePort::pause(double ms) {
    asio::steady_timer timer(impl_->executor_);
    timer.expires_after(core::from_ms(ms));
    co_await timer.async_wait(as_result);
}

std::size_t LinePort::window_limit() const noexcept {
    return fitting(impl_->serial_.byte_ms(), bytes_per_point, window_points);
}
core::Status LinePort::check_point(const PathPoint& point, std::uint64_t index, double lsb_mm) const {
    return line::check_point(point, index, lsb_mm);
}
bool LinePort::opened() const noexcept {
    return impl_->opened_;
}
double LinePort::now_ms() const noexcept {
    return impl_->now_ms();
}
double LinePort::last_answer_ms() const noexcept {
    return impl_->last_answer_ms_;
}

void LinePort::stop(StopKind kind) noexcept {
    const int wanted = kind == StopKind::emergency ? 2 : 1;
    const auto requested = Steady::now();
    try {
        asio::post(impl_->io_, [impl = impl_.get(), wanted, requested] { impl->want_stop(wanted, requested); });
    } catch (...) {  // no memory for a message: the controller's watchdog is left
    }
}

LinkStats LinePort::stats() const {
    return impl_->conversation_.log().stats();
}
void LinePort::count(const std::function<void(LinkStats&)>& change) {
    impl_->conversation_.log().count(change);
}
void LinePort::set_trace(std::function<void(std::string_view)> line) {
    impl_->conversation_.log().set_trace(std::move(line));
}

core::Result<std::unique_ptr<Machine>> make_line_machine(const LinkSettings& settings, const DriverContext& context) {
    if (settings.endpoint.word("pty", "no") == "yes") {
        return core::fail(core::ErrorCode::usage,
                          "endpoint \"" + settings.endpoint.text() + "\": pty=yes is for listeners; leave it out here");
    }
    return controller::make_controller_machine(std::make_unique<LinePort>(settings, context), settings.poll_ms,
                                               context);
}

}  // namespace cmm::drivers::line
