// SPDX-License-Identifier: Apache-2.0
// Run files of others, which replay, fit and export open. The first byte chooses: the packed samples of a batch, with a
// checksum that fits, or a whole run file of ours with bytes changed: three bytes each, where (two) and to what.
#include <zstd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "acquisition/recorded_machine.hpp"
#include "acquisition/recording.hpp"
#include "acquisition/run_file.hpp"
#include "fuzz/work_file.hpp"

namespace {

using namespace cmm::acquisition;
using Bytes = std::vector<std::uint8_t>;

/// A small whole run, as its bytes.
Bytes good_file(const std::string& file) {
    std::filesystem::remove(file);
    Journal::Header header;
    header.lsb_mm = 1e-4;
    header.plan_hash = "0123456789abcdef";
    header.capabilities = capability_numbers({});
    if (!RunFile::create(file, header)) std::abort();
    {
        const auto out = RunFile::open(file, RunFile::Access::write);
        std::vector<cmm::core::Sample> samples(40);
        for (std::size_t k = 0; k < samples.size(); ++k) {
            samples[k].sequence = k + 1;
            samples[k].path = 1;
        }
        const bool written = out && (*out)->add_path({1, 0, 0, true}) && (*out)->add_batch(samples) &&
                             (*out)->add_event(1, "RunStarted", "{}") && (*out)->settle();
        if (!written) std::abort();
    }
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

void read_everything(const std::string& file) {
    const auto recording = Recording::load(file);
    if (recording) static_cast<void>(recorded_capabilities(recording->header()));
    const auto journal = Journal::read(file);
    if (!journal) return;
    static_cast<void>((*journal)->verdict());
    static_cast<void>((*journal)->last_event_seq());
    static_cast<void>((*journal)->each_event(0, [](auto, auto) { return cmm::core::Status{}; }));
}

void change_and_read(std::span<const std::uint8_t> changes) {
    static const WorkFile work(".cmmrun");
    static const Bytes good = good_file(work.name());
    Bytes image = good;
    for (; changes.size() >= 3; changes = changes.subspan(3)) {
        const std::size_t at = changes[0] + std::size_t{changes[1]} * 256;
        image[at % image.size()] = changes[2];
    }
    if (changes.size() == 2) image.resize((changes[0] + std::size_t{changes[1]} * 256) % image.size());
    work.remove_companions();
    read_everything(work.holds(image));
}

void decode(std::span<const std::uint8_t> packed) {
    std::vector<cmm::core::Sample> samples;
    static_cast<void>(decode_samples(packed, samples));
    if (packed.size() < 2) return;
    Bytes batch{1, packed[0], packed[1], 0, 0, 0, 0};
    const auto columns = packed.subspan(2);
    const auto crc = crc32(columns);
    for (std::size_t k = 0; k < 4; ++k)
        batch[3 + k] = static_cast<std::uint8_t>(crc >> (8 * k));
    const std::size_t head = batch.size();
    batch.resize(head + ZSTD_compressBound(columns.size()));
    const auto size = ZSTD_compress(batch.data() + head, batch.size() - head, columns.data(), columns.size(), 1);
    batch.resize(head + size);
    if (decode_samples(batch, samples) && samples.size() != packed[0] + std::size_t{packed[1]} * 256) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    if (size == 0) return 0;
    const std::span<const std::uint8_t> bytes(data + 1, size - 1);
    if (data[0] % 2 == 0) {
        decode(bytes);
    } else {
        change_and_read(bytes);
    }
    return 0;
}
