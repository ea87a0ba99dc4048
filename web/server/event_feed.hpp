// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "acquisition/events.hpp"

namespace cmm::web {

/// The newest events of a running job as lines of NDJSON, kept for those who read: each reader asks from a sequence, so
/// that one who is slow costs nothing and finds out himself what is gone. `push` is the only thing that the job waits
/// for: a line is made and put into a bounded ring. Thread-safe.
class EventFeed {
  public:
    using Line = std::shared_ptr<const std::string>;
    struct Slice {
        std::uint64_t first = 0;  ///< sequence of the first line; larger than asked for: the earlier ones are not kept
        std::vector<Line> lines;
        std::uint64_t job = 0;  ///< whose they are
    };

    explicit EventFeed(std::size_t capacity = 8192) : capacity_(capacity) {}

    void push(const acquisition::Event& event);
    /// The next job's events begin; those of the one before are gone.
    void begin_job();
    /// Counts up with each job.
    std::uint64_t job() const;
    /// Lines from this sequence on, `most` of them. Without lines: `first` is the one that comes next.
    Slice read(std::uint64_t from, std::size_t most) const;
    /// Called on the pusher's thread after a push, when it was not called since the last `read`.
    void on_news(std::function<void()> tell);

  private:
    std::size_t capacity_;
    mutable std::mutex mutex_;
    std::deque<Line> lines_;
    std::uint64_t next_ = 1;  // sequence behind the last line
    std::uint64_t job_ = 0;
    std::function<void()> tell_;
    mutable bool told_ = false;
};

}  // namespace cmm::web
