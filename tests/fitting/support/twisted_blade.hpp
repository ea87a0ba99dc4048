// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <vector>

#include "support/families.hpp"

/// Blades of the three families with height: sections whose sizes, twist and lean change smoothly with z, with exact
/// normals, ball centres and distances. Nothing of cmm::fitting. Millimetres.
namespace cmm::fitting::families {

using Vec3 = Eigen::Vector3d;

/// The surface X(t, z) = sum of l_m(z) B_m(t): outlines B_m at Chebyshev stations, joined by the polynomials l_m; t as
/// in Blade, z in [0, height] and 3 mm beyond. By definition that is the truth, whatever lies between the stations.
class TwistedBlade {
  public:
    TwistedBlade(Family family, std::uint64_t seed);

    struct Jet {
        Vec3 position, dt, dz;
        Vec3 normal() const;  ///< unit, outward
    };
    Jet at(double t, double z) const;
    /// Where a ball whose centre has the height z touches along t; and its centre, moved outwards by `off`.
    struct Touch {
        Vec3 contact, normal, centre;
    };
    Touch touch(double t, double z, double ball_mm, double off_mm = 0.0) const;

    double height() const { return height_; }
    const std::string& name() const { return name_; }
    /// The outline that the family's formulas give at z (equal to X's to some nanometres).
    Blade outline(double z) const;

    /// The section at z: exact signed distances in its plane.
    class Section {
      public:
        Foot closest(const Vec2& p) const;

      private:
        friend class TwistedBlade;
        OutlineJet at(double t) const;
        const TwistedBlade* blade = nullptr;
        std::vector<double> weights;
        std::array<std::vector<Vec2>, 4> samples;
    };
    Section section(double z) const;

  private:
    Shape shape_at(double z) const;
    void weights_at(double z, std::vector<double>& weights, std::vector<double>* slopes) const;

    Family family_;
    Shape root_;
    std::string name_;
    double height_ = 0.0, twist_ = 0.0, taper_ = 0.0, thinning_ = 0.0, lean_ = 0.0, sweep_ = 0.0;
    std::vector<double> stations_, barycentric_;
    std::vector<Blade> outlines_;
};

/// Ball centres of sections at equal heights from `lowest` to `highest`, each as family_scan scans: points in order
/// with noise along the surface normal, bad points, any start.
struct BladeRows {
    std::vector<double> heights;
    std::vector<std::vector<Vec3>> rows;
    std::vector<std::vector<double>> bad;
};
BladeRows scan_rows(const TwistedBlade& blade, std::size_t sections, double lowest, double highest,
                    const ScanOptions& options);

}  // namespace cmm::fitting::families
