// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <string>
#include <string_view>
#include <vector>

#include "core/text.hpp"

/// NASA Rotor 37, Table IV (13 stream surfaces, columns J Z R THETA1 THETA2, centimetres and radians) as a TurboGrid
/// .crv in millimetres: x = R sin theta, y = R cos theta, z; each profile runs along the first side and back along the
/// second.
namespace cmm::sim::test {

inline std::string rotor37_crv(std::string_view table) {
    std::string crv;
    std::vector<std::string> there, back;
    int profile = 0;
    const auto close_profile = [&] {
        if (there.empty()) return;
        crv += "# Rotor37 Profile " + std::to_string(++profile) + "\n";
        for (const auto& line : there)
            crv += line;
        // Both sides share the first and the last point.
        for (std::size_t i = back.size() - 1; i-- > 0;)
            crv += back[i];
        there.clear();
        back.clear();
    };
    while (!table.empty()) {
        const auto end = std::min(table.find('\n'), table.size());
        const auto fields = core::split(table.substr(0, end), ' ');
        table.remove_prefix(std::min(end + 1, table.size()));
        if (!fields.empty() && fields[0] == "SURFACE") close_profile();
        std::vector<double> v;
        for (const auto field : fields) {
            if (const auto number = core::parse_number(field)) v.push_back(*number);
        }
        if (fields.size() != 5 || v.size() != 5) continue;
        const auto line = [&](double theta) {
            const double r = 10.0 * v[2];
            return core::fixed(r * std::sin(theta), 7) + " " + core::fixed(r * std::cos(theta), 7) + " " +
                   core::fixed(10.0 * v[1], 7) + "\n";
        };
        there.push_back(line(v[3]));
        back.push_back(line(v[4]));
    }
    close_profile();
    return crv;
}

}  // namespace cmm::sim::test
