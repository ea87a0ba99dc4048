// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "acquisition/contour_sampling.hpp"
#include "acquisition/nominal_kinds.hpp"

namespace cmm::acquisition {
namespace {

using Eigen::Vector2d;

constexpr std::size_t coarse_per_piece = 400;
constexpr std::size_t slope_checks = 200;

double mix(double a, double b, double s) {
    return a + (b - a) * s;
}

/// The section in one plane; names as in docs/part-file.md, "The parametric blade".
class BladeSection {
  public:
    BladeSection(const ParametricBlade& blade, double z_mm) {
        const double s = (z_mm - blade.z_root_mm) / (blade.z_tip_mm - blade.z_root_mm);
        const double chord = mix(blade.chord_root_mm, blade.chord_tip_mm, s);
        const double scale = chord / blade.chord_root_mm;
        r1_ = blade.le_radius_mm * scale;
        r2_ = blade.te_radius_mm * scale;
        h_ = 0.5 * (mix(blade.thickness_root_mm, blade.thickness_tip_mm, s) - r1_ - r2_);
        th_ = blade.camber_rad;
        k_ = chord - r1_ - r2_;
        const double rise = z_mm - blade.z_root_mm;
        turn_ = Eigen::Rotation2Dd(mix(blade.stagger_root_rad, blade.stagger_tip_rad, s));
        shift_ = {rise * std::tan(blade.lean_x_rad), rise * std::tan(blade.lean_y_rad)};
    }

    /// One lap, counter-clockwise: [0, 1] suction side from TE to LE, [1, 2] LE arc, [2, 3] pressure side, [3, 4] TE
    /// arc.
    Vector2d at(double u) const {
        constexpr double pi = std::numbers::pi;
        const auto piece = static_cast<int>(std::floor(u)) % 4;
        const double w = u - std::floor(u);
        if (piece == 0) return from_camber(1.0 - w, side_angle(1.0 - w));
        if (piece == 1) return from_camber(0.0, mix(side_angle(0.0), 2.0 * pi - side_angle(0.0), w));
        if (piece == 2) return from_camber(w, -side_angle(w));
        return from_camber(1.0, mix(-side_angle(1.0), side_angle(1.0), w));
    }

    /// The envelope of the circles exists where the radius changes more slowly than the camber line advances.
    bool valid() const {
        if (k_ <= 0.0 || r1_ <= 0.0 || r2_ <= 0.0) return false;
        for (std::size_t i = 0; i <= slope_checks; ++i) {
            const double t = static_cast<double>(i) / static_cast<double>(slope_checks);
            if (std::abs(slope(t)) >= 1.0 || radius(t) <= 0.0) return false;
        }
        return true;
    }

  private:
    double radius(double t) const {
        const double f = 2.0 * t * (1.0 - t) + 27.0 / 8.0 * t * (1.0 - t) * (1.0 - t);
        return r1_ * (1.0 - t) + r2_ * t + h_ * f;
    }
    /// q = rho'(t) / L.
    double slope(double t) const {
        const double df = 2.0 - 4.0 * t + 27.0 / 8.0 * ((1.0 - t) * (1.0 - t) - 2.0 * t * (1.0 - t));
        return (r2_ - r1_ + h_ * df) / camber_length();
    }
    bool straight() const { return std::abs(th_) < 1e-9; }
    double camber_length() const { return straight() ? k_ : k_ * 0.5 * th_ / std::sin(0.5 * th_); }
    /// Angle from the camber tangent to the contact point of the suction side: (-q, sqrt(1 - q^2)).
    double side_angle(double t) const { return std::acos(-slope(t)); }

    /// The point of the circle about the camber point at the angle from the camber tangent, in the part frame.
    Vector2d from_camber(double t, double angle) const {
        const double a = (t - 0.5) * th_;
        Vector2d middle((t - 0.5) * k_, 0.0);
        if (!straight()) {
            const double big = 0.5 * k_ / std::sin(0.5 * th_);
            middle = {big * std::sin(a), big * (std::cos(a) - std::cos(0.5 * th_))};
        }
        const Vector2d tangent(std::cos(a), -std::sin(a)), normal(std::sin(a), std::cos(a));
        return turn_ * (middle + radius(t) * (std::cos(angle) * tangent + std::sin(angle) * normal)) + shift_;
    }

    double r1_, r2_, h_, th_, k_;
    Eigen::Rotation2Dd turn_{0.0};
    Vector2d shift_ = Vector2d::Zero();
};

class ParametricNominal final : public Nominal {
  public:
    explicit ParametricNominal(const ParametricBlade& blade) : blade_(blade) {}

    core::Result<NominalContour> cut(double z_mm) const override {
        if (auto status = require_height(z_mm, z_low_mm(), z_high_mm()); !status) return tl::unexpected(status.error());
        const BladeSection section(blade_, z_mm);
        std::vector<double> coarse(4 * coarse_per_piece);
        for (std::size_t i = 0; i < coarse.size(); ++i)
            coarse[i] = static_cast<double>(i) / coarse_per_piece;
        const auto parameters = dense_parameters([&](double u) { return section.at(u); }, coarse, 4.0);
        // Points of equal parameter above and below give the spanwise direction; the formulas are smooth in z.
        constexpr double dz_mm = 1e-3;
        const BladeSection above(blade_, z_mm + dz_mm), below(blade_, z_mm - dz_mm);
        std::vector<CutPoint> cut;
        cut.reserve(parameters.size());
        for (const double u : parameters) {
            const Vector2d drift = above.at(u) - below.at(u);
            cut.push_back({section.at(u), {drift.x(), drift.y(), 2.0 * dz_mm}});
        }
        return contour_from(z_mm, cut);
    }
    double z_low_mm() const override { return blade_.z_root_mm; }
    double z_high_mm() const override { return blade_.z_tip_mm; }

  private:
    ParametricBlade blade_;
};

}  // namespace

core::Result<std::shared_ptr<const Nominal>> parametric_nominal(const ParametricBlade& blade) {
    for (const double z : {blade.z_root_mm, blade.z_tip_mm}) {
        if (BladeSection(blade, z).valid()) continue;
        return core::fail(core::ErrorCode::config_invalid,
                          "nominal.blade: chord, thickness and edge radii make no section at z = " + std::to_string(z) +
                              " mm (the thickness grows faster than the chord allows)");
    }
    return std::make_shared<const ParametricNominal>(blade);
}

}  // namespace cmm::acquisition
