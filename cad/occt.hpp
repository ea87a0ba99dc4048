// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <mutex>

namespace cmm::cad {

/// Open CASCADE's readers and writers share settings, and its algorithms refine the shapes that they are given: one at
/// a time. The first one also silences it, for it would speak on standard output, which is somebody else's.
std::unique_lock<std::mutex> alone_with_occt();

}  // namespace cmm::cad
