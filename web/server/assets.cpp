// SPDX-License-Identifier: Apache-2.0
#include "web/server/assets.hpp"

// CMMLIVE_PAGE is the folder web; the assembler takes the files as they are.
#define CMMLIVE_ASSET(name, file)                                                                                  \
    __asm__(".section .rodata\n.global cmmlive_asset_" #name "\ncmmlive_asset_" #name ":\n.incbin \"" CMMLIVE_PAGE \
            "/" file "\"\n.global cmmlive_asset_" #name "_end\ncmmlive_asset_" #name "_end:\n.previous\n");        \
    extern "C" const char cmmlive_asset_##name[];                                                                  \
    extern "C" const char cmmlive_asset_##name##_end[];

CMMLIVE_ASSET(index, "ui/index.html")
CMMLIVE_ASSET(style, "ui/style.css")
CMMLIVE_ASSET(script, "dist/app.js")
CMMLIVE_ASSET(icon, "ui/icon.svg")

namespace cmm::web {

std::optional<Asset> find_asset(std::string_view path) {
    const auto asset = [](std::string_view type, const char* begin, const char* end) {
        return Asset{type, std::string_view(begin, static_cast<std::size_t>(end - begin))};
    };
    if (path == "/") return asset("text/html; charset=utf-8", cmmlive_asset_index, cmmlive_asset_index_end);
    if (path == "/style.css") return asset("text/css; charset=utf-8", cmmlive_asset_style, cmmlive_asset_style_end);
    if (path == "/app.js")
        return asset("text/javascript; charset=utf-8", cmmlive_asset_script, cmmlive_asset_script_end);
    if (path == "/icon.svg") return asset("image/svg+xml", cmmlive_asset_icon, cmmlive_asset_icon_end);
    return {};
}

}  // namespace cmm::web
