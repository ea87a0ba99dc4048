// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "machine_rig.hpp"
#include "workshop.hpp"

namespace cmm::drivers::test {

/// Homes, qualifies and scans a ring of a simulated part; the samples as the driver gave them.
inline std::vector<core::Sample> scan_ring(const std::string& url, std::size_t count, LinkStats* stats = nullptr) {
    MachineRig rig(settings_for(url));
    Machine& machine = *rig.machine;
    RecordingSink sink;
    const auto expect_done = [](const auto& done) { EXPECT_TRUE(done) << done.error().text(); };
    const auto found = rig.run(machine.connect());
    expect_done(found);
    if (!found) return {};
    expect_done(rig.run(machine.begin_run(std::nullopt)));
    expect_done(rig.run(machine.home()));
    expect_done(rig.run(machine.qualify(ball_radius_mm)));
    expect_done(rig.run(machine.move({40.0, 0.0, 60.0}, 200.0)));
    expect_done(rig.run(machine.move({40.0, 0.0, 20.0}, 200.0)));
    const auto points = circle_path(centre_radius_mm, 20.0, count, 50.0);
    PointList source(points);
    expect_done(rig.run(machine.scan(ScanPath{.id = 3}, source, sink)));
    expect_done(rig.run(machine.end_run()));
    EXPECT_TRUE(sink.out_of_order.empty());
    EXPECT_EQ(sink.kept.size(), count);
    if (stats != nullptr) *stats = machine.link_stats();
    return sink.kept;
}

}  // namespace cmm::drivers::test
