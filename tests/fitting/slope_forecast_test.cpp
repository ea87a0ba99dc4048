// SPDX-License-Identifier: Apache-2.0
#include "fitting/slope_forecast.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace cmm::fitting {
namespace {

double forecast(const std::vector<double>& heights, double (*value)(double)) {
    const SlopeForecast slope(heights);
    double sum = 0.0;
    for (std::size_t k = 0; k < heights.size(); ++k)
        sum += slope.weight(k) * value(heights[k]);
    return sum;
}

TEST(SlopeForecast, FourOthersForetellACubic) {
    const auto cubic = [](double z) { return 0.7 - 0.2 * z + 0.03 * z * z - 0.004 * z * z * z; };
    EXPECT_NEAR(forecast({-2.0, 1.5, -4.0, 5.0}, cubic), 0.7, 1e-14);
    EXPECT_NEAR(forecast({1.0, 2.0, 4.0, 9.0}, cubic), 0.7, 1e-13);
    EXPECT_NEAR(forecast({-2.0, 1.5}, [](double z) { return 0.7 - 0.2 * z; }), 0.7, 1e-15);
}

TEST(SlopeForecast, IsWorseFromOneSideAndNothingFromOneSection) {
    EXPECT_DOUBLE_EQ(SlopeForecast(std::vector{3.0, -2.0, 6.0}).slope_error(-0.01), 0.005);
    EXPECT_DOUBLE_EQ(SlopeForecast(std::vector{2.0, 4.0, 6.0, 8.0}).slope_error(0.01), 0.01);
    EXPECT_DOUBLE_EQ(SlopeForecast(std::vector{-4.0, -2.0}).slope_error(0.01), 0.01);
    EXPECT_TRUE(std::isinf(SlopeForecast(std::vector{2.0}).slope_error(0.01)));
    EXPECT_TRUE(std::isinf(SlopeForecast({}).slope_error(0.0)));
}

}  // namespace
}  // namespace cmm::fitting
