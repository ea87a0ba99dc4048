// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "acquisition/section_result.hpp"

namespace cmm::acquisition {

/// How a limit is held against a value that has an uncertainty. g: the guard band.
enum class DecisionMethod : std::uint8_t {
    iso_14253_1,  ///< accept when value + g <= limit, reject when value - g > limit, otherwise undecided
    simple,       ///< ASME B89.7.3.1, simple acceptance and rejection: g = 0
    stringent,    ///< ASME B89.7.3.1, stringent acceptance, relaxed rejection: accept as ISO 14253-1, otherwise reject
    relaxed,      ///< ASME B89.7.3.1, relaxed acceptance, stringent rejection: reject as ISO 14253-1, otherwise accept
};
std::string_view to_string(DecisionMethod method) noexcept;
std::optional<DecisionMethod> decision_method_from(std::string_view name);

/// What has to lie between a value and its limit before it is said to be inside, and before it is said to be outside.
struct GuardBands {
    double accept = 0.0, reject = 0.0;
};

/// A rule with the risk that it takes: of accepting a characteristic that is just outside its limit, and of rejecting
/// one that is just inside. Where a characteristic may be judged several times, each time with more points, the risk is
/// divided equally over all the times, so that together they stay below it whatever the values have in common
/// (Bonferroni). A value.
struct DecisionRule {
    DecisionMethod method = DecisionMethod::iso_14253_1;
    double risk = 0.05;     ///< one-sided, over all looks
    std::size_t looks = 1;  ///< at a characteristic, at most

    double risk_of_look() const { return risk / static_cast<double>(looks); }
    /// Standard normal deviate that is exceeded with the risk of a look.
    double deviate() const;
    /// Of a number with a symmetric 95 % interval.
    GuardBands guards(double u95) const;
    /// None: open on that side. Without limits: reported.
    Decision decide(double value, const GuardBands& guard, std::optional<double> lower,
                    std::optional<double> upper) const;
    /// The rule in a sentence, for results and reports.
    std::string worded() const;
};

}  // namespace cmm::acquisition
