// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/error.hpp"

namespace cmm::drivers {

/// Held by an operation of a machine; the next one is refused, never queued. Machine's executor only.
class Occupied {
  public:
    explicit Occupied(bool& flag) : flag_(flag) { flag_ = true; }
    ~Occupied() { flag_ = false; }
    Occupied(const Occupied&) = delete;
    Occupied& operator=(const Occupied&) = delete;

  private:
    bool& flag_;
};

inline core::Error busy_error() {
    return core::Error{core::ErrorCode::machine_busy,
                       "another operation of this machine is under way",
                       {},
                       core::Motion::may_be_moving};
}

}  // namespace cmm::drivers
