// SPDX-License-Identifier: Apache-2.0
#include "drivers/modbus/bus.hpp"

#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <mutex>
#include <system_error>
#include <thread>

#include "drivers/modbus/tcp_link.hpp"

namespace cmm::drivers::modbus {
namespace {

using SteadyClock = std::chrono::steady_clock;
using Outcome = Transaction::Outcome;

constexpr std::string_view hex_digits = "0123456789abcdef";

std::int64_t now_ns() noexcept {
    return SteadyClock::now().time_since_epoch().count();
}

SteadyClock::duration duration_of(double ms) {
    return std::chrono::duration_cast<SteadyClock::duration>(std::chrono::duration<double, std::milli>(ms));
}

class EventFd {
  public:
    EventFd() : fd_(::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) {
        if (fd_ < 0) throw std::system_error(errno, std::generic_category(), "eventfd");
    }
    ~EventFd() { ::close(fd_); }
    EventFd(const EventFd&) = delete;
    EventFd& operator=(const EventFd&) = delete;
    int fd() const noexcept { return fd_; }
    void signal() const noexcept {
        const std::uint64_t one = 1;
        // Fails only when the counter is full: then it is signalled already.
        [[maybe_unused]] const auto written = ::write(fd_, &one, sizeof one);
    }
    void clear() const noexcept {
        std::uint64_t count = 0;
        [[maybe_unused]] const auto taken = ::read(fd_, &count, sizeof count);
    }

  private:
    int fd_;
};

}  // namespace

class Bus::Impl {
  public:
    explicit Impl(BusOptions options)
        : options_(std::move(options)), link_(options_.host, options_.port), thread_([this] { main(); }) {}

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
    EventFd wake_, done_;
    std::atomic<bool> connected_{false};
    std::atomic<std::uint64_t> link_number_{0};
    std::string connect_error_;
    mutable std::mutex stats_mutex_;
    LinkStats stats_;
    std::mutex trace_mutex_;
    std::function<void(std::string_view)> trace_;
    std::atomic<bool> tracing_{false};

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
            serve_stop();
            execute(*transaction, timeout_ms);
            if (transaction->outcome != Outcome::ok && transaction->outcome != Outcome::exception) return;
        }
    }

    void execute(Transaction& transaction, double timeout_ms) {
        if (!link_.is_open()) {
            transaction.outcome = Outcome::closed;
            return;
        }
        const auto started = SteadyClock::now();
        const std::uint16_t id = ++last_id_;
        transaction.outcome = send(transaction, id);
        if (transaction.outcome == Outcome::ok) await_reply(transaction, id, started + duration_of(timeout_ms));
        const std::chrono::duration<double, std::micro> took = SteadyClock::now() - started;
        record(transaction.outcome, took.count());
        if (transaction.outcome == Outcome::closed || transaction.outcome == Outcome::invalid) close_link();
    }

    Outcome send(const Transaction& transaction, std::uint16_t id) {
        std::array<std::uint8_t, max_frame> frame;
        const std::size_t size = encode_request(transaction, id, options_.unit, frame);
        const std::span<const std::uint8_t> bytes(frame.data(), size);
        trace('>', bytes);
        if (!link_.send(bytes)) return Outcome::closed;
        const std::lock_guard lock(stats_mutex_);
        stats_.bytes_sent += size;
        return Outcome::ok;
    }

    /// Waits for the reply with this id; serves a stop meanwhile. Replies to requests given up earlier are counted and
    /// dropped.
    void await_reply(Transaction& transaction, std::uint16_t id, SteadyClock::time_point deadline) {
        for (;;) {
            const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline - SteadyClock::now());
            if (left.count() <= 0) {
                transaction.outcome = Outcome::timeout;
                return;
            }
            std::array<pollfd, 2> wait{{{link_.fd(), POLLIN, 0}, {wake_.fd(), POLLIN, 0}}};
            ::poll(wait.data(), wait.size(), static_cast<int>(left.count()));
            if (wait[1].revents != 0) {
                wake_.clear();
                if (quit_) {
                    transaction.outcome = Outcome::closed;
                    return;
                }
                if (stop_wanted_ != 0) send_stop();
            }
            if (wait[0].revents == 0) continue;
            const auto frame = link_.receive();
            if (frame.empty()) {
                transaction.outcome = Outcome::closed;
                return;
            }
            if (take_frame(frame, transaction, id)) return;
        }
    }

    /// True when the transaction is answered (or the stream is out of step).
    bool take_frame(std::span<const std::uint8_t> frame, Transaction& transaction, std::uint16_t id) {
        trace('<', frame);
        {
            const std::lock_guard lock(stats_mutex_);
            stats_.bytes_received += frame.size();
        }
        if (!header_fits(frame)) {
            transaction.outcome = Outcome::invalid;
            return true;
        }
        if (id_of(frame) == id) {
            take_reply(frame, transaction);
            return true;
        }
        if (stop_sent_ && id_of(frame) == stop_id_) {
            stop_owed_ = 0;
            stop_sent_ = false;
            return false;
        }
        const std::lock_guard lock(stats_mutex_);
        ++stats_.stale;
        return false;
    }

    // ---- stop -------------------------------------------------------------------------------------------------------
    /// Puts the stop on the wire without waiting for anything else that is under way.
    void send_stop() {
        take_stop();
        stop_id_ = ++last_id_;
        stop_sent_ = send(stop_transaction(), stop_id_) == Outcome::ok;
        if (!stop_sent_) return;
        const std::int64_t requested = stop_requested_ns_.exchange(0);
        const std::lock_guard lock(stats_mutex_);
        ++stats_.stops;
        if (requested != 0) stats_.last_stop_us = static_cast<double>(now_ns() - requested) * 1e-3;
    }

    void take_stop() { stop_owed_ = std::max(stop_owed_, stop_wanted_.exchange(0)); }

    /// Sends a stop that is wanted and sees to it that it is answered: over a fresh link if the present one does not
    /// carry it. Twice is enough: a controller that cannot be reached stops by its watchdog.
    void serve_stop() {
        for (int attempt = 0; stop_matters_ && !quit_ && (stop_wanted_ != 0 || stop_owed_ != 0); ++attempt) {
            if (!link_.is_open()) open_link();
            if (!link_.is_open() || attempt == 2) {
                take_stop();
                stop_owed_ = 0;  // one that is asked for from here on is tried anew
                return;
            }
            if (stop_wanted_ != 0 || !stop_sent_) send_stop();
            if (stop_sent_) await_stop();
            if (stop_owed_ != 0 && stop_wanted_ == 0) close_link();
        }
    }

    void await_stop() {
        const std::uint16_t id = stop_id_;
        Transaction stop = stop_transaction();
        await_reply(stop, id, SteadyClock::now() + duration_of(options_.stop_timeout_ms));
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
        connect_error_ = link_.open(options_.connect_timeout_ms);
        connected_ = link_.is_open();
        if (link_.is_open()) ++link_number_;
    }

    void close_link() {
        connected_ = false;
        stop_sent_ = false;
        link_.close();
    }

    void record(Outcome outcome, double us) {
        const std::lock_guard lock(stats_mutex_);
        switch (outcome) {
            case Outcome::exception:
                ++stats_.exceptions;
                [[fallthrough]];
            case Outcome::ok:
                stats_.add_round_trip(us);
                break;
            case Outcome::timeout:
                ++stats_.timeouts;
                break;
            case Outcome::invalid:
                ++stats_.invalid;
                break;
            default:
                ++stats_.closed;
                break;
        }
    }

    void trace(char direction, std::span<const std::uint8_t> bytes) {
        if (!tracing_) return;
        std::string line = std::to_string(static_cast<double>(now_ns()) * 1e-9) + " " + direction;
        for (const auto byte : bytes) {
            line += ' ';
            line += hex_digits[byte >> 4U];
            line += hex_digits[byte & 15U];
        }
        const std::lock_guard lock(trace_mutex_);
        if (trace_) trace_(line);
    }

    TcpLink link_;
    std::uint16_t last_id_ = 0;
    bool stop_matters_ = false;  // before the first connect there is nobody to stop
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

Bus::Bus(BusOptions options) : impl_(std::make_unique<Impl>(std::move(options))) {}
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
    const std::lock_guard lock(impl_->stats_mutex_);
    return impl_->stats_;
}

void Bus::count(const std::function<void(LinkStats&)>& change) {
    const std::lock_guard lock(impl_->stats_mutex_);
    change(impl_->stats_);
}

void Bus::set_trace(std::function<void(std::string_view)> line) {
    const std::lock_guard lock(impl_->trace_mutex_);
    impl_->tracing_ = static_cast<bool>(line);
    impl_->trace_ = std::move(line);
}

}  // namespace cmm::drivers::modbus
