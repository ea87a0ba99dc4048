// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <string>

namespace cmm::cell {

/// What waits for a broker, bounded: of a retained topic only the newest message (the older ones are superseded, not
/// lost); when it is full, the oldest that is not retained goes and is counted. One thread at a time.
class MqttQueue {
  public:
    struct Message {
        std::string topic, payload;
        bool retained = false;
    };
    explicit MqttQueue(std::size_t capacity = 256) : capacity_(capacity) {}

    void push(Message message);
    /// The next one to send; nothing: the queue is empty.
    std::optional<Message> pop();
    /// Back to the front: it could not be sent.
    void put_back(Message message) { messages_.push_front(std::move(message)); }
    std::size_t size() const { return messages_.size(); }
    std::uint64_t dropped() const { return dropped_; }

  private:
    std::size_t capacity_;
    std::deque<Message> messages_;
    std::uint64_t dropped_ = 0;
};

}  // namespace cmm::cell
