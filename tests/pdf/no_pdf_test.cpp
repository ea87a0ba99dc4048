// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "pdf/pages.hpp"
#include "pdf/png.hpp"

namespace cmm::pdf {
namespace {

TEST(WithoutPdf, SaysWhatIsMissingAndHowToGetIt) {
    const auto pages = Pages::make({"rotor-1: accept", "", ""});
    ASSERT_FALSE(pages);
    EXPECT_EQ(pages.error().code, core::ErrorCode::config_invalid);
    for (const char* said : {"rotor-1", "built without PDF", "librsvg2-dev", "libpango1.0-dev"})
        EXPECT_NE(pages.error().message.find(said), std::string::npos) << pages.error().message;
    const auto picture = png_of("<svg/>", 100);
    ASSERT_FALSE(picture);
    EXPECT_EQ(picture.error().code, core::ErrorCode::config_invalid);
    for (const char* said : {"built without Cairo", "librsvg2-dev", "--format svg"})
        EXPECT_NE(picture.error().message.find(said), std::string::npos) << picture.error().message;
}

}  // namespace
}  // namespace cmm::pdf
