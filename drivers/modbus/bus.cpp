// SPDX-License-Identifier: Apache-2.0
#include "drivers/modbus/bus.hpp"

#include <poll.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <mutex>
#include <thread>

#include "drivers/event_fd.hpp"
#include "drivers/link_log.hpp"

namespace cmm::drivers::modbus {
namespace {

using SteadyClock = std::chrono::steady_clock;
using Outcome = Transaction::Outcome;

std::int64_t now_ns() noexcept {
    return SteadyClock::now().time_since_epoch().count();
}

// On a link that carries one request at a time. After a stop was asked for, the reply under way is waited for so long
// and its time on the line: the stop is on the wire within 250 ms from 19200 baud on, and does not meet the reply.
constexpr double patience_before_stop_ms = 60.0;
constexpr double stop_reply_ms = 100.0;
constexpr int stop_attempts = 4;

SteadyClock::duration duration_of(double ms) {
    return std::chrono::duration_cast<SteadyClock::duration>(std::chrono::duration<double, std::milli>(ms));
}

}  // namespace

class Bus::Impl {
  public:
    Impl(std::unique_ptr<Link> link, BusOptions options)
        : options_(options), link_(std::move(link)), thread_([this] { main(); }) {}

    ~Impl() {
        quit_ = true;
        wake_.signal();
        thread_.join();
    }
    Impl(const Impl&) = delete;
    Impl& operator=(const Impl&) = delete;

    void submit(bool connect, std::span<Transaction* const> batch, double timeout_ms) {
        {
            const std::lock_guard lock(job_mutex_);
            job_ = Job{connect, true, timeout_ms, batch};
        }
        wake_.signal();
    }

    void request_stop(StopKind kind) noexcept {
        const int wanted = kind == StopKind::emergency ? 2 : 1;
        std::int64_t never = 0;
        stop_requested_ns_.compare_exchange_strong(never, now_ns());
        int present = stop_wanted_.load();
        while (present < wanted && !stop_wanted_.compare_exchange_weak(present, wanted)) {
        }
        wake_.signal();
    }

    BusOptions options_;
    std::unique_ptr<Link> link_;
    EventFd wake_, done_;
    std::atomic<bool> connected_{false};
    std::atomic<std::uint64_t> link_number_{0};
    std::string connect_error_;
    LinkLog log_;

  private:
    struct Job {
        bool connect = false, pending = false;
        double timeout_ms = 0.0;
        std::span<Transaction* const> batch;
    };

    // ---- the thread -------------------------------------------------------------------------------------------------
    void main() {
        while (!quit_) {
            pollfd wait{wake_.fd(), POLLIN, 0};
            ::poll(&wait, 1, -1);
            wake_.clear();
            serve_stop();
            Job job;
            {
                const std::lock_guard lock(job_mutex_);
                std::swap(job, job_);
            }
            if (!job.pending || quit_) continue;
            if (job.connect) {
                open_link();
                stop_matters_ = true;
            } else {
                run_batch(job.batch, job.timeout_ms);
            }
            serve_stop();
            done_.signal();
        }
    }

    void run_batch(std::span<Transaction* const> batch, double timeout_ms) {
        for (Transaction* transaction : batch)
            transaction->outcome = Outcome::not_sent;
        for (Transaction* transaction : batch) {
            let_late_reply_pass();
            serve_stop();
            execute(*transaction, timeout_ms);
            if (transaction->outcome != Outcome::ok && transaction->outcome != Outcome::exception) return;
        }
    }

    void execute(Transaction& transaction, double timeout_ms) {
        if (!link_->is_open()) {
            transaction.outcome = Outcome::closed;
            return;
        }
        const auto started = SteadyClock::now();
        const std::uint16_t id = ++last_id_;
        transaction.outcome = send(transaction, id);
        const auto patience = duration_of(timeout_ms + wire_ms(transaction));
        if (transaction.outcome == Outcome::ok) await_reply(transaction, id, started + patience);
        const std::chrono::duration<double, std::micro> took = SteadyClock::now() - started;
        record(transaction.outcome, took.count());
        recover(transaction, patience);
    }

    /// Request and reply; the frame around either is at most as long as that of RTU.
    double wire_ms(const Transaction& transaction) const {
        std::array<std::uint8_t, max_pdu> pdu;
        return link_->wire_ms(encode_pdu(transaction, pdu) + reply_size(transaction) + 6);
    }

    void recover(const Transaction& transaction, SteadyClock::duration patience) {
        const Outcome outcome = transaction.outcome;
        if (outcome == Outcome::closed) close_link();
        if (outcome == Outcome::invalid && link_->is_open() && !link_->resync()) close_link();
        // The reply to a write names its address: late or not, it passes for no other.
        const bool mistakable = !link_->overlaps() && transaction.read_count > 0;
        if (outcome == Outcome::timeout && mistakable) late_until_ = SteadyClock::now() + patience;
    }

    Outcome send(const Transaction& transaction, std::uint16_t id) {
        std::array<std::uint8_t, max_pdu> pdu;
        const auto bytes = link_->send(id, std::span(pdu).first(encode_pdu(transaction, pdu)));
        if (bytes.empty()) return Outcome::closed;
        log_.sent(bytes);
        return Outcome::ok;
    }

    /// Waits for something from the link, a message for this thread, or the deadline. True: ask the link.
    bool wait_for_link(SteadyClock::time_point deadline) {
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
    void await_reply(Transaction& transaction, std::uint16_t id, SteadyClock::time_point deadline) {
        const bool is_stop = stop_sent_ && id == stop_id_;
        const auto shortest_patience = duration_of(patience_before_stop_ms + wire_ms(transaction));
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
    bool take(const Arrival& arrival, Transaction& transaction, std::uint16_t id) {
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
    void let_late_reply_pass() {
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

    // ---- stop -------------------------------------------------------------------------------------------------------
    /// Puts the stop on the wire without waiting for anything else that is under way.
    void send_stop() {
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

    void take_stop() { stop_owed_ = std::max(stop_owed_, stop_wanted_.exchange(0)); }

    /// Sends a stop that is wanted and sees to it that it is answered: over a fresh link if the present one does not
    /// carry it. A few attempts are enough: a controller that cannot be reached stops by its watchdog.
    void serve_stop() {
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

    void await_stop() {
        const std::uint16_t id = stop_id_;
        Transaction stop = stop_transaction();
        const double patience_ms = link_->overlaps()
                                       ? options_.stop_timeout_ms
                                       : std::min(options_.stop_timeout_ms, stop_reply_ms) + wire_ms(stop);
        await_reply(stop, id, SteadyClock::now() + duration_of(patience_ms));
        if (stop.outcome == Outcome::closed) close_link();
        if (stop.outcome == Outcome::invalid && link_->is_open() && !link_->resync()) close_link();
        const bool answered = stop.outcome == Outcome::ok || stop.outcome == Outcome::exception;
        if (!answered || id != stop_id_) return;
        stop_owed_ = 0;
        stop_sent_ = false;
    }

    Transaction stop_transaction() const {
        Transaction stop;
        stop.kind = Transaction::Kind::write_single;
        stop.write_address = options_.stop_address;
        stop.write_count = 1;
        stop.written[0] = static_cast<std::uint16_t>(stop_owed_);
        return stop;
    }

    // ---- the link ---------------------------------------------------------------------------------------------------
    void open_link() {
        close_link();
        connect_error_ = link_->open(options_.connect_timeout_ms);
        connected_ = link_->is_open();
        if (link_->is_open()) ++link_number_;
    }

    void close_link() {
        connected_ = false;
        stop_sent_ = false;
        late_until_ = {};
        link_->close();
    }

    void record(Outcome outcome, double us) {
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

    std::uint16_t last_id_ = 0;
    bool rest_is_missing_ = false;          // of a reply that has begun to arrive
    SteadyClock::time_point late_until_{};  // a reply that was given up may still come
    bool stop_matters_ = false;             // before the first connect there is nobody to stop
    std::atomic<bool> quit_{false};
    std::mutex job_mutex_;
    Job job_;
    std::atomic<int> stop_wanted_{0};  // 0, 1 controlled, 2 emergency
    std::atomic<std::int64_t> stop_requested_ns_{0};
    int stop_owed_ = 0;  // like stop_wanted_: taken from there, not yet answered
    std::uint16_t stop_id_ = 0;
    bool stop_sent_ = false;  // over the present link, not yet answered
    std::thread thread_;      // last: everything else exists when it starts
};

Bus::Bus(std::unique_ptr<Link> link, BusOptions options) : impl_(std::make_unique<Impl>(std::move(link), options)) {}
Bus::~Bus() = default;

void Bus::connect() {
    impl_->submit(true, {}, 0.0);
}
void Bus::run(std::span<Transaction* const> batch, double response_timeout_ms) {
    impl_->submit(false, batch, response_timeout_ms);
}
int Bus::done_fd() const noexcept {
    return impl_->done_.fd();
}
bool Bus::overlaps() const noexcept {
    return impl_->link_->overlaps();
}
double Bus::wire_ms(std::size_t bytes) const noexcept {
    return impl_->link_->wire_ms(bytes);
}
bool Bus::connected() const noexcept {
    return impl_->connected_;
}
std::uint64_t Bus::link_number() const noexcept {
    return impl_->link_number_;
}
const std::string& Bus::connect_error() const noexcept {
    return impl_->connect_error_;
}
void Bus::stop(StopKind kind) noexcept {
    impl_->request_stop(kind);
}

LinkStats Bus::stats() const {
    return impl_->log_.stats();
}
void Bus::count(const std::function<void(LinkStats&)>& change) {
    impl_->log_.count(change);
}
void Bus::set_trace(std::function<void(std::string_view)> line) {
    impl_->log_.set_trace(std::move(line));
}

}  // namespace cmm::drivers::modbus
