// SPDX-License-Identifier: Apache-2.0
#include "sim/tessellate.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>

namespace cmm::sim {

namespace {

constexpr int deepest_halving = 10;
constexpr int least_halving = 1;

/// Halves an interval until the middle of every sampled curve lies within `chord_mm` of its chord; appends the upper
/// ends.
void halve(const std::function<Eigen::Vector3d(double, double)>& curve, const std::vector<double>& samples,
           double chord_mm, double low, double high, int depth, std::vector<double>& lines) {
    const double middle = 0.5 * (low + high);
    const bool bent = depth < least_halving || std::any_of(samples.begin(), samples.end(), [&](double sample) {
                          const Eigen::Vector3d from = curve(low, sample), chord = curve(high, sample) - from;
                          const Eigen::Vector3d sag = curve(middle, sample) - from;
                          const double length = chord.norm();
                          return (length > 0.0 ? sag.cross(chord).norm() / length : sag.norm()) > chord_mm;
                      });
    if (bent && depth < deepest_halving) {
        halve(curve, samples, chord_mm, low, middle, depth + 1, lines);
        halve(curve, samples, chord_mm, middle, high, depth + 1, lines);
        return;
    }
    lines.push_back(high);
}

std::vector<double> lines_along(const std::function<Eigen::Vector3d(double, double)>& curve,
                                const std::vector<double>& breaks, const std::vector<double>& samples,
                                double chord_mm) {
    std::vector<double> lines{breaks.front()};
    for (std::size_t i = 0; i + 1 < breaks.size(); ++i) {
        halve(curve, samples, chord_mm, breaks[i], breaks[i + 1], 0, lines);
    }
    return lines;
}

std::vector<double> thinned(const std::vector<double>& lines, std::size_t number) {
    const std::size_t step = std::max<std::size_t>(1, lines.size() / number);
    std::vector<double> some;
    for (std::size_t i = 0; i < lines.size(); i += step)
        some.push_back(lines[i]);
    return some;
}

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c) {
    return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
}

}  // namespace

PatchLines choose_lines(const Patch& patch, double chord_mm) {
    const auto& v_breaks = patch.v_breaks();
    std::vector<double> heights;
    for (int i = 0; i <= 8; ++i)
        heights.push_back(std::lerp(v_breaks.front(), v_breaks.back(), i / 8.0));
    PatchLines lines;
    lines.u = lines_along([&](double u, double v) { return patch.point(u, v); }, patch.u_breaks(), heights, chord_mm);
    lines.v =
        lines_along([&](double v, double u) { return patch.point(u, v); }, v_breaks, thinned(lines.u, 48), chord_mm);
    return lines;
}

TriangleMesh tessellate(const Patch& patch, const PatchLines& lines) {
    TriangleMesh mesh;
    const auto ring = static_cast<std::uint32_t>(lines.u.size() - 1);
    for (const double v : lines.v) {
        for (std::uint32_t i = 0; i < ring; ++i)
            mesh.vertices.push_back(patch.point(lines.u[i], v));
    }
    const auto rings = static_cast<std::uint32_t>(lines.v.size());
    for (std::uint32_t k = 0; k + 1 < rings; ++k) {
        for (std::uint32_t i = 0; i < ring; ++i) {
            const std::uint32_t next = (i + 1) % ring, low = k * ring, high = low + ring;
            mesh.triangles.push_back({low + i, low + next, high + next});
            mesh.triangles.push_back({low + i, high + next, high + i});
        }
    }
    for (const bool top : {false, true}) {
        const std::uint32_t first = top ? (rings - 1) * ring : 0;
        std::vector<Eigen::Vector2d> loop;
        for (std::uint32_t i = 0; i < ring; ++i)
            loop.push_back(mesh.vertices[first + i].head<2>());
        for (auto [a, b, c] : fill_polygon(loop)) {
            if (!top) std::swap(b, c);
            mesh.triangles.push_back({first + a, first + b, first + c});
        }
    }
    return mesh;
}

std::vector<std::array<std::uint32_t, 3>> fill_polygon(const std::vector<Eigen::Vector2d>& loop) {
    std::vector<std::uint32_t> left(loop.size());
    std::iota(left.begin(), left.end(), 0U);
    std::vector<std::array<std::uint32_t, 3>> triangles;
    const auto is_ear = [&](std::size_t i) {
        const std::size_t n = left.size();
        const auto ia = left[(i + n - 1) % n], ib = left[i], ic = left[(i + 1) % n];
        const auto &a = loop[ia], &b = loop[ib], &c = loop[ic];
        if (cross(a, b, c) <= 0.0) return false;
        return std::none_of(left.begin(), left.end(), [&](std::uint32_t j) {
            if (j == ia || j == ib || j == ic) return false;
            return cross(a, b, loop[j]) >= 0.0 && cross(b, c, loop[j]) >= 0.0 && cross(c, a, loop[j]) >= 0.0;
        });
    };
    std::size_t at = 0;
    while (left.size() > 2) {
        const std::size_t n = left.size();
        std::size_t tries = 0;
        while (tries < n && !is_ear((at + tries) % n))
            ++tries;
        // A polygon that crosses itself has no ear at some point: cut anyway, the result is still closed.
        const std::size_t ear = (at + (tries < n ? tries : 0)) % n;
        triangles.push_back({left[(ear + n - 1) % n], left[ear], left[(ear + 1) % n]});
        left.erase(left.begin() + static_cast<std::ptrdiff_t>(ear));
        at = ear % left.size();
    }
    return triangles;
}

}  // namespace cmm::sim
