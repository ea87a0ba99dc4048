// SPDX-License-Identifier: Apache-2.0
#include "sim/truth_log.hpp"

#include <cerrno>
#include <cinttypes>
#include <cstring>

#include "core/units.hpp"

namespace cmm::sim {

core::Result<std::unique_ptr<TruthLog>> TruthLog::open(const std::string& file) {
    std::FILE* handle = std::fopen(file.c_str(), "a");
    if (handle == nullptr)
        return core::fail(core::ErrorCode::journal_io,
                          "cannot write the truth log " + file + ": " + std::strerror(errno));
    std::fseek(handle, 0, SEEK_END);
    if (std::ftell(handle) == 0)
        std::fputs(
            "boot_id,seq,path,index,t_us,x_counts,y_counts,z_counts,true_x_mm,true_y_mm,true_z_mm,noise_um,bad_um,"
            "flags\n",
            handle);
    return std::unique_ptr<TruthLog>(new TruthLog(handle));
}

void TruthLog::write(const SampleTruth& truth, std::uint16_t boot_id) {
    const FifoSample& sample = truth.sample;
    std::fprintf(file_.get(),
                 "%u,%" PRIu32 ",%u,%" PRId64 ",%" PRId64 ",%" PRId32 ",%" PRId32 ",%" PRId32
                 ",%.7f,%.7f,%.7f,%.4f,%.4f,%u\n",
                 unsigned{boot_id}, sample.seq, unsigned{sample.path}, truth.index, sample.time_us, sample.counts[0],
                 sample.counts[1], sample.counts[2], truth.centre_mm.x(), truth.centre_mm.y(), truth.centre_mm.z(),
                 core::um_from_mm(truth.noise_mm), core::um_from_mm(truth.bad_mm), unsigned{sample.quality});
}

void TruthLog::flush_if_due(core::Duration now) {
    if (now - last_flush_ < std::chrono::milliseconds(100)) return;
    std::fflush(file_.get());
    last_flush_ = now;
}

}  // namespace cmm::sim
