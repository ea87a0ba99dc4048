// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/clock.hpp"
#include "core/error.hpp"
#include "drivers/machine.hpp"
#include "drivers/machine_file.hpp"

namespace cmm::drivers {

/// What a driver is given by its user. The executor (one strand per machine) and the clock outlive the machine.
struct DriverContext {
    boost::asio::any_io_executor executor;
    const core::Clock& clock;
    std::uint64_t seed = 1;  ///< for the owner number and the jitter of retries: different in every process
};

/// Which driver serves which URL scheme. An object that is passed around: nothing registers itself. Filled once, then
/// read-only.
class Registry {
  public:
    using Factory = std::function<core::Result<std::unique_ptr<Machine>>(const LinkSettings&, const DriverContext&)>;
    struct Entry {
        std::string scheme;
        std::string description;
        Factory factory;
    };

    void add(Entry entry);
    const std::vector<Entry>& entries() const { return entries_; }
    /// Makes the machine, without connecting. Errors: usage (no such scheme; the message lists what there is), those of
    /// the driver.
    core::Result<std::unique_ptr<Machine>> make(const LinkSettings& link, const DriverContext& context) const;

  private:
    std::vector<Entry> entries_;
};

/// The drivers of this library.
Registry standard_registry();

}  // namespace cmm::drivers
