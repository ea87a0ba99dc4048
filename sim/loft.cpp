// SPDX-License-Identifier: Apache-2.0
#include "sim/loft.hpp"

#include <algorithm>
#include <cmath>

#include "core/text.hpp"
#include "sim/profiles.hpp"

namespace cmm::sim {

using core::ErrorCode;
using core::fail;

core::Result<std::shared_ptr<const LoftPatch>> LoftPatch::make(std::vector<Points> profiles, double beyond_mm) {
    if (profiles.size() < 2) return fail(ErrorCode::input_invalid, "a loft needs at least two profiles");
    for (const auto& profile : profiles) {
        if (profile.size() < least_profile_points) {
            return fail(ErrorCode::input_invalid, "a profile of " + std::to_string(profile.size()) +
                                                      " points; it needs at least " +
                                                      std::to_string(least_profile_points));
        }
    }
    profiles = joined_profiles(std::move(profiles));
    std::shared_ptr<const LoftPatch> patch(new LoftPatch(profiles, beyond_mm));
    for (std::size_t k = 1; k < patch->v_.size(); ++k) {
        if (patch->v_[k] - patch->v_[k - 1] < 1e-6) {
            const double z = mean_of(profiles[k]).z();
            return fail(ErrorCode::input_invalid,
                        "two profiles in the same place, at about z = " + core::fixed(z, 3) + " mm");
        }
    }
    return patch;
}

LoftPatch::LoftPatch(const std::vector<Points>& profiles, double beyond_mm) {
    const std::size_t n = profiles.front().size(), m = profiles.size();
    u_.assign(n + 1, 0.0);
    for (std::size_t i = 0; i < n; ++i) {
        double step = 0.0;
        for (const auto& profile : profiles)
            step += (profile[(i + 1) % n] - profile[i]).norm();
        u_[i + 1] = u_[i] + step / static_cast<double>(m);
    }
    v_.assign(m, 0.0);
    for (std::size_t k = 1; k < m; ++k) {
        double step = 0.0;
        for (std::size_t i = 0; i < n; ++i)
            step += (profiles[k][i] - profiles[k - 1][i]).norm();
        v_[k] = v_[k - 1] + step / static_cast<double>(n);
    }
    // Where the loft narrows v runs slower than a millimetre: half as much again makes sure of the reach.
    v_breaks_ = v_;
    v_breaks_.insert(v_breaks_.begin(), v_.front() - 1.5 * beyond_mm);
    v_breaks_.push_back(v_.back() + 1.5 * beyond_mm);

    nodes_.resize(n * m);
    for (std::size_t k = 0; k < m; ++k) {
        const Points along = periodic_moments(u_, profiles[k]);
        for (std::size_t i = 0; i < n; ++i) {
            nodes_[k * n + i].p = profiles[k][i];
            nodes_[k * n + i].uu = along[i];
        }
    }
    Points column(m), bent(m);
    for (std::size_t i = 0; i < n; ++i) {
        for (std::size_t k = 0; k < m; ++k) {
            column[k] = nodes_[k * n + i].p;
            bent[k] = nodes_[k * n + i].uu;
        }
        const Points across = natural_moments(v_, column), mixed = natural_moments(v_, bent);
        for (std::size_t k = 0; k < m; ++k) {
            nodes_[k * n + i].vv = across[k];
            nodes_[k * n + i].uuvv = mixed[k];
        }
    }
}

/// The four nodes around a place and the weights of what they hold.
struct LoftPatch::Place {
    std::array<const Node*, 4> node;  // (u low, v low), (u high, v low), (u low, v high), (u high, v high)
    SplineBasis along, across;

    Eigen::Vector3d sum(const std::array<double, 4>& a, const std::array<double, 4>& b) const {
        Eigen::Vector3d total = Eigen::Vector3d::Zero();
        for (std::size_t c = 0; c < 4; ++c) {
            const Node& n = *node[c];
            const std::size_t i = c % 2, k = c / 2;
            total += b[k] * (a[i] * n.p + a[i + 2] * n.uu) + b[k + 2] * (a[i] * n.vv + a[i + 2] * n.uuvv);
        }
        return total;
    }
};

LoftPatch::Place LoftPatch::locate(double u, double v) const {
    const std::size_t n = u_.size() - 1;
    const double within = u - std::floor(u / u_.back()) * u_.back();
    const std::size_t i = spline_interval(u_, within), k = spline_interval(v_, v);
    const std::size_t next = (i + 1) % n;
    Place place{{&nodes_[k * n + i], &nodes_[k * n + next], &nodes_[(k + 1) * n + i], &nodes_[(k + 1) * n + next]},
                spline_basis(u_[i], u_[i + 1], within),
                {}};
    const double inside = std::clamp(v, v_.front(), v_.back());
    place.across = spline_basis(v_[k], v_[k + 1], inside);
    if (v != inside) {  // a natural spline has no bend at its end: going on straight keeps it C2
        for (std::size_t w = 0; w < 4; ++w) {
            place.across.f[w] += (v - inside) * place.across.d[w];
            place.across.dd[w] = 0.0;
        }
    }
    return place;
}

Eigen::Vector3d LoftPatch::point(double u, double v) const {
    const Place place = locate(u, v);
    return place.sum(place.along.f, place.across.f);
}

PatchPoint LoftPatch::at(double u, double v) const {
    const Place place = locate(u, v);
    const auto &a = place.along, &b = place.across;
    return {place.sum(a.f, b.f),  place.sum(a.d, b.f), place.sum(a.f, b.d),
            place.sum(a.dd, b.f), place.sum(a.d, b.d), place.sum(a.f, b.dd)};
}

}  // namespace cmm::sim
