// SPDX-License-Identifier: Apache-2.0
#include "fitting/orthogonal_polynomials.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/rng.hpp"
#include "fitting/circle_frame.hpp"

namespace cmm::fitting {
namespace {

constexpr Eigen::Index room = 20;
using Values = Eigen::Array<double, room, 1>;
using Polynomials = OrthogonalPolynomials<Values, 8>;

/// The first so many places count.
Values first_places(Eigen::Index count) {
    Values counts = Values::Zero();
    counts.head(count) = 1.0;
    return counts;
}

TEST(OrthogonalPolynomials, AreOrthogonalOnUnevenPlaces) {
    core::Rng rng(1);
    constexpr Eigen::Index count = 17;
    Values places = Values::Constant(50.0);
    for (Eigen::Index i = 0; i < count; ++i)
        places[i] = 40.0 + static_cast<double>(i) + rng.uniform(-0.4, 0.4);
    Polynomials polynomials;
    polynomials.begin(places, first_places(count));
    while (polynomials.degree() < 8)
        ASSERT_TRUE(polynomials.raise());
    for (std::size_t a = 0; a <= 8; ++a)
        for (std::size_t b = 0; b <= a; ++b) {
            const double product = (polynomials.values_of(a) * polynomials.values_of(b)).sum();
            const double norms = std::sqrt(polynomials.norm_of(a) * polynomials.norm_of(b));
            EXPECT_NEAR(product / norms, a == b ? 1.0 : 0.0, 1e-12) << a << ' ' << b;
        }
    // At the places they were made from, and as polynomials of their degree: the ninth differences vanish.
    for (Eigen::Index i = 0; i < count; ++i)
        polynomials.at(places[i], 8, [&](std::size_t degree, double value) {
            EXPECT_NEAR(value, polynomials.values_of(degree)[i], 1e-12);
        });
    EXPECT_EQ(polynomials.norm_of(0), count);
    EXPECT_EQ(polynomials.values_of(8).tail(room - count).abs().maxCoeff(), 0.0) << "places that count for nothing";
    std::array<double, 10> steps{};
    for (std::size_t k = 0; k < steps.size(); ++k)
        polynomials.at(40.0 + 2.0 * static_cast<double>(k), 8, [&](std::size_t degree, double value) {
            if (degree == 8) steps[k] = value;
        });
    double difference = 0.0, binomial = 1.0;
    for (std::size_t k = 0; k < steps.size(); ++k) {
        difference += (k % 2 == 0 ? 1.0 : -1.0) * binomial * steps[k];
        binomial *= static_cast<double>(9 - k) / static_cast<double>(k + 1);
    }
    EXPECT_NEAR(difference, 0.0, 1e-9);
}

TEST(OrthogonalPolynomials, NoDegreeThatThePlacesDoNotTell) {
    Values places = Values::Constant(2.0);
    places.head(4) << 1.0, 2.0, 2.0, 3.0;  // three different ones
    Polynomials polynomials;
    polynomials.begin(places, first_places(4));
    EXPECT_TRUE(polynomials.raise());
    EXPECT_TRUE(polynomials.raise());
    EXPECT_FALSE(polynomials.raise());
    EXPECT_EQ(polynomials.degree(), 2U);
    polynomials.begin(Values::Constant(5.0), first_places(1));
    EXPECT_FALSE(polynomials.raise());
}

TEST(CircleFrame, BringsManyPointsAsItBringsOne) {
    core::Rng rng(2);
    Values xs, ys;
    for (Eigen::Index i = 0; i < room; ++i) {
        xs[i] = rng.uniform(-1.0, 1.0);
        ys[i] = rng.uniform(-1.0, 1.0);
    }
    for (const double bend : {0.0, 0.3}) {
        const CircleFrame frame({-1.0, bend}, {0.1, 0.0}, {1.0, bend});
        Values u = xs, y = ys;
        frame.bring(u, y);
        for (Eigen::Index i = 0; i < room; ++i) {
            const Vec2 one = frame.local({xs[i], ys[i]});
            EXPECT_EQ(u[i], one.x());
            EXPECT_EQ(y[i], one.y());
        }
    }
}

TEST(CircleFrame, IsStraightAlongACircleOfAnyRadius) {
    for (const double radius : {0.2, 3.0, 1e5}) {
        const double angle = std::min(0.3, 1.0 / radius);
        const auto on = [&](double at, double off) {
            return Vec2((radius + off) * std::sin(at), radius - (radius + off) * std::cos(at));
        };
        const CircleFrame frame(on(-angle, 0.0), on(0.0, 0.0), on(1.2 * angle, 0.0));
        EXPECT_NEAR(std::abs(frame.curvature()), 1.0 / radius, 1e-9);
        for (const double at : {-0.9 * angle, 0.0, 0.4 * angle, 1.1 * angle}) {
            const Vec2 local = frame.local(on(at, 0.0));
            EXPECT_NEAR(local.x(), 2.0 * radius * std::tan(0.5 * at), 1e-7) << radius;
            EXPECT_NEAR(local.y(), 0.0, 1e-7) << radius;
            EXPECT_NEAR(frame.local(on(at, 0.01)).y(), 0.01, 1e-7) << "outside is on the right of the travel";
        }
        EXPECT_FALSE(frame.is_far(2.0 * radius * std::tan(0.5)));
        EXPECT_TRUE(frame.is_far(2.0 * radius * std::tan(0.65)));
    }
}

}  // namespace
}  // namespace cmm::fitting
