// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "acquisition/contour_sampling.hpp"
#include "acquisition/nominal_kinds.hpp"
#include "core/text.hpp"
#include "fitting/vec2.hpp"

namespace cmm::acquisition {
namespace {

using core::ErrorCode;
using core::fail;
using Eigen::Vector2d;

// A spline through the bare corners of facets would swing between them: facets are cut into steps of at most this, and
// corners nearer to each other than the second are one.
constexpr double widest_step_mm = 0.05;
constexpr double same_corner_mm = 0.002;
// Slivers of a scanned mesh face anywhere; the lean is what all but this share of the contour stays below.
constexpr double sliver_share = 0.02;
constexpr std::size_t median_reach = 10;  // steps to either side: half a millimetre

/// Where the plane crosses an edge of the mesh, and the segments that end there.
struct Crossing {
    Vector2d position_mm;
    std::array<std::uint32_t, 2> next{};
    std::array<Eigen::Vector3d, 2> normal{};
    int links = 0;
};

struct Loop {
    std::vector<Vector2d> points;
    std::vector<Eigen::Vector3d> normal;  // of the segment from each point on: unit, or zero; any sense
};

class PlaneCut {
  public:
    PlaneCut(const TriangleMesh& mesh, double z_mm) : mesh_(mesh), z_(z_mm) {}

    /// The closed loops. Errors: input_invalid (open, or more than two facets at an edge).
    core::Result<std::vector<Loop>> loops() {
        for (const auto& triangle : mesh_.triangles) {
            if (!add(triangle))
                return fail(ErrorCode::input_invalid, at_plane() + "more than two facets meet at an edge");
        }
        for (const auto& crossing : crossings_) {
            if (crossing.links == 2) continue;
            return fail(ErrorCode::input_invalid,
                        at_plane() + "the mesh is open near x = " + core::fixed(crossing.position_mm.x(), 3) +
                            " mm, y = " + core::fixed(crossing.position_mm.y(), 3) + " mm");
        }
        std::vector<Loop> loops;
        std::vector<bool> seen(crossings_.size(), false);
        for (std::uint32_t i = 0; i < crossings_.size(); ++i) {
            if (!seen[i]) loops.push_back(walk(i, seen));
        }
        return loops;
    }

  private:
    /// A vertex in the plane counts as above it, so that every triangle has no or two crossings.
    bool above(std::uint32_t v) const { return mesh_.vertices[v].z() >= z_; }
    std::string at_plane() const { return "cut at z = " + core::fixed(z_, 3) + " mm: "; }

    bool add(const std::array<std::uint32_t, 3>& t) {
        std::array<std::uint32_t, 2> ends{};
        int found = 0;
        for (std::size_t i = 0; i < 3; ++i) {
            const auto a = t[i], b = t[(i + 1) % 3];
            if (above(a) != above(b))
                ends.at(static_cast<std::size_t>(found++)) = crossing(std::min(a, b), std::max(a, b));
        }
        if (found == 0) return true;
        const Eigen::Vector3d& p = mesh_.vertices[t[0]];
        const Eigen::Vector3d normal = (mesh_.vertices[t[1]] - p).cross(mesh_.vertices[t[2]] - p);
        const double size = normal.norm();
        const Eigen::Vector3d unit = size > 0.0 ? Eigen::Vector3d(normal / size) : Eigen::Vector3d(0.0, 0.0, 0.0);
        return link(ends[0], ends[1], unit) && link(ends[1], ends[0], unit);
    }

    std::uint32_t crossing(std::uint32_t low, std::uint32_t high) {
        const auto key = (static_cast<std::uint64_t>(low) << 32U) | high;
        const auto [at, is_new] = index_.emplace(key, static_cast<std::uint32_t>(crossings_.size()));
        if (is_new) {
            const auto &a = mesh_.vertices[low], &b = mesh_.vertices[high];
            const double part = (z_ - a.z()) / (b.z() - a.z());
            crossings_.push_back({(a + part * (b - a)).head<2>(), {}, {}, 0});
        }
        return at->second;
    }

    bool link(std::uint32_t from, std::uint32_t to, const Eigen::Vector3d& normal) {
        auto& crossing = crossings_[from];
        if (crossing.links == 2) return false;
        const auto slot = static_cast<std::size_t>(crossing.links++);
        crossing.next.at(slot) = to;
        crossing.normal.at(slot) = normal;
        return true;
    }

    Loop walk(std::uint32_t start, std::vector<bool>& seen) const {
        Loop loop;
        std::uint32_t before = start, here = start;
        do {
            const auto& crossing = crossings_[here];
            seen[here] = true;
            // Forwards: not back to where we came from (both links go to the same place in a loop of two).
            const std::size_t slot = here != start && crossing.next[0] == before ? 1 : 0;
            loop.points.push_back(crossing.position_mm);
            loop.normal.push_back(crossing.normal.at(slot));
            before = here;
            here = crossing.next.at(slot);
        } while (here != start);
        return loop;
    }

    const TriangleMesh& mesh_;
    double z_;
    std::unordered_map<std::uint64_t, std::uint32_t> index_;
    std::vector<Crossing> crossings_;
};

/// Of the segment from a point on, positive where its outward normal points upwards; the loop is counter-clockwise.
double lean_at(const Loop& loop, std::size_t i) {
    const Vector2d along = loop.points[(i + 1) % loop.points.size()] - loop.points[i];
    const Eigen::Vector3d& normal = loop.normal[i];
    const double lean = std::asin(std::clamp(normal.z(), -1.0, 1.0));
    return fitting::right_normal(along).dot(normal.head<2>()) < 0.0 ? -lean : lean;
}

double lean_of(const Loop& loop) {
    std::vector<std::pair<double, double>> parts;  // lean, length
    double total = 0.0;
    for (std::size_t i = 0; i < loop.points.size(); ++i) {
        const double length = (loop.points[(i + 1) % loop.points.size()] - loop.points[i]).norm();
        parts.emplace_back(std::abs(lean_at(loop, i)), length);
        total += length;
    }
    std::sort(parts.begin(), parts.end(), std::greater<>());
    double above = 0.0;
    for (const auto& [lean, length] : parts) {
        above += length;
        if (above > sliver_share * total) return lean;
    }
    return parts.empty() ? 0.0 : parts.back().first;
}

/// Counter-clockwise, without corners that repeat each other; the lean stays with the segment.
void tidy(Loop& loop) {
    if (signed_area(loop.points) < 0.0) {
        std::reverse(loop.points.begin() + 1, loop.points.end());
        std::reverse(loop.normal.begin(), loop.normal.end());
    }
    Loop kept;
    for (std::size_t i = 0; i < loop.points.size(); ++i) {
        if (!kept.points.empty() && (loop.points[i] - kept.points.back()).norm() <= same_corner_mm) continue;
        kept.points.push_back(loop.points[i]);
        kept.normal.push_back(loop.normal[i]);
    }
    while (kept.points.size() > 1 && (kept.points.front() - kept.points.back()).norm() <= same_corner_mm) {
        kept.points.pop_back();
        kept.normal.pop_back();
    }
    loop = std::move(kept);
}

/// Points at small even steps, each with the median lean of its neighbourhood.
NominalContour subdivided(double z_mm, const Loop& loop) {
    NominalContour contour;
    contour.z_mm = z_mm;
    contour.lean_rad = lean_of(loop);
    std::vector<double> leans;
    for (std::size_t i = 0; i < loop.points.size(); ++i) {
        const Vector2d &from = loop.points[i], &to = loop.points[(i + 1) % loop.points.size()];
        const auto steps = static_cast<int>(std::ceil(std::max(1.0, (to - from).norm() / widest_step_mm)));
        for (int k = 0; k < steps; ++k) {
            contour.points.emplace_back(from + (to - from) * (static_cast<double>(k) / steps));
            leans.push_back(lean_at(loop, i));
        }
    }
    const std::size_t n = leans.size(), reach = std::min(median_reach, n / 4);
    std::vector<double> near(2 * reach + 1);
    for (std::size_t i = 0; i < n; ++i) {
        for (std::size_t k = 0; k < near.size(); ++k)
            near[k] = leans[(i + n + k - reach) % n];
        std::nth_element(near.begin(), near.begin() + static_cast<std::ptrdiff_t>(reach), near.end());
        contour.leans_rad.push_back(near[reach]);
    }
    return contour;
}

class MeshNominal final : public Nominal {
  public:
    explicit MeshNominal(TriangleMesh mesh) : mesh_(std::move(mesh)) {
        const auto lower = [](const auto& a, const auto& b) { return a.z() < b.z(); };
        const auto [low, high] = std::minmax_element(mesh_.vertices.begin(), mesh_.vertices.end(), lower);
        z_low_ = low->z();
        z_high_ = high->z();
    }

    core::Result<NominalContour> cut(double z_mm) const override {
        if (auto status = require_height(z_mm, z_low_, z_high_); !status) return tl::unexpected(status.error());
        auto loops = PlaneCut(mesh_, z_mm).loops();
        if (!loops) return tl::unexpected(loops.error());
        const auto size = [](const Loop& loop) { return std::abs(signed_area(loop.points)); };
        const auto largest = std::max_element(loops->begin(), loops->end(),
                                              [&](const Loop& a, const Loop& b) { return size(a) < size(b); });
        if (largest == loops->end() || largest->points.size() < 4 || size(*largest) <= 0.0) {
            return fail(ErrorCode::input_invalid, "cut at z = " + core::fixed(z_mm, 3) + " mm: no closed contour");
        }
        tidy(*largest);
        return subdivided(z_mm, *largest);
    }
    double z_low_mm() const override { return z_low_; }
    double z_high_mm() const override { return z_high_; }

  private:
    TriangleMesh mesh_;
    double z_low_ = 0.0, z_high_ = 0.0;
};

}  // namespace

core::Result<std::shared_ptr<const Nominal>> mesh_nominal(TriangleMesh mesh, Span span) {
    if (mesh.triangles.size() < 4) return fail(ErrorCode::input_invalid, "the nominal mesh has fewer than 4 triangles");
    for (auto& vertex : mesh.vertices)
        vertex = turned_to_z(vertex, span);
    return std::make_shared<const MeshNominal>(std::move(mesh));
}

}  // namespace cmm::acquisition
