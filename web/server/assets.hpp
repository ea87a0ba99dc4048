// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string_view>

namespace cmm::web {

/// The files of the page (web/ui, its script from web/dist), which are part of the program.
struct Asset {
    std::string_view content_type, content;
};

/// "/" is the page itself; nothing for a path that is no file of it.
std::optional<Asset> find_asset(std::string_view path);

}  // namespace cmm::web
