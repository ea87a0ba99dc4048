// SPDX-License-Identifier: Apache-2.0
#include "acquisition/decision_rule.hpp"

#include <gtest/gtest.h>

#include <array>

#include "acquisition/evaluation.hpp"

namespace cmm::acquisition {
namespace {

constexpr auto open_side = std::nullopt;
constexpr GuardBands guard{0.008, 0.008};

DecisionRule by(DecisionMethod method) {
    DecisionRule rule;
    rule.method = method;
    return rule;
}

TEST(DecisionRule, HasThreeStatesWithAGuardBand) {
    const DecisionRule rule;
    EXPECT_EQ(rule.decide(0.0919, guard, open_side, 0.100), Decision::accept);
    EXPECT_EQ(rule.decide(0.0921, guard, open_side, 0.100), Decision::undecided);
    EXPECT_EQ(rule.decide(0.1079, guard, open_side, 0.100), Decision::undecided);
    EXPECT_EQ(rule.decide(0.1081, guard, open_side, 0.100), Decision::reject);
    EXPECT_EQ(rule.decide(0.100, {}, open_side, 0.100), Decision::accept);
}

TEST(DecisionRule, HasLimitsOnBothSides) {
    const DecisionRule rule;
    EXPECT_EQ(rule.decide(0.0, guard, -0.1, 0.1), Decision::accept);
    EXPECT_EQ(rule.decide(-0.0921, guard, -0.1, 0.1), Decision::undecided);
    EXPECT_EQ(rule.decide(-0.1081, guard, -0.1, 0.1), Decision::reject);
    EXPECT_EQ(rule.decide(5.0, guard, -0.1, open_side), Decision::accept);
    EXPECT_EQ(rule.decide(5.0, guard, open_side, open_side), Decision::reported);
}

TEST(DecisionRule, WhatCountsAsInsideAndAsOutsideMayDiffer) {
    const DecisionRule rule;
    const GuardBands unlike{0.002, 0.010};
    EXPECT_EQ(rule.decide(0.0979, unlike, open_side, 0.100), Decision::accept);
    EXPECT_EQ(rule.decide(0.0981, unlike, open_side, 0.100), Decision::undecided);
    EXPECT_EQ(rule.decide(0.1099, unlike, open_side, 0.100), Decision::undecided);
    EXPECT_EQ(rule.decide(0.1101, unlike, open_side, 0.100), Decision::reject);
}

TEST(DecisionRule, TheOtherMethodsLeaveNothingUndecided) {
    constexpr std::array values{0.0919, 0.0999, 0.1001, 0.1079, 0.1081};
    const auto said = [&](DecisionMethod method) {
        std::string letters;
        for (const double value : values) {
            const auto decision = by(method).decide(value, guard, open_side, 0.100);
            letters += decision == Decision::accept ? 'a' : decision == Decision::reject ? 'r' : '?';
        }
        return letters;
    };
    EXPECT_EQ(said(DecisionMethod::iso_14253_1), "a???r");
    EXPECT_EQ(said(DecisionMethod::simple), "aarrr");
    EXPECT_EQ(said(DecisionMethod::stringent), "arrrr");
    EXPECT_EQ(said(DecisionMethod::relaxed), "aaaar");
}

/// 1.6449 and 2.1280 are the standard normal deviates of 5 % and a third of that (Python: NormalDist().inv_cdf); U95
/// is 1.9600 of them.
TEST(DecisionRule, TheGuardBandGoesWithTheRisk) {
    DecisionRule rule;
    EXPECT_NEAR(rule.guards(0.010).accept, 0.010 * 1.6448536 / 1.9599640, 1e-8);
    EXPECT_EQ(rule.guards(0.010).accept, rule.guards(0.010).reject);
    rule.looks = 3;
    EXPECT_NEAR(rule.guards(0.010).accept, 0.010 * 2.1280452 / 1.9599640, 1e-8);
    rule.risk = 0.15;
    EXPECT_NEAR(rule.guards(0.010).accept, 0.010 * 1.6448536 / 1.9599640, 1e-8);
}

TEST(DecisionRule, ItsNameIsReadAndItsSentenceSaysWhatItDoes) {
    for (const auto method :
         {DecisionMethod::iso_14253_1, DecisionMethod::simple, DecisionMethod::stringent, DecisionMethod::relaxed})
        EXPECT_EQ(decision_method_from(to_string(method)), method);
    EXPECT_FALSE(decision_method_from("perhaps"));
    DecisionRule rule;
    EXPECT_NE(rule.worded().find("ISO 14253-1"), std::string::npos);
    EXPECT_NE(rule.worded().find("g = 0.839 U95 (risk 5 %, one-sided)"), std::string::npos) << rule.worded();
    rule.looks = 4;
    EXPECT_NE(rule.worded().find("1.25 % for each of up to 4 looks"), std::string::npos) << rule.worded();
    EXPECT_NE(by(DecisionMethod::simple).worded().find("no guard band"), std::string::npos);
    EXPECT_NE(by(DecisionMethod::stringent).worded().find("B89.7.3.1, stringent acceptance"), std::string::npos);
}

TEST(Decision, TakesTheGuardsOfTheCharacteristic) {
    Characteristic c;
    c.value = 0.095;
    c.u95 = 0.010;
    c.upper = 0.100;
    decide(c, {});
    EXPECT_EQ(c.decision, Decision::undecided);
    EXPECT_NEAR(c.guard_accept.value(), 0.00839, 1e-5);
    c.guard_accept = 0.004;
    decide(c, {});
    EXPECT_EQ(c.decision, Decision::accept);
    Characteristic without;
    without.u95 = 0.010;
    without.upper = 0.1;
    decide(without, {});
    EXPECT_EQ(without.decision, Decision::reported);
}

}  // namespace
}  // namespace cmm::acquisition
