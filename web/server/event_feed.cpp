// SPDX-License-Identifier: Apache-2.0
#include "web/server/event_feed.hpp"

#include <algorithm>
#include <utility>

namespace cmm::web {

void EventFeed::push(const acquisition::Event& event) {
    auto line = std::make_shared<const std::string>(acquisition::to_ndjson(event));
    Line old;  // destroyed outside the lock
    const std::lock_guard guard(mutex_);
    if (event.seq != next_) lines_.clear();  // a resumed run counts on from its run file
    lines_.push_back(std::move(line));
    next_ = event.seq + 1;
    if (lines_.size() > capacity_) {
        old = std::move(lines_.front());
        lines_.pop_front();
    }
    if (tell_ && !std::exchange(told_, true)) tell_();
}

void EventFeed::begin_job() {
    const std::lock_guard guard(mutex_);
    lines_.clear();
    next_ = 1;
    ++job_;
    if (tell_ && !std::exchange(told_, true)) tell_();
}

std::uint64_t EventFeed::job() const {
    const std::lock_guard guard(mutex_);
    return job_;
}

EventFeed::Slice EventFeed::read(std::uint64_t from, std::size_t most) const {
    const std::lock_guard guard(mutex_);
    told_ = false;
    Slice slice;
    slice.job = job_;
    const std::uint64_t oldest = next_ - lines_.size();
    slice.first = std::clamp(from, oldest, next_);
    const auto begin = lines_.begin() + static_cast<std::ptrdiff_t>(slice.first - oldest);
    const auto count = std::min<std::size_t>(most, static_cast<std::size_t>(next_ - slice.first));
    slice.lines.assign(begin, begin + static_cast<std::ptrdiff_t>(count));
    return slice;
}

void EventFeed::on_news(std::function<void()> tell) {
    const std::lock_guard guard(mutex_);
    tell_ = std::move(tell);
}

}  // namespace cmm::web
