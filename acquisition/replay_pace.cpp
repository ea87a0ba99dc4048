// SPDX-License-Identifier: Apache-2.0
#include "acquisition/replay_pace.hpp"

#include <algorithm>
#include <chrono>

namespace cmm::acquisition {

std::size_t ReplayPace::due(std::span<const core::Sample> samples) {
    if (at_once() || samples.empty()) return samples.size();
    const core::Duration now = clock_.now();
    if (!start_) start_ = Start{samples.front().machine_time_us, now};
    const double played_us = std::chrono::duration<double, std::micro>(now - start_->host).count() * speed_;
    const auto later = std::find_if(samples.begin(), samples.end(), [&](const core::Sample& sample) {
        return static_cast<double>(sample.machine_time_us - start_->machine_us) > played_us;
    });
    return static_cast<std::size_t>(later - samples.begin());
}

}  // namespace cmm::acquisition
