// SPDX-License-Identifier: Apache-2.0
#include "pdf/svg_picture.hpp"

#include <pango/pangocairo.h>

namespace cmm::pdf {

std::string taken(GError* why) {
    if (why == nullptr) return "unknown";
    std::string text = why->message;
    g_error_free(why);
    return text;
}

Svg parse_svg(std::string_view text, std::string& why) {
    GError* error = nullptr;
    Svg svg(rsvg_handle_new_from_data(reinterpret_cast<const guint8*>(text.data()), text.size(), &error));
    if (!svg) why = taken(error);
    return svg;
}

double proportion_of(RsvgHandle* svg) {
    gboolean has_width = FALSE, has_height = FALSE, has_box = FALSE;
    RsvgLength width{}, height{};
    RsvgRectangle box{};
    rsvg_handle_get_intrinsic_dimensions(svg, &has_width, &width, &has_height, &height, &has_box, &box);
    if (has_box != FALSE && box.width > 0.0) return box.height / box.width;
    return has_width != FALSE && has_height != FALSE && width.length > 0.0 ? height.length / width.length : 0.75;
}

bool has_fonts() {
    PangoFontFamily** families = nullptr;
    int count = 0;
    pango_font_map_list_families(pango_cairo_font_map_get_default(), &families, &count);
    g_free(families);
    return count > 0;
}

}  // namespace cmm::pdf
