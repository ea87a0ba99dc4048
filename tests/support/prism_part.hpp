// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>

namespace cmm::test {

/// A part file in a folder: a prism of 360 facets about the z axis, 40 mm high, without noise and bad points, for a
/// ball of 1 mm radius. For tests and measurements of what lies between the machine and the fit.
class PrismPart {
  public:
    static constexpr double radius_mm = 20.0;
    static constexpr double height_mm = 40.0;
    static constexpr double ball_radius_mm = 1.0;

    /// Writes into the folder, which must exist.
    explicit PrismPart(const std::filesystem::path& folder) : file_(folder / "part.toml") {
        write_mesh(folder / "prism.ply");
        std::ofstream part(file_);
        part << "[part]\nname = \"prism\"\nkind = \"blade\"\n[nominal]\nkind = \"none\"\n"
             << "[stylus]\nradius_mm = 1.0\nshank_radius_mm = 0.6\nlength_mm = 20.0\n"
             << "[scan]\nheights_mm = [20]\npitch_mm = 0.4\nmax_speed_mm_s = 10\nbox_mm = [-25, -25, 25, 25]\n"
             << "[actual]\nkind = \"mesh\"\nfiles = [\"prism.ply\"]\nspan = \"z\"\nnoise_um = 0.0\nbad_points_percent "
                "= 0.0\n";
    }
    std::string file() const { return file_.string(); }

  private:
    static void write_mesh(const std::filesystem::path& file) {
        constexpr int facets = 360;
        std::ofstream ply(file);
        ply << "ply\nformat ascii 1.0\nelement vertex " << 2 * facets + 2 << "\nproperty double x\nproperty double y\n"
            << "property double z\nelement face " << 4 * facets
            << "\nproperty list uchar int vertex_indices\nend_header\n";
        ply.precision(12);
        for (const double z : {0.0, height_mm}) {
            for (int k = 0; k < facets; ++k) {
                const double angle = 2.0 * 3.141592653589793 * k / facets;
                ply << radius_mm * std::cos(angle) << ' ' << radius_mm * std::sin(angle) << ' ' << z << '\n';
            }
        }
        ply << "0 0 0\n0 0 " << height_mm << '\n';
        for (int k = 0; k < facets; ++k) {
            const int next = (k + 1) % facets;
            ply << "3 " << k << ' ' << next << ' ' << facets + next << '\n';
            ply << "3 " << k << ' ' << facets + next << ' ' << facets + k << '\n';
            ply << "3 " << 2 * facets << ' ' << next << ' ' << k << '\n';
            ply << "3 " << 2 * facets + 1 << ' ' << facets + k << ' ' << facets + next << '\n';
        }
    }
    std::filesystem::path file_;
};

}  // namespace cmm::test
