// SPDX-License-Identifier: Apache-2.0
// Files of PC-DMIS Blade that users bring: nominals (.NOM) and tolerances (.TOL). The first byte chooses.
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <vector>

#include "acquisition/nom_file.hpp"
#include "acquisition/tol_characteristics.hpp"
#include "acquisition/tol_file.hpp"

namespace {

using namespace cmm::acquisition;

/// Whatever was read is finite and whole: a normal and a tolerance for each point, or no tolerances.
void check(const NomFile& file) {
    for (const NomSection& section : file.sections) {
        if (section.normals.size() != section.points_mm.size()) std::abort();
        if (!section.tolerances.empty() && section.tolerances.size() != section.points_mm.size()) std::abort();
        for (std::size_t i = 0; i < section.points_mm.size(); ++i)
            if (!section.points_mm[i].allFinite() || std::abs(section.normals[i].norm() - 1.0) > 1e-9) std::abort();
        for (const auto& tolerance : section.tolerances)
            if (!(tolerance.below_mm < tolerance.above_mm)) std::abort();
    }
}

/// A characteristic that is asked for has a name and limits in order.
void check(const TolFile& file, const NomFile* nom, const std::vector<double>& heights) {
    const auto specs = characteristics_of(file, nom, heights);
    if (!specs) return;
    for (const CharacteristicSpec& spec : *specs) {
        if (spec.label.empty() || !spec.has_tolerance()) std::abort();
        if (spec.below && spec.above && !(*spec.below < *spec.above)) std::abort();
    }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    if (size == 0) return 0;
    const std::string text(data + 1, data + size);
    const std::vector<std::string> skip{"FORCE", "LE_RADII"};
    if (data[0] % 2 == 0) {
        if (const auto nom = parse_nom(text, "b.nom", skip)) check(*nom);
        return 0;
    }
    NomFile nom;
    nom.sections = {{"A-A", 10.0, false, {}, {}, {}, {}, {}, std::array<double, 2>{1.0, 1.5}},
                    {"B-B", 20.0, false, {}, {}, {}, {}, {}, {}}};
    if (const auto tol = parse_tol(text, "b.tol", skip, data[0] % 4 == 1)) {
        check(*tol, &nom, {10.0, 15.0, 20.0});
        check(*tol, nullptr, {10.0});
    }
    return 0;
}
