// SPDX-License-Identifier: Apache-2.0
#include "drivers/modbus/bus.hpp"

#include <poll.h>
#include <sys/prctl.h>

#include <mutex>
#include <thread>
#include <utility>

namespace cmm::drivers::modbus {

class Bus::Impl {
  public:
    Impl(std::unique_ptr<Link> link, BusOptions options)
        : conversation_(std::move(link), options), thread_([this] { main(); }) {}

    ~Impl() {
        conversation_.quit();
        thread_.join();
    }
    Impl(const Impl&) = delete;
    Impl& operator=(const Impl&) = delete;

    void submit(bool connect, std::span<Transaction* const> batch, double timeout_ms, std::size_t in_flight) {
        {
            const std::lock_guard lock(job_mutex_);
            job_ = Job{connect, true, timeout_ms, in_flight, batch};
        }
        conversation_.wake().signal();
    }

    Conversation conversation_;
    EventFd done_;

  private:
    struct Job {
        bool connect = false, pending = false;
        double timeout_ms = 0.0;
        std::size_t in_flight = 1;
        std::span<Transaction* const> batch;
    };

    void main() {
        ::prctl(PR_SET_TIMERSLACK, 1UL);  // 50 us unless said: a sixth of the silence between two frames
        while (!conversation_.quits()) {
            pollfd wait{conversation_.wake().fd(), POLLIN, 0};
            ::poll(&wait, 1, -1);
            conversation_.wake().clear();
            conversation_.serve_stop();
            Job job;
            {
                const std::lock_guard lock(job_mutex_);
                std::swap(job, job_);
            }
            if (!job.pending || conversation_.quits()) continue;
            if (job.connect) {
                conversation_.connect();
            } else {
                conversation_.run(job.batch, job.timeout_ms, job.in_flight);
            }
            conversation_.serve_stop();
            done_.signal();
        }
    }

    std::mutex job_mutex_;
    Job job_;
    std::thread thread_;  // last: everything else exists when it starts
};

Bus::Bus(std::unique_ptr<Link> link, BusOptions options) : impl_(std::make_unique<Impl>(std::move(link), options)) {}
Bus::~Bus() = default;

void Bus::connect() {
    impl_->submit(true, {}, 0.0, 1);
}
void Bus::run(std::span<Transaction* const> batch, double response_timeout_ms, std::size_t in_flight) {
    impl_->submit(false, batch, response_timeout_ms, in_flight);
}
int Bus::done_fd() const noexcept {
    return impl_->done_.fd();
}
bool Bus::overlaps() const noexcept {
    return impl_->conversation_.link().overlaps();
}
double Bus::wire_ms(std::size_t bytes) const noexcept {
    return impl_->conversation_.link().wire_ms(bytes);
}
double Bus::service_ms() const noexcept {
    return impl_->conversation_.service_ms();
}
bool Bus::connected() const noexcept {
    return impl_->conversation_.connected();
}
std::uint64_t Bus::link_number() const noexcept {
    return impl_->conversation_.link_number();
}
const std::string& Bus::connect_error() const noexcept {
    return impl_->conversation_.connect_error();
}
void Bus::stop(StopKind kind) noexcept {
    impl_->conversation_.want_stop(kind);
}

LinkStats Bus::stats() const {
    return impl_->conversation_.log().stats();
}
void Bus::count(const std::function<void(LinkStats&)>& change) {
    impl_->conversation_.log().count(change);
}
void Bus::note(const std::string& text) {
    impl_->conversation_.log().note(text);
}
void Bus::set_trace(std::function<void(std::string_view)> line) {
    impl_->conversation_.log().set_trace(std::move(line));
}

}  // namespace cmm::drivers::modbus
