// SPDX-License-Identifier: Apache-2.0
#include "fitting/over_rows.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <random>

namespace cmm::fitting {
namespace {

constexpr std::size_t rows = 25;
constexpr double noise = 0.01;

double truth(double z) {
    return 3.0 + 0.02 * z - 1e-3 * z * z;
}

struct Told {
    std::vector<double> z;
    std::vector<std::optional<Known>> known;
};

Told noisy_rows(unsigned seed) {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> error(0.0, noise);
    Told told;
    for (std::size_t k = 0; k < rows; ++k) {
        told.z.push_back(2.0 * double(k));
        told.known.push_back(Known{truth(told.z.back()) + error(random), noise});
    }
    return told;
}

double largest_error(const Told& told) {
    const auto smooth = smoothed_over(told.z, told.known).value;
    double largest = 0.0;
    for (std::size_t k = 0; k < rows; ++k)
        largest = std::max(largest, std::abs(smooth[k] - truth(told.z[k])));
    return largest;
}

TEST(OverRows, AreNearerTheTruthThanSingleOnes) {
    for (unsigned seed = 1; seed <= 20; ++seed)
        EXPECT_LT(largest_error(noisy_rows(seed)), 1.5 * noise);
}

TEST(OverRows, SureOnesCountForMore) {
    Told told = noisy_rows(5);
    for (std::size_t k = 0; k < rows; k += 4)
        told.known[k] = Known{truth(told.z[k]), 0.01 * noise};
    EXPECT_LT(largest_error(told), 0.05 * noise);
}

/// At the ends a cubic has 0.7 of the noise of a row, a straight line 0.4.
TEST(OverRows, BendWhereThatIsTold) {
    double squares = 0.0;
    constexpr unsigned seeds = 200;
    for (unsigned seed = 1; seed <= seeds; ++seed) {
        Told told = noisy_rows(seed);
        for (std::size_t k = 0; k < rows; ++k)
            told.known[k]->value += 0.05 * told.z[k] - truth(told.z[k]);
        const auto smooth = told_over(told.z, told.known).value;
        for (const std::size_t end : {std::size_t{0}, rows - 1})
            squares += std::pow(smooth[end] - 0.05 * told.z[end], 2) / (2.0 * seeds);
    }
    EXPECT_LT(std::sqrt(squares), 0.58 * noise);
}

/// A row with a dent beside its joint knows the joint to a micrometre, and in the wrong place.
TEST(OverRows, OneThatIsSureOfAWrongPlaceDoesNotDrawTheOthers) {
    for (unsigned seed = 1; seed <= 20; ++seed)
        for (const std::size_t row : {std::size_t{0}, std::size_t{7}, rows / 2, rows - 1}) {
            Told told = noisy_rows(seed);
            told.known[row]->value += 30.0 * noise;
            told.known[row]->sigma = 0.01 * noise;
            EXPECT_LT(largest_error(told), 3.0 * noise) << "seed " << seed << ", row " << row;
        }
}

/// As the place of an edge does on a blade that turns unevenly: the first and the last rows lie where they do, and not
/// where the cubic through the others goes.
TEST(OverRows, FollowAFormThatIsNoCubic) {
    for (unsigned seed = 1; seed <= 20; ++seed) {
        Told told = noisy_rows(seed);
        std::vector<double> wave;
        for (std::size_t k = 0; k < rows; ++k) {
            wave.push_back(0.3 * std::sin(0.11 * told.z[k] + double(seed)));
            told.known[k]->value += wave[k];
        }
        const auto smooth = smoothed_over(told.z, told.known).value;
        for (std::size_t k = 0; k < rows; ++k)
            EXPECT_NEAR(smooth[k], truth(told.z[k]) + wave[k], 5.0 * noise) << "seed " << seed << ", row " << k;
    }
}

TEST(OverRows, OnesThatKnowNothingHaveWhatTheOthersSay) {
    Told told = noisy_rows(3);
    for (std::size_t k = 0; k < rows; k += 2)
        told.known[k].reset();
    EXPECT_LT(largest_error(told), 2.0 * noise);
}

}  // namespace
}  // namespace cmm::fitting
