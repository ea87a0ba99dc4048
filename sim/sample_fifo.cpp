// SPDX-License-Identifier: Apache-2.0
#include "sim/sample_fifo.hpp"

namespace cmm::sim {

std::uint32_t SampleFifo::push(FifoSample sample) {
    sample.seq = ++newest_;
    samples_.push_back(sample);
    return newest_;
}

bool SampleFifo::acknowledge(std::uint32_t seq) {
    if (seq > newest_) return false;
    while (!samples_.empty() && samples_.front().seq <= seq)
        samples_.pop_front();
    return true;
}

}  // namespace cmm::sim
