// SPDX-License-Identifier: Apache-2.0
#include "acquisition/workers.hpp"

#include <algorithm>
#include <boost/asio/post.hpp>
#include <thread>

namespace cmm::acquisition {

Workers::Workers() : Workers(std::max(2U, std::thread::hardware_concurrency()) - 1) {}

void Workers::post(std::function<void()> work) {
    boost::asio::post(pool_, std::move(work));
}

}  // namespace cmm::acquisition
