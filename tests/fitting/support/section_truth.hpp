// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "support/families.hpp"

/// Characteristics of sections that are known by formulas, by their definitions and brute force; nothing of
/// cmm::fitting's code. Millimetres, radians.
namespace cmm::fitting::section_truth {

using families::OutlineJet;
using families::Vec2;

inline Vec2 left(const Vec2& v) {
    return {-v.y(), v.x()};
}

/// A section as a formula: a closed counter-clockwise outline at(t), t in [0, 4), its whole part being LE, pressure
/// side, TE, suction side; and about where the camber line runs.
struct ExactSection {
    std::string name;
    std::function<OutlineJet(double)> at;
    std::function<Vec2(double)> camber;  ///< w in [0, 1] from nose to tail, to start from
    double le_nose = 0.5, te_nose = 2.5;
};

ExactSection of_family(const families::Blade& blade);

/// Four digits of NACA (Jacobs, Ward, Pinkerton 1933, report 460), thickness across the camber line, the sharp
/// trailing edge replaced by the arc that has the sides' tangents where the half thickness is `te_half_mm`.
ExactSection naca_4_digit(double chord_mm, double thickness_share, double camber_share, double camber_place,
                          double te_half_mm);
/// docs/part-file.md, "The parametric blade", one section: envelope of circles on a circular arc.
ExactSection envelope(double chord, double thickness, double camber_rad, double le_radius, double te_radius);
/// The same, turned and moved.
ExactSection placed(const ExactSection& section, double angle, const Vec2& shift);

class SectionTruth {
  public:
    explicit SectionTruth(ExactSection section);

    /// Support function: the largest p . direction, and where.
    std::pair<double, Vec2> farthest(const Vec2& direction, double from = 0.0, double to = 4.0) const;
    double extent(const Vec2& direction) const;
    struct Caliper {
        double length, angle;
    };
    Caliper caliper() const;
    double largest_distance() const;
    double min_circle() const;
    /// Where the camber line, continued as the method says, leaves the section.
    const Vec2& nose() const { return le_.point; }
    const Vec2& tail() const { return te_.point; }
    double stagger() const;
    double area() const { return area_; }
    const Vec2& centroid() const { return centroid_; }

    struct Circle {
        Vec2 centre = Vec2::Zero();
        double radius = 0.0;
    };
    /// The inscribed circle on the line across the camber guess at w.
    Circle circle(double w) const;
    struct Thickest {
        double diameter, on_chord, on_camber;
        Vec2 centre;
    };
    Thickest thickest() const;
    double edge_thickness(bool le, double distance) const;
    double edge_angle(bool le, double near, double far) const;
    double scale(bool le) const { return le ? le_.scale : te_.scale; }
    /// Signed distance to the outline, positive outside.
    double distance(const Vec2& p) const;
    const ExactSection& section() const { return section_; }

  private:
    struct End {
        Vec2 point = Vec2::Zero(), origin = Vec2::Zero(), axis = Vec2::UnitX();
        double scale = 0.0, first = 0.0, x = 0.0, unit = 1.0;
        Vec2 arc_centre = Vec2::Zero();  // in the frame of the cubic, which lies beside the arc
        double arc_radius = 0.0, arc_side = 1.0;
        Eigen::Vector4d cubic = Eigen::Vector4d::Zero();
        double on_arc(double abscissa) const;
        Vec2 at(double abscissa) const;
    };
    OutlineJet jet(double t) const;
    double nearest(const Vec2& p, double from, double to, double& t) const;
    Circle circle_on(const Vec2& start, const Vec2& across) const;
    double scale_about(double t_nose) const;
    End end_at(bool le) const;
    void continue_line(bool le, End& end) const;
    std::pair<Vec2, Vec2> camber_at(bool le, double distance) const;  // place, direction away from the end

    ExactSection section_;
    struct Block {
        Vec2 middle;
        double radius;
    };
    std::vector<Vec2> samples_;  // at equal steps of t
    std::vector<Block> blocks_;  // of neighbouring samples
    End le_, te_;
    double area_ = 0.0;
    Vec2 centroid_ = Vec2::Zero();
};

}  // namespace cmm::fitting::section_truth
