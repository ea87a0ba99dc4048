// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "acquisition/events.hpp"
#include "acquisition/journal.hpp"
#include "acquisition/nominal.hpp"
#include "acquisition/part_file.hpp"
#include "acquisition/plan.hpp"
#include "acquisition/section_setup.hpp"
#include "core/sample.hpp"
#include "tests/acquisition/test_blade.hpp"

/// A blade of two sections, its plan and its samples, for the tests of the session.
namespace cmm::acquisition {

inline constexpr double test_lsb_mm = 1e-4;

inline std::string session_part_text(const std::string& pitch_mm = "1.0") {
    return R"([part]
name = "blade"
serial = "7"
[nominal]
kind = "parametric"
)" + blade_table +
           R"([stylus]
radius_mm = 1.0
[scan]
heights_mm = [20, 40]
pitch_mm = )" +
           pitch_mm +
           R"(
[gate]
profile_mm = 0.1
edge_profile_mm = 0.1
)";
}

/// The same blade upright: a prism.
inline std::string upright_part_text() {
    auto text = session_part_text();
    for (const auto& [from, to] : {std::pair{"stagger_tip_deg = 28", "stagger_tip_deg = 20"},
                                   {"lean_x_deg = 2", "lean_x_deg = 0"},
                                   {"lean_y_deg = -3", "lean_y_deg = 0"},
                                   {"chord_tip_mm = 25", "chord_tip_mm = 30"},
                                   {"thickness_tip_mm = 2.5", "thickness_tip_mm = 3.0"}})
        text.replace(text.find(from), std::string(from).size(), to);
    return text;
}

struct SessionPart {
    std::string text;
    PartFile part;
    std::shared_ptr<const Nominal> nominal;
    Plan plan;

    explicit SessionPart(const std::string& part_text = session_part_text())
        : text(part_text),
          part(parse_part_file(text, "blade.toml").value()),
          nominal(load_nominal(part.nominal).value()),
          plan(make_plan(part, nominal.get()).value()) {}
    SectionSetup setup(std::size_t index) const {
        return make_section_setup(part, nominal.get(), index, plan.paths.at(index).z_mm).value();
    }
};

inline core::Sample sample_at(std::uint64_t sequence, std::uint16_t path, const Eigen::Vector3d& centre_mm) {
    core::Sample sample;
    sample.sequence = sequence;
    sample.machine_time_us = static_cast<std::int64_t>(2000 * sequence);
    sample.host_time_ns = static_cast<std::int64_t>(1'000'000'000 + 1'000'000 * sequence);
    for (std::size_t axis = 0; axis < 3; ++axis) {
        sample.counts[axis] =
            static_cast<std::int32_t>(std::lround(centre_mm[static_cast<Eigen::Index>(axis)] / test_lsb_mm));
    }
    sample.path = path;
    return sample;
}

/// The samples of a planned path on a part that is thicker by `thicken_mm`.
inline std::vector<core::Sample> samples_of(const PlannedPath& planned, std::uint16_t path,
                                            std::uint64_t first_sequence, double thicken_mm = 0.0) {
    std::vector<core::Sample> samples;
    for (const auto& point : planned.points) {
        samples.push_back(
            sample_at(first_sequence + samples.size(), path, point.centre_mm + thicken_mm * point.normal));
    }
    return samples;
}

inline Journal::Header session_header(const SessionPart& job) {
    Journal::Header header;
    header.run_id = "run-1";
    header.started_utc = "2025-01-02T03:04:05Z";
    header.part_path = "blade.toml";
    header.part_text = job.text;
    header.machine_url = "test:";
    header.machine_model = "M";
    header.machine_serial = "1";
    header.software_version = "test";
    header.plan_hash = job.plan.hash;
    header.lsb_mm = test_lsb_mm;
    header.ball_radius_mm = job.part.stylus.radius_mm;
    return header;
}

/// Keeps the events of a hub. Read it when nothing emits any more.
class EventLog {
  public:
    explicit EventLog(EventHub& hub) {
        hub.listen([this](const Event& event) { events_.push_back(event); });
    }
    const std::vector<Event>& all() const { return events_; }
    std::vector<Event> of(EventKind kind) const {
        std::vector<Event> found;
        for (const auto& event : events_)
            if (event.kind == kind) found.push_back(event);
        return found;
    }

  private:
    std::vector<Event> events_;
};

inline bool holds(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
}

}  // namespace cmm::acquisition
