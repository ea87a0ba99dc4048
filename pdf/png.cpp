// SPDX-License-Identifier: Apache-2.0
#include "pdf/png.hpp"

#include <cairo.h>

#include <cmath>

#include "pdf/svg_picture.hpp"

namespace cmm::pdf {
namespace {

constexpr double tallest = 4.0;  // times as high as wide

cairo_status_t append_png(void* closure, const unsigned char* data, unsigned int length) {
    static_cast<std::string*>(closure)->append(reinterpret_cast<const char*>(data), length);
    return CAIRO_STATUS_SUCCESS;
}

tl::unexpected<core::Error> no_png(const std::string& why) {
    return core::fail(core::ErrorCode::internal, "PNG: " + why);
}

struct Canvas {
    Canvas(int width, int height)
        : surface(cairo_image_surface_create(CAIRO_FORMAT_RGB24, width, height)), cairo(cairo_create(surface)) {}
    Canvas(const Canvas&) = delete;
    Canvas& operator=(const Canvas&) = delete;
    ~Canvas() {
        cairo_destroy(cairo);
        cairo_surface_destroy(surface);
    }
    cairo_surface_t* surface;
    cairo_t* cairo;
};

}  // namespace

core::Result<std::string> png_of(std::string_view svg, int width_px) {
    if (!has_fonts())
        return core::fail(core::ErrorCode::config_invalid,
                          "a PNG cannot be written: no font is installed; install fonts-dejavu-core");
    std::string why;
    const Svg picture = parse_svg(svg, why);
    if (!picture) return no_png("the picture is no SVG: " + why);
    const double proportion = proportion_of(picture.get());
    if (!(proportion > 0.0) || proportion > tallest) return no_png("the picture has no size");
    const int height_px = static_cast<int>(std::lround(proportion * width_px));
    const Canvas canvas(width_px, height_px);
    cairo_set_source_rgb(canvas.cairo, 1.0, 1.0, 1.0);
    cairo_paint(canvas.cairo);
    const RsvgRectangle box{0.0, 0.0, static_cast<double>(width_px), static_cast<double>(height_px)};
    GError* error = nullptr;
    if (rsvg_handle_render_document(picture.get(), canvas.cairo, &box, &error) == FALSE) return no_png(taken(error));
    std::string bytes;
    const auto status = cairo_surface_write_to_png_stream(canvas.surface, append_png, &bytes);
    if (status != CAIRO_STATUS_SUCCESS) return no_png(cairo_status_to_string(status));
    return bytes;
}

}  // namespace cmm::pdf
