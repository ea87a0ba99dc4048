// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "cad/spline_body.hpp"
#include "cad/step_part.hpp"

namespace cmm::cad {
namespace {

void expect_named(const core::Error& error, const std::string& file) {
    EXPECT_EQ(error.code, core::ErrorCode::config_invalid);
    for (const std::string& said :
         {file, std::string("built without Open CASCADE"), std::string("libocct-data-exchange-dev")})
        EXPECT_NE(error.message.find(said), std::string::npos) << error.message;
}

TEST(WithoutCad, SaysWhatIsMissingAndHowToGetIt) {
    expect_named(read_step("blade.step", "", 2).error(), "blade.step");
    expect_named(write_step({}, {}, "out.step").error(), "out.step");
    expect_named(write_stl({}, 0.01, "out.stl").error(), "out.stl");
}

}  // namespace
}  // namespace cmm::cad
