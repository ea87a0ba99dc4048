// SPDX-License-Identifier: Apache-2.0
#include "fitting/surface_patch.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "fitting/cyclic.hpp"

namespace cmm::fitting {
namespace {

constexpr double unbounded = std::numeric_limits<double>::infinity();
// A cosine above which a corner of the parallelogram is not worth its rounding errors.
constexpr double steepest_wedge = 0.99;

/// Bernstein coefficients of a span's four functions on [w0, w1]: their polar forms at w0 and w1 (Ramshaw 1989).
std::array<std::array<double, 4>, 4> bernstein_of(const CubicBasis& basis, double w0, double w1) {
    std::array<std::array<double, 4>, 4> b;
    for (std::size_t k = 0; k < 4; ++k) {
        const double x = k > 2 ? w1 : w0, y = k > 1 ? w1 : w0, z = k > 0 ? w1 : w0;
        for (std::size_t a = 0; a < 4; ++a)
            b[k][a] = basis.power[0][a] + basis.power[1][a] * (x + y + z) / 3.0 +
                      basis.power[2][a] * (x * y + y * z + z * x) / 3.0 + basis.power[3][a] * x * y * z;
    }
    return b;
}

template <int N>
using Columns = Eigen::Matrix<double, 3, N>;

/// Of |V|^2 over the hull, by its least extent along the mean.
template <int N>
double least_square(const Columns<N>& vectors) {
    const Vec3 along = vectors.rowwise().mean().normalized();
    const double least = (along.transpose() * vectors).minCoeff();
    return least > 0.0 ? least * least : 0.0;
}

}  // namespace

SurfacePlace PatchDomain::clamped(const SurfacePlace& at) const {
    return {std::clamp(at.u, u0, u1), std::clamp(at.v, v0, v1)};
}

PatchBounds::PatchBounds(const Surface& surface, const PatchDomain& domain) : domain_(domain) {
    const auto part = [](const CubicAxis& axis, std::size_t span, double from, double to) {
        const double low = axis.low(span), width = axis.high(span) - low;
        return bernstein_of(axis.basis(span), (from - low) / width, (to - low) / width);
    };
    const auto bu = part(surface.u(), domain.span_u, domain.u0, domain.u1);
    const auto bv = part(surface.v(), domain.span_v, domain.v0, domain.v1);
    const std::size_t i = surface.u().first(domain.span_u), j = surface.v().first(domain.span_v);
    const std::size_t n = surface.u().controls();
    Grid points;
    for (std::size_t k = 0; k < 4; ++k)
        for (std::size_t l = 0; l < 4; ++l)
            points[k][l].setZero();
    for (std::size_t b = 0; b < 4; ++b) {
        std::array<Vec3, 4> row;
        for (std::size_t k = 0; k < 4; ++k) {
            row[k].setZero();
            for (std::size_t a = 0; a < 4; ++a)
                row[k] += bu[k][a] * surface.control(cyclic(i + a, n), j + b);
        }
        for (std::size_t k = 0; k < 4; ++k)
            for (std::size_t l = 0; l < 4; ++l)
                points[k][l] += bv[l][b] * row[k];
    }
    bound_shape(points);
    bound_bending(points);
}

void PatchBounds::bound_shape(const Grid& p) {
    low_.setConstant(unbounded);
    high_ = -low_;
    for (const auto& column : p)
        for (const Vec3& point : column) {
            low_ = low_.cwiseMin(point);
            high_ = high_.cwiseMax(point);
        }
    centre_ = 0.25 * (p[0][0] + p[3][0] + p[0][3] + p[3][3]);
    const Vec3 a = 0.25 * (p[3][0] + p[3][3] - p[0][0] - p[0][3]), b = 0.25 * (p[0][3] + p[3][3] - p[0][0] - p[3][0]);
    for (std::size_t k = 0; k < 4; ++k)
        for (std::size_t l = 0; l < 4; ++l) {
            const double s = static_cast<double>(k) / 1.5 - 1.0, t = static_cast<double>(l) / 1.5 - 1.0;
            deviation_ = std::max(deviation_, (p[k][l] - (centre_ + s * a + t * b)).norm());
        }
    normal_ = a.cross(b).normalized();
    across_a_ = b.cross(normal_).normalized();
    across_b_ = normal_.cross(a).normalized();
    half_a_ = std::abs(a.dot(across_a_));
    half_b_ = std::abs(b.dot(across_b_));
    reach_ = std::max((a + b).norm(), (a - b).norm());
    cosine_ = across_a_.dot(across_b_);
    if (std::abs(cosine_) < steepest_wedge) wedge_ = 1.0 / (1.0 - cosine_ * cosine_);
}

/// (S - p) . S_xx + |S_x|^2 >= constant + (centre - p) . mean - |centre - p| radius; likewise the others.
void PatchBounds::bound_bending(const Grid& p) {
    Columns<12> du, dv;
    Columns<8> duu, dvv;
    Columns<9> duv;
    Eigen::Matrix<double, 16, 3> from_centre;
    for (std::size_t k = 0; k < 4; ++k)
        for (std::size_t l = 0; l < 4; ++l) {
            const auto at = [](std::size_t index) { return static_cast<Eigen::Index>(index); };
            from_centre.row(at(4 * k + l)) = p[k][l] - centre_;
            if (k < 3) du.col(at(4 * k + l)) = 3.0 * (p[k + 1][l] - p[k][l]);
            if (l < 3) dv.col(at(4 * l + k)) = 3.0 * (p[k][l + 1] - p[k][l]);
            if (k < 2) duu.col(at(4 * k + l)) = 6.0 * (p[k + 2][l] - 2.0 * p[k + 1][l] + p[k][l]);
            if (l < 2) dvv.col(at(4 * l + k)) = 6.0 * (p[k][l + 2] - 2.0 * p[k][l + 1] + p[k][l]);
            if (k < 3 && l < 3) duv.col(at(3 * k + l)) = 9.0 * (p[k + 1][l + 1] - p[k][l + 1] - p[k + 1][l] + p[k][l]);
        }
    // Products with all of the hull at once, in vector lanes.
    const auto moments = [&]<int N>(const Columns<N>& vectors) -> Eigen::Matrix<double, 16, N> {
        return from_centre.lazyProduct(vectors);
    };
    const auto bending = []<int N>(const Columns<N>& vectors, double constant) {
        const Vec3 mean = vectors.rowwise().mean();
        return Bending{mean, (vectors.colwise() - mean).colwise().norm().maxCoeff(), constant};
    };
    const Eigen::Matrix<double, 12, 3> along_du = du.transpose();
    const Eigen::Matrix<double, 12, 12> mixed = along_du.lazyProduct(dv);
    uu_ = bending(duu, least_square(du) + moments(duu).minCoeff());
    uv_ = bending(duv, mixed.cwiseAbs().maxCoeff() + moments(duv).cwiseAbs().maxCoeff());
    vv_ = bending(dvv, least_square(dv) + moments(dvv).minCoeff());
    const double along_u = std::max(du.rowwise().mean().norm(), 1e-300);
    const double along_v = std::max(dv.rowwise().mean().norm(), 1e-300);
    const double twist = uv_.mean.norm() + uv_.radius;
    turn_u_ = std::max((uu_.mean.norm() + uu_.radius) / along_u, twist / along_v);
    turn_v_ = std::max((vv_.mean.norm() + vv_.radius) / along_v, twist / along_u);
}

double PatchBounds::square_to_parallelogram(const Vec3& q) const {
    const double off = q.dot(normal_), a = q.dot(across_a_), b = q.dot(across_b_);
    const double past_a = std::max(std::abs(a) - half_a_, 0.0), past_b = std::max(std::abs(b) - half_b_, 0.0);
    // Beyond a corner: the distance to a wedge whose sides have normals with this cosine.
    const double cosine = a * b > 0.0 ? cosine_ : -cosine_;
    const double past = std::max(past_a, past_b);
    const bool beyond = (past_a > cosine * past_b) & (past_b > cosine * past_a) & (wedge_ > 0.0);
    const double corner = (past_a * past_a + past_b * past_b - 2.0 * cosine * past_a * past_b) * wedge_;
    return off * off + (beyond ? corner : past * past);
}

double PatchBounds::least_distance(const Vec3& p) const {
    const Vec3 q = p - centre_;
    // The sphere round it is the better bound of a thin rhombus.
    return std::max(std::sqrt(square_to_parallelogram(q)), q.norm() - reach_) - deviation_;
}

bool PatchBounds::nearer_than(double limit, const Vec3& p) const {
    const Vec3 q = p - centre_;
    const double near = limit + deviation_, round = near + reach_;
    return (near > 0.0) & (square_to_parallelogram(q) < near * near) & (q.squaredNorm() < round * round);
}

bool PatchBounds::convex_for(const Vec3& p) const {
    const Vec3 q = centre_ - p;
    const double away = q.norm();
    const double uu = uu_.constant + q.dot(uu_.mean) - away * uu_.radius;
    const double vv = vv_.constant + q.dot(vv_.mean) - away * vv_.radius;
    const double uv = uv_.constant + std::abs(q.dot(uv_.mean)) + away * uv_.radius;
    return uu > 0.0 && vv > 0.0 && uu * vv > uv * uv;
}

void PatchGroup::set(std::size_t lane, const PatchBounds& patch) {
    const auto k = static_cast<Eigen::Index>(lane);
    const auto put = [k](Vectors& to, const Vec3& from) {
        to.x[k] = static_cast<float>(from.x());
        to.y[k] = static_cast<float>(from.y());
        to.z[k] = static_cast<float>(from.z());
    };
    put(centre_, patch.centre_);
    put(normal_, patch.normal_);
    put(across_a_, patch.across_a_);
    put(across_b_, patch.across_b_);
    half_a_[k] = static_cast<float>(patch.half_a_);
    half_b_[k] = static_cast<float>(patch.half_b_);
    deviation_[k] = static_cast<float>(patch.deviation_);
}

PatchGroup::Lanes PatchGroup::least_distances(const std::array<float, 3>& p) const {
    const Lanes x = p[0] - centre_.x, y = p[1] - centre_.y, z = p[2] - centre_.z;
    const auto along = [&](const Vectors& v) -> Lanes { return x * v.x + y * v.y + z * v.z; };
    const Lanes off = along(normal_), past_a = along(across_a_).abs() - half_a_,
                past = (along(across_b_).abs() - half_b_).max(past_a).max(0.0F);
    return (off * off + past * past).sqrt() - deviation_;
}

}  // namespace cmm::fitting
