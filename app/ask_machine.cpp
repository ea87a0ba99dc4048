// SPDX-License-Identifier: Apache-2.0
#include "app/ask_machine.hpp"

#include <boost/asio/co_spawn.hpp>
#include <boost/asio/io_context.hpp>
#include <exception>
#include <optional>
#include <utility>

#include "app/machines.hpp"
#include "core/clock.hpp"

namespace cmm::app {
namespace {

namespace asio = boost::asio;

asio::awaitable<core::Result<MachineReport>> look_at(drivers::Machine& machine) {
    MachineReport report;
    auto capabilities = co_await machine.connect();
    if (!capabilities) co_return tl::unexpected(capabilities.error());
    report.capabilities = *capabilities;
    auto status = co_await machine.state();
    if (!status) co_return tl::unexpected(status.error());
    report.status = *status;
    report.link = machine.link_stats();
    co_return report;
}

}  // namespace

core::Result<MachineReport> ask_machine(const std::string& machine_name) {
    const auto link = drivers::link_settings_from(machine_name);
    if (!link) return tl::unexpected(link.error());
    const core::SystemClock clock;
    asio::io_context context;
    const auto registry = machine_registry();
    auto machine = registry.make(*link, drivers::DriverContext{context.get_executor(), clock, 1});
    if (!machine) return tl::unexpected(machine.error());
    std::optional<core::Result<MachineReport>> report;
    auto done = [&](const std::exception_ptr& thrown, core::Result<MachineReport> result) {
        if (thrown) std::rethrow_exception(thrown);
        report = std::move(result);
    };
    asio::co_spawn(context, look_at(**machine), done);
    context.run();
    return std::move(*report);
}

}  // namespace cmm::app
