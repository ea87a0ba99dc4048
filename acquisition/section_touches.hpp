// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "drivers/machine.hpp"

namespace cmm::acquisition {

/// Turns touches into points of a section: their samples go on under the path that measures it and without the mark of
/// a touch, as a scan's would; their numbers stay. Path 0: everything goes on as it is. Machine's executor; the sink
/// outlives it.
class SectionTouches final : public drivers::SampleSink {
  public:
    SectionTouches(drivers::SampleSink& sink, std::uint16_t path) : sink_(sink), path_(path) {}

    core::Status on_samples(std::span<const core::Sample> samples) override {
        if (path_ == 0) return sink_.on_samples(samples);
        std::vector<core::Sample> points(samples.begin(), samples.end());
        for (auto& sample : points) {
            if ((sample.flags & core::sample_flag::touch) == 0) continue;
            sample.flags = static_cast<std::uint16_t>(sample.flags & ~core::sample_flag::touch);
            sample.path = path_;
        }
        return sink_.on_samples(points);
    }
    std::uint64_t durable_sequence() const noexcept override { return sink_.durable_sequence(); }
    core::Result<bool> hasten() override { return sink_.hasten(); }

  private:
    drivers::SampleSink& sink_;
    std::uint16_t path_;
};

}  // namespace cmm::acquisition
