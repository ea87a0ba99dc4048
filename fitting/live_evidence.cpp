// SPDX-License-Identifier: Apache-2.0
#include "fitting/live_evidence.hpp"

#include <algorithm>
#include <cmath>

namespace cmm::fitting {
namespace {

constexpr double keep_noise = 1.0 - 1.0 / 300.0;  // the noise is one for the section
constexpr double keep_change = 1.0 - 1.0 / 40.0;  // the roughness is local
constexpr double few = 8.0;                       // degrees of freedom below which the changes say nothing
constexpr double longest_evidence_step = 0.5;     // of the logarithm of the roughness
constexpr double least_noise = 4e-10;             // nothing below 0.02 um is resolved
constexpr double least_roughness = 1e-12, most_roughness = 1e4;

}  // namespace

void LiveEvidence::learn_residual(double residual_mm, double leverage) {
    squares_ = keep_noise * squares_ + residual_mm * residual_mm;
    freedom_ = keep_noise * freedom_ + std::clamp(1.0 - leverage, 0.0, 1.0);
    noise_ = std::max(squares_ / freedom_, least_noise);
}

void LiveEvidence::learn_change(double change, double variance, double length_mm) {
    const double expected = roughness_ * std::max(length_mm, 1e-9);
    const double known = std::clamp(1.0 - variance / expected, 0.0, 1.0);
    seen_ = keep_change * seen_ + std::min(change * change / expected, 9.0);
    known_ = keep_change * known_ + known;
    const double step = 0.2 * std::log((seen_ + few) / (known_ + few));
    roughness_ = std::clamp(roughness_ * std::exp(std::clamp(step, -longest_evidence_step, longest_evidence_step)),
                            least_roughness, most_roughness);
}

}  // namespace cmm::fitting
