// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>

#include "sim/simulator.hpp"

namespace cmm::drivers::test {

inline constexpr double part_radius_mm = 20.0;
inline constexpr double ball_radius_mm = 1.0;
inline constexpr double centre_radius_mm = part_radius_mm + ball_radius_mm;

/// A folder with a simulated part in it: a prism of 360 facets about the z axis.
class Workshop {
  public:
    Workshop() : folder_(std::filesystem::temp_directory_path() / ("cmm-drivers-" + std::to_string(::getpid()))) {
        std::filesystem::create_directories(folder_);
        write_prism();
        std::ofstream part(folder_ / "part.toml");
        part << "[part]\nname = \"prism\"\nkind = \"blade\"\n[nominal]\nkind = \"none\"\n"
             << "[stylus]\nradius_mm = 1.0\nshank_radius_mm = 0.6\nlength_mm = 20.0\n"
             << "[scan]\nheights_mm = [20]\npitch_mm = 0.4\nmax_speed_mm_s = 10\nbox_mm = [-25, -25, 25, 25]\n"
             << "[actual]\nkind = \"mesh\"\nfiles = [\"prism.ply\"]\nspan = \"z\"\nnoise_um = 0.0\nbad_points_percent "
                "= 0.0\n";
    }
    ~Workshop() { std::filesystem::remove_all(folder_); }

    std::unique_ptr<sim::Simulator> start(double speed, const sim::Listen& listen = {},
                                          const std::string& map = "config/maps/cmm-v1.toml") const {
        sim::SimulatorOptions options;
        options.listen = {listen};
        options.part_file = (folder_ / "part.toml").string();
        options.machine_file = "config/machines/sim.toml";
        options.map_file = map;
        options.speed = speed;
        auto started = sim::Simulator::start(options);
        EXPECT_TRUE(started) << started.error().text();
        return started ? std::move(*started) : nullptr;
    }

  private:
    void write_prism() const {
        constexpr int facets = 360;
        std::ofstream ply(folder_ / "prism.ply");
        ply << "ply\nformat ascii 1.0\nelement vertex " << 2 * facets + 2 << "\nproperty double x\nproperty double y\n"
            << "property double z\nelement face " << 4 * facets
            << "\nproperty list uchar int vertex_indices\nend_header\n";
        ply.precision(12);
        for (const double z : {0.0, 40.0}) {
            for (int k = 0; k < facets; ++k) {
                const double angle = 2.0 * 3.141592653589793 * k / facets;
                ply << part_radius_mm * std::cos(angle) << ' ' << part_radius_mm * std::sin(angle) << ' ' << z << '\n';
            }
        }
        ply << "0 0 0\n0 0 40\n";
        for (int k = 0; k < facets; ++k) {
            const int next = (k + 1) % facets;
            ply << "3 " << k << ' ' << next << ' ' << facets + next << '\n';
            ply << "3 " << k << ' ' << facets + next << ' ' << facets + k << '\n';
            ply << "3 " << 2 * facets << ' ' << next << ' ' << k << '\n';
            ply << "3 " << 2 * facets + 1 << ' ' << facets + k << ' ' << facets + next << '\n';
        }
    }
    std::filesystem::path folder_;
};

}  // namespace cmm::drivers::test
