// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "acquisition/live_section.hpp"
#include "acquisition/measure_again.hpp"
#include "acquisition/part_frame.hpp"
#include "acquisition/section_result.hpp"
#include "drivers/link_stats.hpp"

/// The fields of each event (docs/cli.md, "Events") as JSON text without the outer braces.
namespace cmm::acquisition {

std::string batch_payload(std::size_t section, std::uint64_t first_sequence, std::size_t count);
std::string snapshot_payload(std::size_t section, const LiveSnapshot& snapshot);
/// How long after a section's last sample something is told, and what of that a processor worked for it.
struct TimeTaken {
    double latency_ms = 0.0, processor_ms = 0.0;
};
/// `taken`: none of a section that was restored.
std::string final_payload(const SectionResult& section, const std::optional<TimeTaken>& taken);
std::string revised_payload(const SectionResult& section);
std::string rejected_payload(std::size_t section, const RecordedPoint& point);
std::string restored_payload(std::size_t section, const RecordedPoint& point);
std::string characteristic_payload(std::size_t section, const Characteristic& characteristic);
/// Of a characteristic that needs several sections: `of_part`, and section null where it is of the whole part.
std::string characteristic_payload(const PartCharacteristic& characteristic);
std::string exceedance_payload(std::size_t section, const Exceedance& exceedance, double latency_ms);
/// Before the pass is driven: why, and what was known then.
std::string again_payload(const SectionResult& section, std::size_t pass, const AgainPass& planned);
/// `certain`: rejected whatever is still measured. `taken`: none of a section that was judged anew, either.
std::string decision_payload(std::size_t section, Decision decision, bool certain,
                             const std::optional<TimeTaken>& taken);
std::string frame_payload(const PartFrame& frame);
std::string link_payload(const drivers::LinkStats& stats);

}  // namespace cmm::acquisition
