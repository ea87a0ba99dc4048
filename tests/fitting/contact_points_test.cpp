// SPDX-License-Identifier: Apache-2.0
/// The classic methods of compensation against analytic truth, and the errors that they are known for.
#include "fitting/contact_points.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "core/rng.hpp"
#include "fitting/contact_section.hpp"
#include "fitting/offset.hpp"
#include "support/compared_methods.hpp"

namespace cmm::fitting {
namespace {

using Method = CompensationMethod;
constexpr double ball = 1.0;
constexpr double pi = std::numbers::pi;
constexpr std::array point_methods{Method::micro_plane, Method::mean_vector, Method::two_pass, Method::three_points,
                                   Method::point_distance};
constexpr std::array surface_methods{Method::micro_plane, Method::mean_vector, Method::two_pass};

/// Circles of ball centres about the z axis, unevenly spaced: radius as a function of z.
struct Circles {
    std::vector<double> heights;
    std::vector<std::vector<Vec2>> points;
    std::vector<CentreRow> rows;
    template <class Radius>
    Circles(std::initializer_list<double> z, std::size_t count, Radius&& radius, double jitter = 0.3) : heights(z) {
        core::Rng rng = core::Rng::keyed(7, 0xC0117AC7, count);
        for (const double height : heights) {
            points.emplace_back();
            for (std::size_t i = 0; i < count; ++i) {
                const double at = (double(i) + jitter * (rng.uniform() - 0.5)) * 2.0 * pi / double(count);
                points.back().emplace_back(radius(height) * Vec2(std::cos(at), std::sin(at)));
            }
        }
        for (std::size_t k = 0; k < heights.size(); ++k)
            rows.push_back({heights[k], points[k], 0.0});
    }
};

double radius_of(const Contact& c) {
    return c.position_mm.head<2>().norm();
}

NominalNormal cone_normal(double lean) {
    return [lean](const Vec2& centre, const Vec2&) {
        Vec3 n;
        n << std::cos(lean) * centre.normalized(), std::sin(lean);
        return n;
    };
}

TEST(ContactPoints, AnUprightCylinder) {
    const Circles circles({0, 3, 6}, 200, [](double) { return 11.0; });
    for (const Method method : point_methods) {
        const auto contacts = contacts_by(method, circles.rows, 1, ball, cone_normal(0.0));
        ASSERT_TRUE(contacts) << to_string(method);
        ASSERT_EQ(contacts->size(), 200U);
        for (const Contact& c : *contacts) {
            // Uneven chords turn the mean of two normals, not the circle's: r d^2/2 for d of some milliradians.
            EXPECT_NEAR(radius_of(c), 10.0, method == Method::three_points ? 1e-12 : 2e-4) << to_string(method);
            EXPECT_NEAR(c.position_mm.z(), 3.0, 1e-3) << to_string(method);
            EXPECT_GT(c.normal.dot(c.position_mm - Vec3(0, 0, 3)), 0.0) << "outward";
            EXPECT_NEAR(c.lean_rad, 0.0, 1e-3);
        }
    }
}

/// What lives in the plane is off by r (1/cos a - 1) there; what sees the sections beside is not.
TEST(ContactPoints, ACone) {
    for (const double lean : {0.1, 0.3, 0.5}) {
        // The part: radius 20 + z tan(lean) falls upwards, so the normal leans up.
        const auto centre_radius = [&](double z) { return 20.0 - z * std::tan(lean) + ball / std::cos(lean); };
        const Circles circles({0, 1, 2}, 400, centre_radius, 0.0);
        const double in_plane = ball * (1.0 / std::cos(lean) - 1.0), at_z = 20.0 - std::tan(lean);
        EXPECT_NEAR(lean_error(ball, lean).in_plane_mm, in_plane, 1e-15);
        const auto flat = contacts_by(Method::three_points, circles.rows, 1, ball);
        ASSERT_TRUE(flat);
        for (const Contact& c : *flat) {
            EXPECT_NEAR(radius_of(c) - at_z, in_plane, 1e-12);
            EXPECT_EQ(c.position_mm.z(), 1.0);
            EXPECT_EQ(c.normal.z(), 0.0);
        }
        for (const Method method :
             {Method::micro_plane, Method::mean_vector, Method::two_pass, Method::point_distance}) {
            const auto contacts = contacts_by(method, circles.rows, 1, ball, cone_normal(lean));
            ASSERT_TRUE(contacts) << to_string(method);
            const auto slid = slid_into_plane(*contacts, 1.0);
            for (std::size_t i = 0; i < slid.size(); ++i) {
                const Contact& c = (*contacts)[i];
                EXPECT_NEAR(c.lean_rad, lean, 1e-3) << to_string(method);
                EXPECT_NEAR(c.position_mm.z(), 1.0 - ball * std::sin(lean), 1e-3);
                const double off = (radius_of(c) - (20.0 - c.position_mm.z() * std::tan(lean))) * std::cos(lean);
                EXPECT_NEAR(off, 0.0, 1e-6) << to_string(method) << ": along the normal";
                EXPECT_NEAR(slid[i].norm(), at_z, 5e-4) << to_string(method);
            }
        }
    }
}

/// The bend across the sections: none of it in the middle of three even ones, kappa h/2 of the normal at the last.
TEST(ContactPoints, ASphere) {
    constexpr double part = 30.0, z = 12.0, h = 1.5;
    const auto centre_radius = [](double at) { return std::sqrt((part + ball) * (part + ball) - at * at); };
    const Circles circles({z - 2 * h, z - h, z}, 600, centre_radius, 0.0);
    for (const Method method : surface_methods) {
        const auto inner = contacts_by(method, circles.rows, 1, ball),
                   last = contacts_by(method, circles.rows, 2, ball);
        ASSERT_TRUE(inner && last) << to_string(method);
        for (std::size_t i = 0; i < inner->size(); ++i) {
            const Contact &c = (*inner)[i], &end = (*last)[i];
            EXPECT_NEAR(c.position_mm.norm(), part, 2e-6) << to_string(method);
            EXPECT_NEAR(end.lean_rad, std::asin(z / (part + ball)) - 0.5 * h / (part + ball) / std::cos(end.lean_rad),
                        0.2 * h / part)
                << to_string(method) << ": the chord below it";
            EXPECT_GT(end.position_mm.norm() - part, 1e-4) << "r (1 - cos d), always outwards";
            EXPECT_LT(end.position_mm.norm() - part, 1e-3);
            EXPECT_EQ(c.bound_mm, 0.0);
            EXPECT_GT(end.bound_mm, end.position_mm.norm() - part) << "one row alone does not tell the bend";
        }
    }
}

/// The noise of the normal is that which the contact's uncertainty takes for granted, and the contact's own is covered.
TEST(ContactPoints, NoiseIsWithinTheUncertainty) {
    constexpr double sigma = 2e-3;
    const auto centre_radius = [](double z) { return 15.0 - 0.2 * z; };
    const double lean = std::atan(0.2);
    Circles circles({0, 2, 4}, 400, centre_radius, 0.0);
    core::Rng rng = core::Rng::keyed(3, 0x5165, 1);
    for (std::size_t k = 0; k < 3; ++k) {
        for (Vec2& p : circles.points[k])
            p += sigma * rng.normal() / std::cos(lean) * p.normalized();
        circles.rows[k] = {circles.heights[k], circles.points[k], sigma};
    }
    const double part = 15.0 - ball / std::cos(lean);  // at z = 0
    for (const Method method : surface_methods) {
        const auto contacts = contacts_by(method, circles.rows, 1, ball);
        ASSERT_TRUE(contacts);
        std::size_t held = 0;
        for (const Contact& c : *contacts) {
            const double off = (radius_of(c) - (part - 0.2 * c.position_mm.z())) * std::cos(lean);
            held += std::abs(off) <= c.u95_mm ? 1U : 0U;
            EXPECT_GT(c.u95_mm, 2.0 * sigma);
            EXPECT_LT(c.u95_mm, 2.2 * sigma);
        }
        EXPECT_NEAR(double(held) / double(contacts->size()), 0.955, 0.035) << to_string(method);
    }
}

/// Three families of twisted blades: the contour goes through the contacts, and each method is as good as it is known
/// to be. The classic ones that see the lean beat the plane on sides; at thin edges none does what the surface does.
TEST(ContactPoints, TwistedBlades) {
    const auto rms_um = [](const std::vector<double>& errors) {
        double squares = 0.0;
        for (const double e : errors)
            squares += e * e;
        return 1e3 * std::sqrt(squares / double(errors.size()));
    };
    for (const auto family : families::all_families) {
        const families::ComparedBlade blade(family, 1, 9, false);
        const auto errors = [&](Method method) { return blade.errors(method, 20); };
        const auto flat = errors(Method::flat), surface = errors(Method::surface), plane = errors(Method::three_points);
        EXPECT_EQ(plane.refused, 0U);
        EXPECT_NEAR(rms_um(plane.sides), rms_um(flat.sides), 0.1) << blade.name() << ": the same in the plane";
        for (const Method method : surface_methods) {
            const auto own = errors(method);
            EXPECT_EQ(own.refused, 0U) << blade.name() << " " << to_string(method);
            EXPECT_LT(rms_um(own.sides), rms_um(flat.sides)) << blade.name() << " " << to_string(method);
            EXPECT_GT(rms_um(own.sides), rms_um(surface.sides)) << blade.name() << " " << to_string(method);
        }
    }
}

TEST(ContactPoints, TheSectionKeepsWhatWasMeasured) {
    const families::ComparedBlade blade(families::Family::turbine, 2, 5, true);
    const auto flat = blade.section(Method::flat, 2), own = blade.section(Method::mean_vector, 2),
               plane = blade.section(Method::three_points, 2);
    ASSERT_TRUE(flat && own && plane);
    EXPECT_EQ(own->verdicts.size(), flat->verdicts.size());
    EXPECT_EQ(own->rejected, flat->rejected);
    EXPECT_EQ(own->centres.points, flat->centres.points);
    ASSERT_EQ(own->contour.size(), flat->contour.size());
    for (std::size_t i = 0; i < own->contour.size(); i += 50) {
        EXPECT_TRUE(own->contour[i].lean_rad) << "its normals lean";
        EXPECT_FALSE(plane->contour[i].lean_rad) << "unknown in the plane: the nominal's offset error is added later";
        EXPECT_GT(own->contour[i].u95_mm, 0.0);
    }
}

TEST(ContactPoints, WhatIsMissingHasAName) {
    const Circles circles({0, 3, 6}, 50, [](double) { return 11.0; });
    const std::span<const CentreRow> rows(circles.rows);
    for (const Method method : surface_methods) {
        const auto alone = contacts_by(method, rows.first(1), 0, ball);
        ASSERT_FALSE(alone);
        EXPECT_EQ(alone.error().code, core::ErrorCode::fit_not_evaluable);
        EXPECT_NE(alone.error().message.find("no other section"), std::string::npos);
    }
    EXPECT_TRUE(contacts_by(Method::three_points, rows.first(1), 0, ball));
    EXPECT_TRUE(contacts_by(Method::point_distance, rows.first(1), 0, ball, cone_normal(0.0)));
    EXPECT_NE(contacts_by(Method::point_distance, rows, 0, ball).error().message.find("needs a nominal"),
              std::string::npos);
    EXPECT_FALSE(contacts_by(Method::surface, rows, 0, ball));
    EXPECT_FALSE(contacts_by(Method::flat, rows, 0, ball));
    for (const Method method : point_methods) {
        EXPECT_FALSE(contacts_by(method, rows, 3, ball, cone_normal(0.0))) << "no such row";
        EXPECT_FALSE(contacts_by(method, rows, 1, 0.0, cone_normal(0.0)));
        EXPECT_FALSE(contacts_by(method, rows, 1, std::nan(""), cone_normal(0.0)));
    }
    std::vector<CentreRow> few(rows.begin(), rows.end());
    few[1].centres = few[1].centres.first(5);
    EXPECT_FALSE(contacts_by(Method::three_points, few, 0, ball));
    std::vector<CentreRow> same(rows.begin(), rows.end());
    same[1].z_mm = same[0].z_mm;
    EXPECT_FALSE(contacts_by(Method::mean_vector, same, 0, ball)) << "not above the one below";
}

TEST(ContactPoints, NamesGoThereAndBack) {
    for (const auto name : compensation_method_names())
        EXPECT_EQ(to_string(compensation_method_from(name).value()), name);
    EXPECT_EQ(compensation_method_names().size(), 7U);
    EXPECT_FALSE(compensation_method_from("3D"));
    EXPECT_FALSE(compensation_method_from(""));
}

}  // namespace
}  // namespace cmm::fitting
