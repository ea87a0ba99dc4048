// SPDX-License-Identifier: Apache-2.0
#include "cell/mqtt_queue.hpp"

#include <algorithm>
#include <utility>

namespace cmm::cell {

void MqttQueue::push(Message message) {
    if (message.retained) {
        std::erase_if(messages_, [&](const Message& old) { return old.retained && old.topic == message.topic; });
    }
    messages_.push_back(std::move(message));
    if (messages_.size() <= capacity_) return;
    const auto oldest =
        std::find_if(messages_.begin(), messages_.end(), [](const Message& old) { return !old.retained; });
    messages_.erase(oldest != messages_.end() ? oldest : messages_.begin());
    ++dropped_;
}

std::optional<MqttQueue::Message> MqttQueue::pop() {
    if (messages_.empty()) return {};
    auto next = std::move(messages_.front());
    messages_.pop_front();
    return next;
}

}  // namespace cmm::cell
