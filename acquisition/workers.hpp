// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <boost/asio/awaitable.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/thread_pool.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <functional>
#include <type_traits>
#include <utility>

namespace cmm::acquisition {

/// The threads for what takes longer than a machine may wait: plans, fits, files. One set for all jobs of a process, in
/// the order asked for. They leave one core to the loops that talk to the machines (ADR 11). Any thread; outlives all
/// who use it.
class Workers {
  public:
    /// As many as the processor has cores but one, at least one.
    Workers();
    explicit Workers(std::size_t threads) : pool_(threads) {}
    ~Workers() { pool_.join(); }
    Workers(const Workers&) = delete;
    Workers& operator=(const Workers&) = delete;

    void post(std::function<void()> work);

    /// What `work` returns, without holding up the executor of the coroutine that awaits it.
    template <class Work>
    boost::asio::awaitable<std::invoke_result_t<Work&>> run(Work work) {
        return boost::asio::co_spawn(pool_, call(std::move(work)), boost::asio::use_awaitable);
    }

  private:
    template <class Work>
    static boost::asio::awaitable<std::invoke_result_t<Work&>> call(Work work) {
        co_return work();
    }

    boost::asio::thread_pool pool_;
};

}  // namespace cmm::acquisition
