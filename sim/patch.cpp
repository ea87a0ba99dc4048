// SPDX-License-Identifier: Apache-2.0
#include "sim/patch.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "sim/tessellate.hpp"

namespace cmm::sim {

struct PatchSurface::Foot {
    double u = 0.0, v = 0.0;
    PatchPoint at;
    double distance_sq = 0.0;
};

namespace {

constexpr int most_iterations = 40;
// A Newton step this short ends within about its square of the foot, and the distance errs with the square of that.
constexpr double foot_tolerance_mm = 1e-6;

struct Step {
    double u, v;
};

/// Newton's step for 1/2 |S - P|^2 within v's limits; Gauss-Newton's where the Hessian is not positive (P beyond the
/// centre of curvature). At a limit that the step would cross v stays there and u alone moves.
Step newton_step(const PatchPoint& at, const Eigen::Vector3d& offset, double to_low, double to_high) {
    const double gu = at.su.dot(offset), gv = at.sv.dot(offset);
    double a = at.su.dot(at.su) + offset.dot(at.suu);
    double b = at.su.dot(at.sv) + offset.dot(at.suv);
    double c = at.sv.dot(at.sv) + offset.dot(at.svv);
    if (a <= 0.0 || a * c - b * b <= 1e-12 * a * std::abs(c)) {
        a = at.su.dot(at.su);
        b = at.su.dot(at.sv);
        c = at.sv.dot(at.sv);
    }
    const double det = a * c - b * b;
    Step step{(b * gv - c * gu) / det, (b * gu - a * gv) / det};
    if (step.v < to_low || step.v > to_high) {
        step.v = std::clamp(step.v, to_low, to_high);
        step.u = -(gu + b * step.v) / a;
    }
    return step;
}

/// The largest distance between a facet and the patch, looked for in the middle of both triangles of every cell.
double measured_chord(const Patch& patch, const std::vector<double>& u, const std::vector<double>& v) {
    double worst = 0.0;
    for (std::size_t k = 0; k + 1 < v.size(); ++k) {
        for (std::size_t i = 0; i + 1 < u.size(); ++i) {
            const Eigen::Vector3d diagonal = 0.5 * (patch.point(u[i], v[k]) + patch.point(u[i + 1], v[k + 1]));
            const PatchPoint middle = patch.at(0.5 * (u[i] + u[i + 1]), 0.5 * (v[k] + v[k + 1]));
            const Eigen::Vector3d normal = middle.su.cross(middle.sv).normalized();
            worst = std::max(worst, std::abs(normal.dot(middle.s - diagonal)));
        }
    }
    return worst;
}

}  // namespace

PatchSurface::PatchSurface(std::shared_ptr<const Patch> patch, double chord_mm)
    : patch_(std::move(patch)), facets_([&] {
          PatchLines lines = choose_lines(*patch_, chord_mm);
          TriangleMesh mesh = tessellate(*patch_, lines);
          u_ = std::move(lines.u);
          v_ = std::move(lines.v);
          return mesh;
      }()) {
    chord_error_mm_ = std::max(chord_mm, measured_chord(*patch_, u_, v_));
}

PatchSurface::Foot PatchSurface::start(const Bvh::Hit& hit) const {
    const std::size_t columns = u_.size() - 1, cell = hit.triangle / 2;
    const std::size_t i = cell % columns, k = cell / columns;
    const auto& corners = facets_.mesh().triangles[hit.triangle];
    const auto& vertices = facets_.mesh().vertices;
    const Eigen::Vector3d ab = vertices[corners[1]] - vertices[corners[0]],
                          ac = vertices[corners[2]] - vertices[corners[0]];
    const Eigen::Vector3d ap = hit.point - vertices[corners[0]], n = ab.cross(ac);
    const double nn = n.squaredNorm();
    const double wb = nn > 0.0 ? n.dot(ap.cross(ac)) / nn : 0.0, wc = nn > 0.0 ? n.dot(ab.cross(ap)) / nn : 0.0;
    const bool lower = hit.triangle % 2 == 0;  // corners (i,k) (i+1,k) (i+1,k+1); the upper one (i,k) (i+1,k+1) (i,k+1)
    Foot foot;
    foot.u = u_[i] + (u_[i + 1] - u_[i]) * (lower ? wb + wc : wb);
    foot.v = v_[k] + (v_[k + 1] - v_[k]) * (lower ? wc : wb + wc);
    return foot;
}

bool PatchSurface::refine(const Eigen::Vector3d& centre, Foot& foot) const {
    const auto place = [&](double u, double v) {
        Foot next{u, v, patch_->at(u, v), 0.0};
        next.distance_sq = (next.at.s - centre).squaredNorm();
        return next;
    };
    foot = place(foot.u, foot.v);
    for (int iteration = 0; iteration < most_iterations; ++iteration) {
        const Eigen::Vector3d offset = foot.at.s - centre;
        const Step step = newton_step(foot.at, offset, v_.front() - foot.v, v_.back() - foot.v);
        const double length = (foot.at.su * step.u + foot.at.sv * step.v).norm();
        double part = 1.0;
        Foot next = place(foot.u + step.u, foot.v + step.v);
        if (length < foot_tolerance_mm) {
            foot = next;
            return true;
        }
        // Close to the foot the square is flat and its rounding larger than its change.
        const double enough = foot.distance_sq + 1e-12 * std::sqrt(foot.distance_sq) + 1e-18;
        while (next.distance_sq > enough && part > 1e-6) {
            part *= 0.5;
            next = place(foot.u + part * step.u, foot.v + part * step.v);
        }
        if (next.distance_sq > enough) return false;
        foot = next;
    }
    return false;
}

Contact PatchSurface::nearest(const Eigen::Vector3d& centre_mm, std::size_t& warm) const {
    Bvh::Hit hit;
    Contact facet = facets_.nearest(centre_mm, warm, hit);
    const std::size_t tube = 2 * (u_.size() - 1) * (v_.size() - 1);
    if (hit.triangle >= tube) return facet;
    Foot foot = start(hit);
    const bool converged = refine(centre_mm, foot);
    const double distance = std::sqrt(foot.distance_sq);
    if (!converged || distance > std::abs(facet.distance_mm) + 2.0 * chord_error_mm_) return facet;
    const bool at_end = foot.v <= v_.front() || foot.v >= v_.back();
    const Eigen::Vector3d offset = centre_mm - foot.at.s;
    const Eigen::Vector3d normal = foot.at.su.cross(foot.at.sv).normalized();
    const double along = offset.dot(normal);
    // Nearest to the rim of an end, off the tube's normal: the direction is the offset itself, the side that of the
    // facet.
    if (at_end && distance - std::abs(along) > 1e-9) {
        const double sign = facet.distance_mm < 0.0 ? -1.0 : 1.0;
        return {sign * distance, foot.at.s, offset * (sign / distance)};
    }
    return {along, foot.at.s, normal};
}

}  // namespace cmm::sim
