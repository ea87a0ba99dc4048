// SPDX-License-Identifier: Apache-2.0
#include "drivers/modbus/modbus_port.hpp"

#include <unistd.h>

#include <algorithm>
#include <boost/asio/buffer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <utility>

#include "drivers/as_result.hpp"
#include "drivers/modbus/make_link.hpp"

namespace cmm::drivers::modbus {
namespace {

namespace asio = boost::asio;
using Outcome = Transaction::Outcome;

constexpr double first_modbus_backoff_ms = 2.0;
constexpr double longest_modbus_backoff_ms = 100.0;
constexpr int first_questions = 3;  // who is there; one may get lost like any other
constexpr std::int64_t usual_in_flight = 32;

BusOptions bus_options(const LinkSettings& settings, const RegisterMap& map) {
    BusOptions options;
    options.stop_address = map.stop.address;
    options.connect_timeout_ms = settings.connect_timeout_ms;
    options.stop_timeout_ms = settings.response_timeout_ms;
    return options;
}

/// Replies on a serial line name no request, behind a gateway neither.
std::size_t most_in_flight(const Endpoint& endpoint) {
    return endpoint.scheme == "modbus+tcp" ? static_cast<std::size_t>(endpoint.integer("in_flight", usual_in_flight))
                                           : 1;
}

}  // namespace

ModbusPort::ModbusPort(const LinkSettings& settings, RegisterMap map, const DriverContext& context)
    : map_(std::move(map)),
      reconnect_ms_(settings.reconnect_ms),
      settings_timeout_ms_(settings.response_timeout_ms),
      timeout_ms_(settings.response_timeout_ms),
      where_(settings.endpoint.place()),
      clock_(context.clock),
      rng_(core::Rng::keyed(context.seed, 1, 0)),
      executor_(context.executor),
      turn_(context.executor, asio::steady_timer::time_point::max()),
      in_flight_(most_in_flight(settings.endpoint)),
      windows_(in_flight_.most()),
      exchanges_(in_flight_.most()),
      bus_(make_link(settings.endpoint), bus_options(settings, map_)),
      done_(context.executor, ::dup(bus_.done_fd())) {
    identity_.kind = Transaction::Kind::read;
    identity_.read_address = map_.identity.address;
    identity_.read_count = map_.identity.length;
    command_.kind = Transaction::Kind::write;
    command_.write_address = map_.command.address;
    command_.write_count = map_.command.length;
    command_.alone = true;  // what follows tells of it
    for (Transaction& window : windows_) {
        window.kind = Transaction::Kind::write;
        window.write_address = map_.path.address;
    }
    for (Transaction& exchange : exchanges_) {
        exchange.kind = Transaction::Kind::exchange;
        exchange.write_address = map_.exchange.address;
        exchange.write_count = exchange_length;
        exchange.read_address = map_.fifo.address;
        exchange.read_count = map_.fifo.length;
        exchange.check = &check_fifo;
    }
    status_.kind = Transaction::Kind::read;
    status_.read_address = map_.status.address;
    status_.read_count = map_.status.length;
    status_.check = &check_status;
    open_.reserve(2 * in_flight_.most() + 2);
}

asio::awaitable<void> ModbusPort::acquire() {
    while (taken_)
        co_await turn_.async_wait(as_result);
    taken_ = true;
}

void ModbusPort::release() {
    taken_ = false;
    turn_.cancel_one();
}

asio::awaitable<void> ModbusPort::job_done() {
    std::uint64_t count = 0;
    co_await done_.async_read_some(asio::buffer(&count, sizeof count), as_result);
}

asio::awaitable<void> ModbusPort::pause(double ms) {
    asio::steady_timer timer(executor_);
    timer.expires_after(core::from_ms(ms));
    co_await timer.async_wait(as_result);
}

/// Two replies may get lost (and the link be renewed, or a late reply be waited for) before the controller's watchdog
/// stops the machine.
double ModbusPort::timeout_for(double watchdog_ms) const {
    if (!(watchdog_ms > 0.0)) return settings_timeout_ms_;
    return std::min(settings_timeout_ms_, watchdog_ms / (bus_.overlaps() ? 3.0 : 5.0));
}

/// A slow line must carry the longest round (path window, samples, status) well within the watchdog time.
core::Status ModbusPort::check_speed(double watchdog_ms) const {
    constexpr std::size_t frames = 3 * (max_frame - max_pdu) + 40;  // of three requests and replies, and their heads
    const std::size_t registers = max_write + exchange_length + map_.fifo.length + std::size_t{map_.status.length};
    const double round_ms = bus_.wire_ms(2 * registers + frames);
    if (!(watchdog_ms > 0.0) || round_ms <= 0.8 * watchdog_ms) return {};
    return core::fail(core::ErrorCode::protocol_mismatch,
                      "the line at " + where_ + " is too slow: path points, samples and status take " +
                          std::to_string(static_cast<int>(round_ms)) +
                          " ms, and the machine stops when it hears nothing for " +
                          std::to_string(static_cast<int>(watchdog_ms)) + " ms; raise the baud rate");
}

asio::awaitable<core::Result<Capabilities>> ModbusPort::open() {
    co_await acquire();
    opened_ = false;
    in_flight_.begin_anew();
    core::Result<Capabilities> found = core::fail(core::ErrorCode::transport_connect, "");
    for (int asked = 0; asked < first_questions && !found && core::retryable(found.error().code); ++asked) {
        bus_.connect();
        co_await job_done();
        if (!bus_.connected()) {
            found = core::fail(core::ErrorCode::transport_connect, bus_.connect_error());
            break;
        }
        found = co_await read_identity();
    }
    if (found) {
        const auto fast_enough = check_speed(found->watchdog_ms);
        if (!fast_enough) found = tl::unexpected(fast_enough.error());
    }
    if (found) {
        opened_ = true;
        link_number_ = bus_.link_number();
        boot_id_ = found->boot_id;
        lsb_mm_ = found->lsb_mm;
        timeout_ms_ = timeout_for(found->watchdog_ms);
    }
    release();
    co_return found;
}

/// The bus is ours and connected.
asio::awaitable<core::Result<Capabilities>> ModbusPort::read_identity() {
    bus_.run(identity_batch_, settings_timeout_ms_);
    co_await job_done();
    switch (identity_.outcome) {
        case Outcome::ok:
            last_answer_ms_ = now_ms();
            break;
        case Outcome::exception:
            if (identity_.exception == exception_code::busy)
                co_return core::fail(core::ErrorCode::transport_timeout,
                                     where_ + " is busy and does not say who it is");
            co_return core::fail(core::ErrorCode::protocol_mismatch,
                                 where_ + " has no identity registers (exception " +
                                     std::to_string(identity_.exception) +
                                     "): it is no controller of the register map \"" + map_.name + "\"");
        case Outcome::timeout:
            co_return core::fail(core::ErrorCode::transport_timeout,
                                 where_ + (bus_.overlaps() ? " accepts the connection but does not answer"
                                                           : ": nobody answers (check wiring, baud, parity and unit)"));
        case Outcome::invalid:
            co_return core::fail(
                core::ErrorCode::protocol_invalid,
                where_ + (bus_.overlaps() ? " answers with something else than Modbus"
                                          : ": bytes come, but no Modbus RTU (check baud and parity)"));
        default:
            co_return core::fail(core::ErrorCode::transport_closed, where_ + " closed the connection");
    }
    auto found = decode_identity(map_, identity_.reply());
    if (!found) found.error().with_context("at " + where_);
    co_return found;
}

/// After a broken link, or one that the bus renewed to bring a stop through: the same controller must answer.
asio::awaitable<core::Status> ModbusPort::verify() {
    bus_.count([](LinkStats& stats) { ++stats.reconnects; });
    const auto found = co_await read_identity();
    if (!found) co_return tl::unexpected(found.error());
    link_number_ = bus_.link_number();
    if (found->boot_id == boot_id_) co_return core::Status{};
    opened_ = false;
    co_return core::fail(core::ErrorCode::machine_fault, "the controller at " + where_ + " was restarted (boot id " +
                                                             std::to_string(boot_id_) + ", now " +
                                                             std::to_string(found->boot_id) +
                                                             "): samples it had not yet delivered are lost");
}

asio::awaitable<core::Status> ModbusPort::attempt(std::size_t in_flight) {
    if (!bus_.connected() || timeouts_in_row_ >= 2) {
        timeouts_in_row_ = 0;
        bus_.connect();
        co_await job_done();
        if (!bus_.connected()) co_return core::fail(core::ErrorCode::transport_connect, bus_.connect_error());
    }
    if (bus_.link_number() != link_number_) {
        const auto verified = co_await verify();
        if (!verified) co_return verified;
    }
    for (Transaction* transaction : open_) {
        // Repeated or not, each exchange must look alive to the controller.
        if (transaction->kind == Transaction::Kind::exchange)
            transaction->written[map_.exchange.watchdog] = ++watchdog_;
    }
    bus_.run(open_, timeout_ms_, in_flight);
    co_await job_done();
    if (in_flight > 1) weigh_batch();
    co_return judge();
}

/// Whether the controller takes what is sent ahead of its replies.
void ModbusPort::weigh_batch() {
    Batch batch;
    for (const Transaction* transaction : open_) {
        if (transaction->alone || transaction->outcome == Outcome::not_sent) continue;
        ++batch.sent;
        const bool answered = transaction->outcome == Outcome::ok || transaction->outcome == Outcome::exception;
        batch.answered += answered ? 1 : 0;
    }
    if (batch.sent < 2) return;
    batch.stale_before = bus_.stats().stale;
    const bool half = batch.answered > 0 && batch.answered < batch.sent && bus_.connected();
    if (half) {
        half_answered_ = batch;
    } else {
        conclude(batch);
    }
}

/// Half answered, or only late? The late replies have come when those to the repetition have.
void ModbusPort::weigh_half_answered() {
    const Batch batch = std::exchange(half_answered_, {});
    if (batch.sent == 0 || bus_.stats().stale > batch.stale_before) return;
    bus_.count([](LinkStats& stats) { ++stats.half_answered; });
    conclude(batch);
}

void ModbusPort::conclude(const Batch& batch) {
    if (!in_flight_.judge(batch.sent, batch.answered, bus_.connected(), bus_.service_ms())) return;
    bus_.note(where_ + " does not answer requests that come together: from now on they are sent one at a time" +
              " (slow on a distant link; in_flight=1 in the url does so from the beginning)");
}

/// Takes the answered transactions off the list; the first that failed says why.
core::Status ModbusPort::judge() {
    core::Status status;
    const std::size_t asked = open_.size();
    const auto answered = [&](Transaction* transaction) {
        auto fits = judge(*transaction);
        if (!fits && status) status = fits;
        return fits.has_value();
    };
    std::erase_if(open_, answered);
    if (open_.size() < asked) {
        last_answer_ms_ = now_ms();
        timeouts_in_row_ = 0;
    }
    const bool late = std::any_of(open_.begin(), open_.end(),
                                  [](const Transaction* open) { return open->outcome == Outcome::timeout; });
    if (late) ++timeouts_in_row_;
    return status;
}

core::Status ModbusPort::judge(Transaction& transaction) {
    if (transaction.outcome == Outcome::ok) {
        auto sound = transaction.check == nullptr ? core::Status{} : transaction.check(map_, transaction.reply());
        if (sound) return sound;
        transaction.outcome = Outcome::invalid;
        bus_.count([](LinkStats& stats) { ++stats.invalid; });
        return sound;
    }
    if (transaction.outcome == Outcome::exception) {
        if (transaction.check == nullptr) return {};
        // Neither may be refused; a controller that was restarted refuses the samples that we acknowledge.
        link_number_ = 0;
        const bool samples = transaction.kind == Transaction::Kind::exchange;
        return core::fail(core::ErrorCode::protocol_invalid,
                          where_ + " refuses " + (samples ? "the sample exchange" : "the status registers") +
                              " with exception " + std::to_string(transaction.exception));
    }
    if (transaction.outcome == Outcome::timeout) {
        return core::fail(core::ErrorCode::transport_timeout,
                          where_ + " did not answer within " + std::to_string(static_cast<int>(timeout_ms_)) + " ms");
    }
    if (transaction.outcome == Outcome::invalid) {
        return core::fail(core::ErrorCode::protocol_invalid, where_ + " sent a reply that does not fit the request");
    }
    return core::fail(core::ErrorCode::transport_closed, "the connection to " + where_ + " broke");
}

/// Of the windows and of the blocks only the first that is not answered is repeated, so that a repetition takes no
/// longer than without anything in flight (the watchdog!). The rest is asked for in another round.
void ModbusPort::drop_what_was_sent_ahead() {
    bool window = false;
    bool block = false;
    std::erase_if(open_, [&](const Transaction* open) {
        if (open == &command_ || open == &status_) return false;
        return std::exchange(open->kind == Transaction::Kind::exchange ? block : window, true);
    });
}

/// Repeats the open transactions until each is answered.
asio::awaitable<core::Status> ModbusPort::repeat() {
    core::Status status;
    double give_up_ms = 0.0;
    double backoff_ms = first_modbus_backoff_ms;
    std::size_t in_flight = in_flight_.allowed();
    for (;;) {
        status = co_await attempt(in_flight);
        if (status || !core::retryable(status.error().code)) co_return status;
        const double now = now_ms();
        if (give_up_ms == 0.0) give_up_ms = now + reconnect_ms_;
        if (now >= give_up_ms) co_return status;
        bus_.count([](LinkStats& stats) { ++stats.retries; });
        drop_what_was_sent_ahead();
        in_flight = 1;
        co_await pause(backoff_ms * rng_.uniform(0.5, 1.0));
        backoff_ms = std::min(2.0 * backoff_ms, longest_modbus_backoff_ms);
    }
}

asio::awaitable<core::Status> ModbusPort::run(controller::Round& round) {
    co_await acquire();
    core::Status status;
    if (opened_) {
        prepare(round);
        status = co_await repeat();
        weigh_half_answered();
        if (status) settle(round);
    } else {
        status = core::fail(core::ErrorCode::transport_closed, "not connected to " + where_);
    }
    release();
    co_return status;
}

void ModbusPort::prepare(const controller::Round& round) {
    open_.clear();
    if (round.command != nullptr) {
        encode(map_, *round.command, command_.to_write());
        open_.push_back(&command_);
    }
    for (std::size_t k = 0; k < round.windows.size(); ++k) {
        Transaction& window = windows_.at(k);
        window.write_count =
            static_cast<std::uint16_t>(encode_window(map_, round.windows[k].window, lsb_mm_, window.written));
        open_.push_back(&window);
    }
    for (std::size_t k = 0; k < round.blocks.size(); ++k) {
        Transaction& exchange = exchanges_.at(k);
        map_.put_u32(exchange.to_write(), map_.exchange.ack_seq, round.blocks[k].acknowledge);
        map_.put_u32(exchange.to_write(), map_.exchange.from_seq, round.blocks[k].from);
        open_.push_back(&exchange);
    }
    if (round.ask_status) open_.push_back(&status_);
    for (Transaction* transaction : open_)
        transaction->outcome = Outcome::not_sent;  // what the last round left would pass for an answer
}

/// Reads the answers into the round.
void ModbusPort::settle(controller::Round& round) const {
    const auto fate_of = [&](const Transaction& asked) {
        if (asked.outcome == Outcome::ok) return controller::Round::Fate::done;
        if (asked.outcome != Outcome::exception) return controller::Round::Fate::not_asked;
        if (round.refusal.empty()) round.refusal = "exception " + std::to_string(asked.exception);
        const bool busy = asked.exception == exception_code::busy;
        return busy ? controller::Round::Fate::busy : controller::Round::Fate::refused;
    };
    round.refusal.clear();
    if (round.command != nullptr) round.command_fate = fate_of(command_);
    for (std::size_t k = 0; k < round.windows.size(); ++k)
        round.windows[k].fate = fate_of(windows_[k]);
    for (std::size_t k = 0; k < round.blocks.size(); ++k) {
        controller::Round::BlockTurn& turn = round.blocks[k];
        turn.answered = exchanges_[k].outcome == Outcome::ok;
        if (!turn.answered) continue;
        turn.block = decode_fifo(map_, exchanges_[k].reply());
        decode_samples(map_, exchanges_[k].reply(), turn.block, turn.samples);
    }
    if (round.ask_status) round.status = decode_status(map_, status_.reply());
}

double ModbusPort::status_every_ms() const noexcept {
    return bus_.overlaps() ? 20.0 : 200.0;  // on a slow line it costs the time of ten samples
}

}  // namespace cmm::drivers::modbus
