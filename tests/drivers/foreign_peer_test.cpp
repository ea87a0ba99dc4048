// SPDX-License-Identifier: Apache-2.0
// The driver against a Modbus server that is neither ours nor libmodbus.
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include "machine_rig.hpp"
#include "tests/support/process.hpp"
#include "tests/support/serial_wire.hpp"

namespace cmm::drivers {
namespace {

using test::MachineRig;
using test::RecordingSink;

std::uint16_t free_port() {
    const int fd = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in name{};
    name.sin_family = AF_INET;
    name.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof name;
    auto* address = static_cast<sockaddr*>(static_cast<void*>(&name));
    EXPECT_EQ(::bind(fd, address, size), 0);
    ::getsockname(fd, address, &size);
    ::close(fd);
    return ntohs(name.sin_port);
}

/// A scan on the controller of tests/peers, started with `where` to listen on.
void scan_foreign_controller(const std::string& where, const std::string& url) {
    const cmm::test::TemporaryFolder folder;
    // Debian's package belongs to Debian's interpreter.
    cmm::test::Process server({"/usr/bin/python3", "tests/peers/pymodbus_controller.py", where}, folder / "peer");
    MachineRig rig(test::settings_for(url));
    Machine& machine = *rig.machine;
    core::Result<Capabilities> found;
    const bool up = cmm::test::wait_for([&] {
        found = rig.run(machine.connect());
        return found.has_value() || !server.running();
    });
    ASSERT_TRUE(up);
    if (!server.running() && server.wait(std::chrono::seconds(5)).exit_code == 77) {
        GTEST_SKIP() << "pymodbus is not installed";
    }
    ASSERT_TRUE(found) << found.error().text();
    const LinkStats before = machine.link_stats();  // until it was up
    EXPECT_EQ(found->model, "pymodbus");
    EXPECT_EQ(found->serial, "PY-1");
    ASSERT_TRUE(rig.run(machine.begin_run(std::nullopt)));
    const auto homed = rig.run(machine.home());
    EXPECT_TRUE(homed) << homed.error().text();
    const auto path = test::circle_path(20.0, -5.0, 120, 10.0);
    PointList source(path);
    RecordingSink sink;
    const auto scanned = rig.run(machine.scan(ScanPath{.id = 4}, source, sink));
    ASSERT_TRUE(scanned) << scanned.error().text();
    EXPECT_EQ(scanned->points_passed, 120U);
    ASSERT_EQ(sink.kept.size(), 120U);
    EXPECT_TRUE(sink.out_of_order.empty());
    for (std::size_t k = 0; k < path.size(); ++k) {
        EXPECT_LT((core::centre_mm(sink.kept[k], found->lsb_mm) - path[k].centre_mm).norm(), 1e-4) << k;
    }
    const auto state = rig.run(machine.state());
    ASSERT_TRUE(state) << state.error().text();
    EXPECT_EQ(state->acknowledged_sequence, 120U);
    // A loaded host answers late; nothing else may happen.
    const LinkStats after = machine.link_stats();
    EXPECT_EQ(after.errors() - after.timeouts, before.errors() - before.timeouts);
    EXPECT_EQ(after.invalid, 0U);
    EXPECT_TRUE(rig.run(machine.end_run()));
}

TEST(ForeignPeer, APathIsScannedOnAPymodbusServer) {
    const std::string port = std::to_string(free_port());
    scan_foreign_controller(port, "modbus+tcp://127.0.0.1:" + port);
}

TEST(ForeignPeer, APathIsScannedOnAPymodbusServerOverRtu) {
    const cmm::test::SerialWire wire;
    scan_foreign_controller(wire.device(), "modbus+rtu://" + wire.host() + "?baud=115200&parity=none");
}

}  // namespace
}  // namespace cmm::drivers
