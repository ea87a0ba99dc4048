// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

namespace cmm::acquisition {

/// Whether the disk of this file has room for so many bytes more: asked by reserving them in a file beside it, which is
/// gone afterwards, so that quotas and limits count as well. Any thread; may take as long as the disk does.
bool disk_has_room(const std::string& beside, std::int64_t bytes);

/// Asks such a question on a thread of its own, for a dying disk may never answer. One question at a time: as long as
/// one is open no other is asked. The thread of a question that stays open is left to itself (one at most; it ends
/// with the answer or with the process). One thread uses this object.
class DiskQuestion {
  public:
    /// Asks, unless a question is open.
    void ask(std::function<bool()> question);
    /// The answer to the question asked last, once; nothing: it is open, or has been taken. Does not wait.
    std::optional<bool> answer();

  private:
    struct Open;
    std::shared_ptr<Open> open_;  // shared with the thread
};

}  // namespace cmm::acquisition
