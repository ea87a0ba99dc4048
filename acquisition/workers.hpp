// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <boost/asio/associated_executor.hpp>
#include <boost/asio/async_result.hpp>
#include <boost/asio/awaitable.hpp>
#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/thread_pool.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <chrono>
#include <exception>
#include <functional>
#include <type_traits>
#include <utility>

#include "core/priority.hpp"

namespace cmm::acquisition {

/// The threads for what takes longer than a machine may wait: fits, files and ways (milliseconds) on some, plans
/// (seconds, of a million points) on one of its own, so that no section's result waits for another job's plan. One set
/// for all jobs of a process; each kind in the order asked for (ADR 11). Any thread; outlives all who use it.
class Workers {
  public:
    /// For the short work as many as the processor has cores but one, at least one: the loops that talk to the machines
    /// have a core.
    Workers();
    /// `niceness` of the threads: the loops that talk to the machines come first.
    explicit Workers(std::size_t threads, int niceness = 5) : niceness_(niceness), short_(threads) {}
    ~Workers() {
        long_.join();
        short_.join();
    }
    Workers(const Workers&) = delete;
    Workers& operator=(const Workers&) = delete;

    void post(std::function<void()> work) {
        boost::asio::post(short_, [niceness = niceness_, asked = Asked(asked_), work = std::move(work)]() mutable {
            asked.taken();
            core::stand_back(niceness);
            work();
        });
    }

    /// For a work at its end that knows of another one soon: keeps its thread awake so long, or until there is short
    /// work for anybody. A processor that has gone to sleep takes a third of a millisecond more for it.
    void stay_awake(std::chrono::nanoseconds at_most) const;

    /// What `work` returns (default constructible), without holding up the executor of the coroutine that awaits it.
    template <class Work>
    boost::asio::awaitable<std::invoke_result_t<Work&>> run(Work work) {
        return on(short_, niceness_, Asked(asked_), std::move(work));
    }
    /// The same for work that may take seconds.
    template <class Work>
    boost::asio::awaitable<std::invoke_result_t<Work&>> run_long(Work work) {
        return on(long_, niceness_, Asked(), std::move(work));
    }

  private:
    /// A short work that nobody has taken yet.
    class Asked {
      public:
        Asked() = default;
        explicit Asked(std::atomic<int>& count) : count_(&count) { ++count; }
        Asked(Asked&& other) noexcept : count_(std::exchange(other.count_, nullptr)) {}
        Asked& operator=(Asked&&) = delete;
        ~Asked() { taken(); }
        void taken() {
            if (count_ != nullptr) --*std::exchange(count_, nullptr);
        }

      private:
        std::atomic<int>* count_ = nullptr;
    };

    // Not by co_spawn: what never suspends is put back there behind all that waits before its answer goes out.
    template <class Work>
    static boost::asio::awaitable<std::invoke_result_t<Work&>> on(boost::asio::thread_pool& pool, int niceness,
                                                                  Asked asked, Work work) {
        using Answer = std::invoke_result_t<Work&>;
        auto begin = [&pool, niceness, asked = std::move(asked)](auto handler, Work what) mutable {
            const auto executor = boost::asio::get_associated_executor(handler);
            auto task = [niceness, asked = std::move(asked), what = std::move(what), handler = std::move(handler),
                         awaited = boost::asio::make_work_guard(executor)]() mutable {
                asked.taken();
                core::stand_back(niceness);
                std::exception_ptr thrown;
                Answer answer{};
                try {
                    answer = what();
                } catch (...) {
                    thrown = std::current_exception();
                }
                boost::asio::post(awaited.get_executor(),
                                  [handler = std::move(handler), thrown, answer = std::move(answer)]() mutable {
                                      std::move(handler)(thrown, std::move(answer));
                                  });
            };
            boost::asio::post(pool, std::move(task));
        };
        return boost::asio::async_initiate<const boost::asio::use_awaitable_t<>&, void(std::exception_ptr, Answer)>(
            std::move(begin), boost::asio::use_awaitable, std::move(work));
    }

    int niceness_;
    std::atomic<int> asked_ = 0;  // short works that nobody has taken yet
    boost::asio::thread_pool short_, long_{1};
};

}  // namespace cmm::acquisition
