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
constexpr double modbus_stop_reply_ms = 100.0;
constexpr int modbus_stop_attempts = 4;

std::int64_t now_ns() noexcept {
    return SteadyClock::now().time_since_epoch().count();
}

}  // namespace

void Conversation::connect() {
    open_link();
    stop_matters_ = true;
}

void Conversation::run(std::span<Transaction* const> batch, double timeout_ms, std::size_t in_flight) {
    for (Transaction* transaction : batch)
        transaction->outcome = Outcome::not_sent;
    const std::size_t most = link_->overlaps() ? std::max<std::size_t>(in_flight, 1) : 1;
    while (!batch.empty()) {
        std::size_t count = 1;
        while (count < std::min(most, batch.size()) && !batch[count - 1]->alone && !batch[count]->alone)
            ++count;
        const auto group = batch.first(count);
        let_late_reply_pass();
        serve_stop();
        execute(group, timeout_ms);
        const bool answered = std::all_of(group.begin(), group.end(), [](const Transaction* transaction) {
            return transaction->outcome == Outcome::ok || transaction->outcome == Outcome::exception;
        });
        if (!answered) return;
        batch = batch.subspan(count);
    }
}

void Conversation::execute(std::span<Transaction* const> group, double timeout_ms) {
    if (!take_off(group)) {
        give_up(Outcome::closed);
        close_link();
        return;
    }
    double patience_ms = timeout_ms;
    for (const Transaction* transaction : group)
        patience_ms += wire_ms(*transaction);
    const auto patience = core::from_ms(patience_ms);
    await_replies(patience);
    recover(group, patience);
}

/// Puts the requests on the wire, one behind the other; false when the link broke meanwhile.
bool Conversation::take_off(std::span<Transaction* const> group) {
    under_way_.clear();
    for (std::size_t k = 0; k < group.size(); ++k) {
        if (!link_->is_open()) {
            group[k]->outcome = Outcome::closed;
            return false;
        }
        const std::uint16_t id = ++last_id_;
        under_way_.push_back({id, group[k], SteadyClock::now()});
        if (!send(*group[k], id, k + 1 < group.size())) return false;
    }
    return true;
}

/// Request and reply; the frame around either is at most as long as that of RTU.
double Conversation::wire_ms(const Transaction& transaction) const {
    std::array<std::uint8_t, max_pdu> pdu;
    return link_->wire_ms(encode_pdu(transaction, pdu) + reply_size(transaction) + 6);
}

void Conversation::recover(std::span<Transaction* const> group, Duration patience) {
    const auto any = [group](Outcome outcome) {
        return std::any_of(group.begin(), group.end(),
                           [outcome](const Transaction* transaction) { return transaction->outcome == outcome; });
    };
    if (any(Outcome::closed)) close_link();
    if (any(Outcome::invalid) && link_->is_open() && !link_->resync()) close_link();
    // The reply to a write names its address: late or not, it passes for no other.
    const bool mistakable = !link_->overlaps() && group.front()->read_count > 0;
    if (any(Outcome::timeout) && mistakable) late_until_ = SteadyClock::now() + patience;
}

bool Conversation::send(const Transaction& transaction, std::uint16_t id, bool more) {
    std::array<std::uint8_t, max_pdu> pdu;
    const auto bytes = link_->send(id, std::span(pdu).first(encode_pdu(transaction, pdu)), more);
    if (!bytes.empty()) log_.sent(bytes);
    return !bytes.empty();
}

/// Waits for something from the link, a message for this thread, or the deadline. True: ask the link.
bool Conversation::wait_for_link(TimePoint deadline) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline - SteadyClock::now()).count();
    const bool rest_is_due = link_->has_part() && !link_->overlaps();
    const auto longest = rest_is_due ? std::min<std::int64_t>(left, Link::rest_timeout_ms) : left;
    std::array<pollfd, 2> wait{{{link_->fd(), POLLIN, 0}, {wake_.fd(), POLLIN, 0}}};
    const int ready = ::poll(wait.data(), wait.size(), static_cast<int>(std::max<std::int64_t>(0, longest)));
    if (wait[1].revents != 0) wake_.clear();
    rest_is_missing_ = ready == 0 && rest_is_due;
    return wait[0].revents != 0;
}

/// Waits for the replies to what is under way, each for `patience` after the one before it; serves a stop meanwhile.
/// Replies to requests given up earlier are counted and dropped.
void Conversation::await_replies(Duration patience) {
    const bool is_stop = stop_sent_ && under_way_.front().id == stop_id_;
    const auto shortest_patience = core::from_ms(patience_before_stop_ms + wire_ms(*under_way_.front().transaction));
    const std::size_t sent = under_way_.size();
    auto deadline = under_way_.front().sent + patience;
    TimePoint first_reply{}, last_reply{};
    while (SteadyClock::now() < deadline) {
        const bool arrived = wait_for_link(deadline);
        if (quit_) return give_up(Outcome::closed);
        if (stop_wanted_ != 0 && link_->overlaps()) send_stop();
        if (stop_wanted_ != 0 && !link_->overlaps() && !is_stop) {
            deadline = std::min(deadline, SteadyClock::now() + shortest_patience);
        }
        if (rest_is_missing_) return give_up(Outcome::invalid);
        // Several replies may come in one piece.
        while (arrived || link_->has_part()) {
            const Arrival arrival = link_->receive();
            if (arrival.kind == Arrival::Kind::nothing) break;
            if (!take(arrival)) continue;
            last_reply = SteadyClock::now();
            if (first_reply == TimePoint{}) first_reply = last_reply;
            if (under_way_.empty()) return note_service(first_reply, last_reply, sent);
            deadline = last_reply + patience;
        }
    }
    // Half a reply cannot be told from the beginning of the next one.
    give_up(link_->overlaps() && link_->has_part() ? Outcome::invalid : Outcome::timeout);
}

/// What is still under way ends so.
void Conversation::give_up(Outcome outcome) {
    for (const Flight& flight : under_way_) {
        const std::chrono::duration<double, std::micro> took = SteadyClock::now() - flight.sent;
        flight.transaction->outcome = outcome;
        record(outcome, took.count());
    }
    under_way_.clear();
}

void Conversation::note_service(TimePoint first_reply, TimePoint last_reply, std::size_t replies) {
    if (replies < 2) return;
    const std::chrono::duration<double, std::milli> took = last_reply - first_reply;
    service_ms_ = took.count() / static_cast<double>(replies - 1);
}

/// True when something under way has an outcome by it.
bool Conversation::take(const Arrival& arrival) {
    log_.received(arrival.bytes);
    if (arrival.kind == Arrival::Kind::broken || arrival.kind == Arrival::Kind::garbled) {
        give_up(arrival.kind == Arrival::Kind::broken ? Outcome::closed : Outcome::invalid);
        return true;
    }
    const auto found = std::find_if(under_way_.begin(), under_way_.end(),
                                    [&](const Flight& flight) { return flight.id == arrival.id; });
    if (found != under_way_.end()) {
        if (land(found, arrival.pdu)) return true;
    } else if (stop_sent_ && arrival.id == stop_id_) {
        stop_owed_ = 0;
        stop_sent_ = false;
        return false;
    }
    log_.count([](LinkStats& stats) { ++stats.stale; });
    return false;
}

/// False when the reply is not one to this request after all.
bool Conversation::land(std::vector<Flight>::iterator flight, std::span<const std::uint8_t> pdu) {
    Transaction& transaction = *flight->transaction;
    take_reply(pdu, transaction);
    if (transaction.outcome == Outcome::invalid) {
        // Without ids a reply that does not fit is one to an earlier request.
        if (!link_->overlaps()) return false;
        give_up(Outcome::invalid);  // who answers so is not to be trusted with the rest
        return true;
    }
    const std::chrono::duration<double, std::micro> took = SteadyClock::now() - flight->sent;
    record(transaction.outcome, took.count());
    under_way_.erase(flight);
    return true;
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
    stop_sent_ = send(stop_transaction(), stop_id_);
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
    const int attempts = link_->overlaps() ? 2 : modbus_stop_attempts;
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
    const double patience_ms = link_->overlaps()
                                   ? options_.stop_timeout_ms
                                   : std::min(options_.stop_timeout_ms, modbus_stop_reply_ms) + wire_ms(stop);
    under_way_.assign(1, Flight{id, &stop, SteadyClock::now()});
    await_replies(core::from_ms(patience_ms));
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
