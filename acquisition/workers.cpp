// SPDX-License-Identifier: Apache-2.0
#include "acquisition/workers.hpp"

#include <algorithm>
#include <thread>

namespace cmm::acquisition {

Workers::Workers() : Workers(std::max(2U, std::thread::hardware_concurrency()) - 1) {}

}  // namespace cmm::acquisition
