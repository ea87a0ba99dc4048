// SPDX-License-Identifier: Apache-2.0
#include "drivers/modbus/conversation.hpp"

#include <poll.h>

#include <algorithm>
#include <array>

#include "core/clock.hpp"

namespace cmm::drivers::modbus {
namespace {

using SteadyClock = std::chrono::steady_clock;
using Outcome = Transaction::Outcome;

// On a link that carries one request at a time. After a stop was asked for, the reply under way is waited for so long
// and its time on the line: the stop is on the wire within 250 ms from 19200 baud on, and does not meet the reply.
constexpr double patience_before_stop_ms = 60.0;
constexpr double stop_reply_ms = 100.0;
constexpr int stop_attempts = 4;

std::int64_t now_ns() noexcept {
    return SteadyClock::now().time_since_epoch().count();
}

}  // namespace

void Conversation::connect() {
    open_link();
    stop_matters_ = true;
}

void Conversation::run(std::span<Transaction* const> batch, double timeout_ms) {
    for (Transaction* transaction : batch)
        transaction->outcome = Outcome::not_sent;
    for (Transaction* transaction : batch) {
        let_late_reply_pass();
        serve_stop();
        execute(*transaction, timeout_ms);
        if (transaction->outcome != Outcome::ok && transaction->outcome != Outcome::exception) return;
    }
}

void Conversation::execute(Transaction& transaction, double timeout_ms) {
    if (!link_->is_open()) {
        transaction.outcome = Outcome::closed;
        return;
    }
    const auto started = SteadyClock::now();
    const std::uint16_t id = ++last_id_;
    transaction.outcome = send(transaction, id);
    const auto patience = core::from_ms(timeout_ms + wire_ms(transaction));
    if (transaction.outcome == Outcome::ok) await_reply(transaction, id, started + patience);
    const std::chrono::duration<double, std::micro> took = SteadyClock::now() - started;
    record(transaction.outcome, took.count());
    recover(transaction, patience);
}

/// Request and reply; the frame around either is at most as long as that of RTU.
double Conversation::wire_ms(const Transaction& transaction) const {
    std::array<std::uint8_t, max_pdu> pdu;
    return link_->wire_ms(encode_pdu(transaction, pdu) + reply_size(transaction) + 6);
}

void Conversation::recover(const Transaction& transaction, Duration patience) {
    const Outcome outcome = transaction.outcome;
    if (outcome == Outcome::closed) close_link();
    if (outcome == Outcome::invalid && link_->is_open() && !link_->resync()) close_link();
    // The reply to a write names its address: late or not, it passes for no other.
    const bool mistakable = !link_->overlaps() && transaction.read_count > 0;
    if (outcome == Outcome::timeout && mistakable) late_until_ = SteadyClock::now() + patience;
}

Transaction::Outcome Conversation::send(const Transaction& transaction, std::uint16_t id) {
    std::array<std::uint8_t, max_pdu> pdu;
    const auto bytes = link_->send(id, std::span(pdu).first(encode_pdu(transaction, pdu)));
    if (bytes.empty()) return Outcome::closed;
    log_.sent(bytes);
    return Outcome::ok;
}

/// Waits for something from the link, a message for this thread, or the deadline. True: ask the link.
bool Conversation::wait_for_link(TimePoint deadline) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline - SteadyClock::now()).count();
    const auto longest = link_->has_part() ? std::min<std::int64_t>(left, Link::rest_timeout_ms) : left;
    std::array<pollfd, 2> wait{{{link_->fd(), POLLIN, 0}, {wake_.fd(), POLLIN, 0}}};
    const int ready = ::poll(wait.data(), wait.size(), static_cast<int>(std::max<std::int64_t>(0, longest)));
    if (wait[1].revents != 0) wake_.clear();
    rest_is_missing_ = ready == 0 && link_->has_part();
    return wait[0].revents != 0;
}

/// Waits for the reply with this id; serves a stop meanwhile. Replies to requests given up earlier are counted and
/// dropped.
void Conversation::await_reply(Transaction& transaction, std::uint16_t id, TimePoint deadline) {
    const bool is_stop = stop_sent_ && id == stop_id_;
    const auto shortest_patience = core::from_ms(patience_before_stop_ms + wire_ms(transaction));
    while (SteadyClock::now() < deadline) {
        const bool arrived = wait_for_link(deadline);
        if (quit_) {
            transaction.outcome = Outcome::closed;
            return;
        }
        if (stop_wanted_ != 0 && link_->overlaps()) send_stop();
        if (stop_wanted_ != 0 && !link_->overlaps() && !is_stop) {
            deadline = std::min(deadline, SteadyClock::now() + shortest_patience);
        }
        if (rest_is_missing_) {
            transaction.outcome = Outcome::invalid;
            return;
        }
        // Several replies may come in one piece.
        while (arrived || link_->has_part()) {
            const Arrival arrival = link_->receive();
            if (arrival.kind == Arrival::Kind::nothing) break;
            if (take(arrival, transaction, id)) return;
            if (!link_->has_part()) break;
        }
    }
    transaction.outcome = Outcome::timeout;
}

/// True when the transaction has an outcome.
bool Conversation::take(const Arrival& arrival, Transaction& transaction, std::uint16_t id) {
    log_.received(arrival.bytes);
    if (arrival.kind == Arrival::Kind::broken || arrival.kind == Arrival::Kind::garbled) {
        const bool broken = arrival.kind == Arrival::Kind::broken;
        transaction.outcome = broken ? Outcome::closed : Outcome::invalid;
        return true;
    }
    if (arrival.id == id) {
        take_reply(arrival.pdu, transaction);
        // Without ids a reply that does not fit is one to an earlier request.
        if (transaction.outcome != Outcome::invalid || link_->overlaps()) return true;
    } else if (stop_sent_ && arrival.id == stop_id_) {
        stop_owed_ = 0;
        stop_sent_ = false;
        return false;
    }
    log_.count([](LinkStats& stats) { ++stats.stale; });
    return false;
}

/// Where replies carry no id, one that comes late would pass for the reply to the next request: it is waited for as
/// long as the one that was given up, unless a stop is wanted.
void Conversation::let_late_reply_pass() {
    while (link_->is_open() && SteadyClock::now() < late_until_ && stop_wanted_ == 0 && !quit_) {
        if (!wait_for_link(late_until_) && !rest_is_missing_) continue;
        const Arrival arrival = link_->receive();
        log_.received(arrival.bytes);
        if (arrival.kind == Arrival::Kind::nothing && !rest_is_missing_) continue;
        if (arrival.kind == Arrival::Kind::reply) {
            log_.count([](LinkStats& stats) { ++stats.stale; });
        } else if (arrival.kind == Arrival::Kind::broken || !link_->resync()) {
            close_link();
        }
        break;
    }
    late_until_ = {};
}

/// Puts the stop on the wire without waiting for anything else that is under way.
void Conversation::send_stop() {
    take_stop();
    stop_id_ = ++last_id_;
    stop_sent_ = send(stop_transaction(), stop_id_) == Outcome::ok;
    if (!stop_sent_) return;
    const std::int64_t requested = stop_requested_ns_.exchange(0);
    log_.count([requested](LinkStats& stats) {
        ++stats.stops;
        if (requested != 0) stats.last_stop_us = static_cast<double>(now_ns() - requested) * 1e-3;
    });
}

void Conversation::take_stop() {
    stop_owed_ = std::max(stop_owed_, stop_wanted_.exchange(0));
}

void Conversation::serve_stop() {
    const int attempts = link_->overlaps() ? 2 : stop_attempts;
    for (int attempt = 0; stop_matters_ && !quit_ && (stop_wanted_ != 0 || stop_owed_ != 0); ++attempt) {
        if (!link_->is_open()) open_link();
        if (!link_->is_open() || attempt == attempts) {
            take_stop();
            stop_owed_ = 0;  // one that is asked for from here on is tried anew
            return;
        }
        if (stop_wanted_ != 0 || !stop_sent_) send_stop();
        const bool sent = stop_sent_;
        if (sent) await_stop();
        if (stop_owed_ == 0 || stop_wanted_ != 0) continue;
        // A serial line that lost the stop is as good as a new one; a connection that did not carry it is dead.
        if (link_->overlaps() || !sent) close_link();
        stop_sent_ = false;
    }
}

void Conversation::await_stop() {
    const std::uint16_t id = stop_id_;
    Transaction stop = stop_transaction();
    const double patience_ms = link_->overlaps() ? options_.stop_timeout_ms
                                                 : std::min(options_.stop_timeout_ms, stop_reply_ms) + wire_ms(stop);
    await_reply(stop, id, SteadyClock::now() + core::from_ms(patience_ms));
    if (stop.outcome == Outcome::closed) close_link();
    if (stop.outcome == Outcome::invalid && link_->is_open() && !link_->resync()) close_link();
    const bool answered = stop.outcome == Outcome::ok || stop.outcome == Outcome::exception;
    if (!answered || id != stop_id_) return;
    stop_owed_ = 0;
    stop_sent_ = false;
}

Transaction Conversation::stop_transaction() const {
    Transaction stop;
    stop.kind = Transaction::Kind::write_single;
    stop.write_address = options_.stop_address;
    stop.write_count = 1;
    stop.written[0] = static_cast<std::uint16_t>(stop_owed_);
    return stop;
}

void Conversation::open_link() {
    close_link();
    connect_error_ = link_->open(options_.connect_timeout_ms);
    connected_ = link_->is_open();
    if (link_->is_open()) ++link_number_;
}

void Conversation::close_link() {
    connected_ = false;
    stop_sent_ = false;
    late_until_ = {};
    link_->close();
}

void Conversation::record(Outcome outcome, double us) {
    log_.count([outcome, us](LinkStats& stats) {
        if (outcome == Outcome::exception) ++stats.exceptions;
        if (outcome == Outcome::ok || outcome == Outcome::exception) {
            stats.add_round_trip(us);
        } else if (outcome == Outcome::timeout) {
            ++stats.timeouts;
        } else if (outcome == Outcome::invalid) {
            ++stats.invalid;
        } else {
            ++stats.closed;
        }
    });
}

void Conversation::want_stop(StopKind kind) noexcept {
    const int wanted = kind == StopKind::emergency ? 2 : 1;
    std::int64_t never = 0;
    stop_requested_ns_.compare_exchange_strong(never, now_ns());
    int present = stop_wanted_.load();
    while (present < wanted && !stop_wanted_.compare_exchange_weak(present, wanted)) {
    }
    wake_.signal();
}

void Conversation::quit() noexcept {
    quit_ = true;
    wake_.signal();
}

}  // namespace cmm::drivers::modbus
