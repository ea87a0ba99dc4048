// SPDX-License-Identifier: Apache-2.0
#include "drivers/endpoint.hpp"

#include <gtest/gtest.h>

namespace cmm::drivers {
namespace {

Endpoint parsed(std::string_view url) {
    auto endpoint = Endpoint::parse(url);
    EXPECT_TRUE(endpoint) << (endpoint ? "" : endpoint.error().text());
    return endpoint.value_or(Endpoint{});
}

void expect_error(std::string_view url, std::string_view part) {
    const auto endpoint = Endpoint::parse(url);
    ASSERT_FALSE(endpoint) << url;
    EXPECT_EQ(endpoint.error().code, core::ErrorCode::usage);
    EXPECT_NE(endpoint.error().message.find(part), std::string::npos) << endpoint.error().message;
    EXPECT_NE(endpoint.error().message.find(url), std::string::npos) << endpoint.error().message;
}

TEST(Endpoint, NetworkForms) {
    const Endpoint full = parsed("modbus+tcp://192.168.0.7:1502?unit=17");
    EXPECT_EQ(full.scheme, "modbus+tcp");
    EXPECT_EQ(full.host, "192.168.0.7");
    EXPECT_EQ(full.port, 1502);
    EXPECT_EQ(full.integer("unit", 1), 17);
    EXPECT_EQ(parsed("modbus+tcp://cell-3").port, 502);
    EXPECT_EQ(parsed("modbus+tcp://cell-3?in_flight=8").integer("in_flight", 32), 8);
    EXPECT_EQ(parsed("modbus+tcp://cell-3/").host, "cell-3");
    EXPECT_EQ(parsed("ipp://cmm").port, 1294);
    EXPECT_EQ(parsed("linuxcnc://cmm").port, 5007);
    EXPECT_EQ(parsed("modbus+tcp://[::1]:5020").host, "::1");
    EXPECT_EQ(parsed("modbus+tcp://[fe80::2]").port, 502);
}

TEST(Endpoint, DevicesFilesAndDemo) {
    const Endpoint rtu = parsed("modbus+rtu:///dev/ttyUSB0?baud=115200&parity=even&unit=3");
    EXPECT_EQ(rtu.path, "/dev/ttyUSB0");
    EXPECT_EQ(rtu.integer("baud", 0), 115200);
    EXPECT_EQ(rtu.options.at("parity"), "even");
    EXPECT_EQ(rtu.place(), "/dev/ttyUSB0");
    const Endpoint half_duplex = parsed("modbus+rtu:///dev/ttyS0?rts=up&rts_delay_us=200&turnaround_ms=5&stop_bits=2");
    EXPECT_EQ(half_duplex.word("rts", "none"), "up");
    EXPECT_EQ(half_duplex.integer("turnaround_ms", 0), 5);
    EXPECT_EQ(parsed("modbus+rtu+tcp://gateway:4001?unit=2").place(), "gateway:4001");
    EXPECT_EQ(parsed("line+serial:///dev/ttyS1").path, "/dev/ttyS1");
    EXPECT_EQ(parsed("replay:runs/a b.cmmrun").path, "runs/a b.cmmrun");
    EXPECT_EQ(parsed("demo:").scheme, "demo");
    EXPECT_EQ(parsed("vendor:whatever").scheme, "vendor");  // the registry's to judge
}

TEST(Endpoint, TextGivesTheUrlAgain) {
    for (const char* url : {"modbus+tcp://10.0.0.1:1502?unit=2", "modbus+tcp://[::1]:502", "ipp://h:1294",
                            "demo:", "modbus+rtu:///dev/ttyUSB0?baud=9600&parity=none", "replay:run.cmmrun"}) {
        EXPECT_EQ(parsed(url).text(), url);
    }
    EXPECT_EQ(parsed("modbus+tcp://h").text(), "modbus+tcp://h:502");
}

TEST(Endpoint, ErrorsNameTheUrlAndThePlace) {
    expect_error("", "no scheme");
    expect_error("192.168.0.1", "no scheme");
    expect_error("modbus+tcp:host", "'//' is missing");
    expect_error("modbus+tcp://", "host is missing");
    expect_error("modbus+tcp://h:", "port is missing");
    expect_error("modbus+tcp://h:70000", "\"70000\" is not a number from 0 to 65535");
    expect_error("modbus+tcp://h:5o2", "\"5o2\"");
    expect_error("modbus+tcp://h/path", "path cannot follow");
    expect_error("modbus+tcp://fe80::2", "brackets");
    expect_error("modbus+tcp://[::1", "']' is missing");
    expect_error("modbus+tcp://[::1]502", "only ':port'");
    expect_error("modbus+tcp://[::1]:", "port is missing");
    expect_error("modbus+tcp://h?unit", "name=value");
    expect_error("modbus+tcp://h?unit=256", "from 0 to 255, not \"256\"");
    expect_error("modbus+tcp://h?unit=1&unit=2", "twice");
    expect_error("modbus+tcp://h?in_flight=65", "from 1 to 64");
    expect_error("modbus+rtu+tcp://h?in_flight=2", "no option \"in_flight\"");
    expect_error("modbus+rtu:///dev/ttyS0?party=even", "did you mean \"parity\"");
    expect_error("modbus+tcp://h?baud=9600", "no option \"baud\"");
    expect_error("modbus+rtu:///dev/ttyS0?parity=mark", "none, even or odd");
    expect_error("modbus+rtu:///dev/ttyS0?parity=", "none, even or odd");
    expect_error("modbus+rtu:///dev/ttyS0?unit=0", "from 1 to 247");
    expect_error("modbus+rtu:///dev/ttyS0?baud=115000", "the nearest is 115200");
    expect_error("modbus+rtu:///dev/ttyS0?pty=maybe", "no or yes");
    expect_error("modbus+rtu://ttyS0", "device's path");
    expect_error("replay:", "file's name");
    expect_error("demo:now", "nothing may follow");
}

}  // namespace
}  // namespace cmm::drivers
