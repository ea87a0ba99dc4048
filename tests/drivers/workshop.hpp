// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <memory>
#include <string>

#include "sim/simulator.hpp"
#include "tests/support/prism_part.hpp"

namespace cmm::drivers::test {

using cmm::test::PrismPart;
inline constexpr double ball_radius_mm = PrismPart::ball_radius_mm;
inline constexpr double centre_radius_mm = PrismPart::radius_mm + PrismPart::ball_radius_mm;

/// A folder with a simulated part in it: a prism about the z axis.
class Workshop {
  public:
    ~Workshop() { std::filesystem::remove_all(folder_); }

    std::unique_ptr<sim::Simulator> start(double speed, const sim::Listen& listen = {},
                                          const std::string& map = "config/maps/cmm-v1.toml") const {
        sim::SimulatorOptions options;
        options.listen = {listen};
        options.part_file = part_.file();
        options.machine_file = "config/machines/sim.toml";
        options.map_file = map;
        options.speed = speed;
        auto started = sim::Simulator::start(options);
        EXPECT_TRUE(started) << started.error().text();
        return started ? std::move(*started) : nullptr;
    }

  private:
    static std::filesystem::path make_folder() {
        auto folder = std::filesystem::temp_directory_path() / ("cmm-drivers-" + std::to_string(::getpid()));
        std::filesystem::create_directories(folder);
        return folder;
    }
    std::filesystem::path folder_ = make_folder();
    PrismPart part_{folder_};
};

}  // namespace cmm::drivers::test
