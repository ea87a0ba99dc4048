// SPDX-License-Identifier: Apache-2.0
#include "bench/dense_blade.hpp"

#include <fstream>
#include <utility>

namespace cmm::bench {

std::string part_file(const std::string& config_folder, const std::filesystem::path& folder, const DenseBlade& blade) {
    std::ifstream in(config_folder + "/parts/demo.toml");
    const auto file = folder / (std::string(blade.name) + ".toml");
    std::ofstream out(file);
    for (std::string line; std::getline(in, line);) {
        if (line.starts_with("count")) line = "count = " + std::to_string(blade.sections);
        if (line.starts_with("pitch_mm")) line = "pitch_mm = " + std::to_string(blade.pitch_mm);
        if (line.starts_with("edge_density")) line = "edge_density = " + std::to_string(blade.edge_density);
        out << line << "\n";
    }
    return file;
}

core::Result<acquisition::ScanRequest> scan_request(const std::string& part_file, const std::string& run_file) {
    auto part = acquisition::load_part_file(part_file);
    if (!part) return tl::unexpected(part.error());
    auto nominal = acquisition::load_nominal(part->nominal);
    if (!nominal) return tl::unexpected(nominal.error());
    acquisition::ScanRequest request;
    request.part = std::move(*part);
    request.nominal = std::move(*nominal);
    request.run_file = run_file;
    return request;
}

}  // namespace cmm::bench
