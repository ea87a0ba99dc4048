// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <librsvg/rsvg.h>

#include <memory>
#include <string>
#include <string_view>

/// What both writers of this layer need of librsvg; for its sources alone.
namespace cmm::pdf {

template <class T>
struct Unref {
    void operator()(T* object) const { g_object_unref(object); }
};
using Svg = std::unique_ptr<RsvgHandle, Unref<RsvgHandle>>;

/// What a call of GLib said, which is freed.
std::string taken(GError* why);
/// Empty and `why` told: it is no SVG.
Svg parse_svg(std::string_view text, std::string& why);
/// Height over width.
double proportion_of(RsvgHandle* svg);
/// Texts can be written.
bool has_fonts();

}  // namespace cmm::pdf
