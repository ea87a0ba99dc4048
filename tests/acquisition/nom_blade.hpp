// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <functional>
#include <sstream>
#include <string>
#include <vector>

#include "tests/acquisition/synthetic_blade.hpp"

/// A leaning blade of one section shape as a nominal file of PC-DMIS Blade: points and normals from its formulas.
namespace cmm::acquisition::nom {

using Eigen::Vector2d;
using Eigen::Vector3d;

struct Blade {
    synthetic::Shape shape;
    Vector2d lean = {std::tan(core::rad_from_deg(3.0)), std::tan(core::rad_from_deg(-4.0))};  // dx/dz, dy/dz
    std::vector<double> heights_mm = {10.0, 25.0, 40.0};
    std::size_t per_side = 120, per_edge = 60;

    Vector2d at_height(const Vector2d& p, double z_mm) const { return p + z_mm * lean; }
    /// Of the surface: the walls go up along (lean, 1).
    Vector3d normal(const Vector2d& in_plane) const {
        return Vector3d(in_plane.x(), in_plane.y(), -in_plane.dot(lean)).normalized();
    }
    double lean_at(const Vector2d& in_plane) const { return std::asin(normal(in_plane).z()); }
};

struct Writing {
    bool inches = false, clockwise = false, closing_point = false;
    const char* separator = " ";
    bool nose_at_te = false;
    /// Minus and plus tolerance of a point at a height, mm; none: the file has no tolerances.
    std::function<std::pair<double, double>(const synthetic::ContourPoint&, double z_mm)> tolerance = {};
    std::string words = {};                // after the points of NOSE
    std::vector<std::size_t> starts = {};  // the point with which each section begins; none: the nose
};

inline std::string section_name(std::size_t k) {
    return std::string(1, static_cast<char>('A' + k)) + "-" + static_cast<char>('A' + k);
}

inline std::string written(const Blade& blade, const Writing& how = {}) {
    auto contour = synthetic::Section(blade.shape).contour(blade.per_side, blade.per_edge);
    // The nose is the first point, the tail in the middle of the TE arc.
    std::size_t nose = 0, tail = blade.per_edge / 2 + blade.per_side + blade.per_edge / 2;
    if (how.clockwise) {
        std::reverse(contour.begin(), contour.end());
        nose = contour.size() - 1 - nose;
        tail = contour.size() - 1 - tail;
    }
    if (how.closing_point) contour.push_back(contour.front());
    if (how.nose_at_te) std::swap(nose, tail);
    const double scale = how.inches ? 1.0 / 25.4 : 1.0;
    std::ostringstream out;
    out.precision(12);
    out << "! a blade from formulas\nUNITS " << (how.inches ? "INCH" : "MM") << "\nNUM_SECT " << blade.heights_mm.size()
        << '\n';
    for (std::size_t k = 0; k < blade.heights_mm.size(); ++k) {
        const double z = blade.heights_mm[k];
        const std::size_t n = contour.size(), start = how.starts.empty() ? 0 : how.starts[k];
        out << "SECTION " << section_name(k) << ' ' << contour.size() << ' ' << scale * z << (k == 0 ? " I\n" : "\n")
            << "NOSE " << (nose + n - start) % n + 1 << how.words << "\nTAIL " << (tail + n - start) % n + 1
            << "\nOFFSETS " << scale * 1.5 << ' ' << scale * 1.2 << '\n';
        for (std::size_t i = 0; i < n; ++i) {
            const auto& point = contour[(start + i) % n];
            const Vector2d p = scale * blade.at_height(point.position_mm, z);
            const Vector3d n = blade.normal(point.normal);
            const char* s = how.separator;
            out << p.x() << s << p.y() << s << scale * z << s << n.x() << s << n.y() << s << n.z();
            if (how.tolerance) {
                const auto [minus, plus] = how.tolerance(point, z);
                out << s << scale * minus << s << scale * plus;
            }
            out << '\n';
        }
    }
    return out.str();
}

}  // namespace cmm::acquisition::nom
