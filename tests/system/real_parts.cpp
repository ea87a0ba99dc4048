// SPDX-License-Identifier: Apache-2.0
#include "tests/system/real_parts.hpp"

#include <filesystem>
#include <fstream>
#include <sstream>

#include "core/text.hpp"
#include "tests/sim/rotor37.hpp"

namespace cmm::test {
namespace {

std::vector<double> heights(double from_mm, double to_mm, int count) {
    std::vector<double> all;
    for (int i = 0; i < count; ++i)
        all.push_back(from_mm + (to_mm - from_mm) * i / (count - 1));
    return all;
}

std::string sections_of(const std::string& file) {
    return "kind = \"sections\"\nfiles = [\"" + file + "\"]\n";
}

}  // namespace

std::string real_data_folder() {
    const std::string folder = std::filesystem::weakly_canonical(project_root() + "/../shared/data").string();
    return std::filesystem::exists(folder + "/engine-blade/engine-blade.ply") ? folder : "";
}

std::vector<RealPart> real_parts(const TemporaryFolder& folder) {
    const std::string data = real_data_folder();
    const std::string rotor37 = folder / "rotor37.crv";
    std::ofstream(rotor37) << sim::test::rotor37_crv(
        core::read_file(data + "/rotor37/cffc_rotor37geometry.dat").value_or(""));
    const std::string mesh = "kind = \"mesh\"\nfiles = [\"" + data + "/engine-blade/engine-blade.ply\"]\n";
    const std::string rotor1 = sections_of(data + "/hannover-4ac/1_Rotor1_Blade.crv");
    const std::string stator1 = sections_of(data + "/hannover-4ac/2_Stator1_Vane.crv");
    return {
        {"engine_blade", mesh, mesh, heights(300, 370, 15), 1.0, 0.2},
        {"hannover_rotor1", rotor1, rotor1, heights(80, 170, 10)},
        {"hannover_stator1", stator1, stator1, heights(88, 170, 10)},
        {"rotor37", sections_of(rotor37), sections_of(rotor37), heights(190, 240, 10)},
    };
}

std::string write_part(const RealPart& part, const TemporaryFolder& folder, bool unknown) {
    std::string file = folder / (part.name + (unknown ? "_unknown.toml" : ".toml"));
    std::ofstream out(file);
    out << "[part]\nname = \"" << part.name << "\"\nkind = \"blade\"\n\n[nominal]\n";
    out << (unknown ? "kind = \"none\"\n" : part.nominal);
    out << "\n[stylus]\nradius_mm = " << part.ball_radius_mm << "\n\n[scan]\nheights_mm = [";
    for (std::size_t i = 0; i < part.heights_mm.size(); ++i)
        out << (i > 0 ? ", " : "") << part.heights_mm[i];
    out << "]\npitch_mm = " << part.pitch_mm << "\nedge_density = 4.0\nmax_speed_mm_s = 20\n\n[actual]\n"
        << part.actual;
    out << "noise_um = 1.0\nbad_points_percent = 1.0\n";
    return file;
}

}  // namespace cmm::test
