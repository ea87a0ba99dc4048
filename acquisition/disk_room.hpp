// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

namespace cmm::acquisition {

/// Whether the disk of this file has room for so many bytes more: asked by reserving them in a file beside it, which is
/// gone afterwards, so that quotas and limits count as well. Any thread; may take as long as the disk does.
bool disk_has_room(const std::string& beside, std::int64_t bytes);

}  // namespace cmm::acquisition
