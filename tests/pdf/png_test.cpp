// SPDX-License-Identifier: Apache-2.0
/// The map of deviations as PNG, read back by Cairo's own reader of PNG.
#include "pdf/png.hpp"

#include <cairo.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <vector>

#include "acquisition/exports.hpp"
#include "core/text.hpp"
#include "tests/acquisition/judged_part.hpp"
#include "tests/acquisition/temp_folder.hpp"

namespace cmm {
namespace {

struct Image {
    int width = 0, height = 0;
    std::vector<std::uint32_t> pixels;  // 0xrrggbb

    std::size_t count(std::uint32_t colour) const {
        return static_cast<std::size_t>(std::count(pixels.begin(), pixels.end(), colour));
    }
};

Image read_png(const std::string& file) {
    Image image;
    cairo_surface_t* surface = cairo_image_surface_create_from_png(file.c_str());
    EXPECT_EQ(cairo_surface_status(surface), CAIRO_STATUS_SUCCESS) << file;
    image.width = cairo_image_surface_get_width(surface);
    image.height = cairo_image_surface_get_height(surface);
    for (int row = 0; row < image.height; ++row) {
        const auto* line = cairo_image_surface_get_data(surface) + row * cairo_image_surface_get_stride(surface);
        for (int column = 0; column < image.width; ++column) {
            std::uint32_t pixel = 0;
            std::memcpy(&pixel, line + 4 * column, 4);
            image.pixels.push_back(pixel & 0xffffffU);
        }
    }
    cairo_surface_destroy(surface);
    return image;
}

TEST(Png, ThePicturesColoursAndProportions) {
    const auto bytes = pdf::png_of(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 40 20\"><path fill=\"#b2182b\" d=\"M10 "
        "0h20v10h-20Z\"/></svg>",
        400);
    ASSERT_TRUE(bytes) << bytes.error().text();
    const acquisition::TempFolder folder;
    std::ofstream(folder.path("a.png"), std::ios::binary) << *bytes;
    const Image image = read_png(folder.path("a.png"));
    EXPECT_EQ(image.width, 400);
    EXPECT_EQ(image.height, 200);
    EXPECT_EQ(image.count(0xb2182b), 200U * 100U);
    EXPECT_EQ(image.count(0xffffff), 400U * 200U - 200U * 100U);
    EXPECT_FALSE(pdf::png_of("<html>", 100));
}

TEST(Png, TheMapOfDeviationsShowsWhichSideIsOut) {
    using namespace acquisition;
    const TempFolder folder;
    // One side 0.2 mm too thick in zones of 0.1 mm: red, nothing blue.
    const auto part = part_of({section_at(0, 0.0), section_at(1, 0.2)});
    ASSERT_TRUE(export_png(part, folder.path("map.png")));
    const Image image = read_png(folder.path("map.png"));
    EXPECT_EQ(image.width, 2200);
    const auto scale = image.count(0x2166ac);  // blue is in the scale alone
    EXPECT_GT(scale, 100U);
    EXPECT_GT(image.count(0xb2182b), 20U * scale);
    const auto twice = export_png(part, folder.path("again.png"));
    ASSERT_TRUE(twice);
    EXPECT_EQ(core::read_file(folder.path("map.png")).value(), core::read_file(folder.path("again.png")).value());
    EXPECT_EQ(export_png(part_of({}), folder.path("none.png")).error().code, core::ErrorCode::input_invalid);
}

}  // namespace
}  // namespace cmm
