// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

/// The closed airfoil that the curve fit is measured with: chord 60 mm, LE circle 0.4 mm, TE circle 0.25 mm, thickness
/// of the NACA 65 kind on a circular-arc camber line. It is the envelope of discs along the camber, so that its
/// parallel curve is the envelope of larger discs: exact. Nothing of cmm::fitting. Millimetres.
namespace cmm::fitting::airfoil {

using Vec2 = Eigen::Vector2d;

class Airfoil {
  public:
    /// The parallel curve at `offset_mm` outwards; 0: the airfoil.
    explicit Airfoil(double offset_mm = 0.0);
    /// The same of another one: the published NACA 65-010 on a camber line, with such edges (naca65.hpp).
    static Airfoil naca_65(double offset_mm = 0.0);

    enum class Spacing {
        even,    ///< by length
        edges,   ///< 12 % of the points on each edge circle, the others by length
        cosine,  ///< 4 % on each edge circle, the others ever closer towards the edges: by the cosine of their number
    };
    /// Points in counter-clockwise order from a random start, noise along the normal.
    std::vector<Vec2> scan(std::size_t count, Spacing spacing, double sigma_mm, std::uint64_t seed) const;

    /// Signed distance, positive outside; `near` is an index to search from and receives the nearest one (begin: 0).
    double distance(const Vec2& p, std::size_t& near) const;

    const std::vector<Vec2>& points() const { return points_; }

  private:
    struct Empty {};
    explicit Airfoil(Empty /*of points*/) {}
    struct Camber {
        Vec2 position, along, across;
    };
    double radius(double s) const;
    double radius_slope(double s) const;
    Camber camber(double s) const;
    void add_side(bool upper);
    void add_edge(double s, double radius, const Vec2& from);
    void add(const Vec2& position, const Vec2& normal, int part);
    void measure_lengths();

    double offset_ = 0.0, square_ = 0.0, cube_ = 0.0;
    std::vector<Vec2> points_, normals_;  // steps below 3 um
    std::vector<int> part_;               // lower side, TE, upper side, LE
    std::vector<double> length_;          // to each point; one more entry
};

}  // namespace cmm::fitting::airfoil
