// SPDX-License-Identifier: Apache-2.0
#include "sim/line_protocol.hpp"

#include <gtest/gtest.h>

#include "tests/sim/controller_rig.hpp"

namespace cmm::sim::test {
namespace {

struct Host {
    Rig rig;
    LineProtocol protocol{rig.controller};
    /// What comes back for a stream of bytes.
    std::string say(const std::string& text) {
        std::vector<std::uint8_t> in(text.begin(), text.end());
        std::vector<std::uint8_t> out;
        for (;;) {
            const auto progress = protocol.answer(in, {}, out);
            if (progress.used == 0) break;
            in.erase(in.begin(), in.begin() + static_cast<std::ptrdiff_t>(progress.used));
        }
        return {out.begin(), out.end()};
    }
    /// A line with its CRC, as line_reply makes it for the other direction.
    static std::string line(int tag, const std::string& body) {
        return line_reply('#', static_cast<std::uint16_t>(tag), body);
    }
};

TEST(LineProtocol, ALineOfTheDocumentIsAnswered) {
    Host host;
    EXPECT_EQ(host.say("#1 STOP 1*1B5B\n"), "=1*48B4\n");
    EXPECT_EQ(host.rig.controller.state(), MachineState::stopped);
}

TEST(LineProtocol, LinesThatAreDamagedAreNotAnswered) {
    Host host;
    std::string line = Host::line(3, "STOP 2");
    EXPECT_EQ(host.say("noise" + Host::line(3, "ST")).substr(0, 3), "=3 ") << "noise before the line does not matter";
    line[4] = 'L';
    EXPECT_EQ(host.say(line), "");
    EXPECT_EQ(host.say("#3 STOP 2\n"), "") << "without a CRC";
    EXPECT_EQ(host.say("\n\r\n\n"), "");
    EXPECT_EQ(host.say(std::string(5000, 'x')), "");
    EXPECT_EQ(host.rig.controller.state(), MachineState::idle);
}

TEST(LineProtocol, RefusalsSayWhy) {
    Host host;
    const auto refused = [&](const std::string& body) { return host.say(Host::line(9, body)).substr(0, 4); };
    EXPECT_EQ(refused("FLY 1"), "!9 1");
    EXPECT_EQ(refused("DO 1 7 FLY"), "!9 1");
    EXPECT_EQ(refused("DO 0 7 HOME"), "!9 3");
    EXPECT_EQ(refused("DO 1 7 MOVE x"), "!9 3");
    EXPECT_EQ(refused("STOP 3"), "!9 3");
    EXPECT_EQ(refused("PP 1 0 1 2 3"), "!9 3");
    EXPECT_EQ(refused("SA 1 99 1 64"), "!9 3") << "acknowledges what was never sent";
    EXPECT_EQ(refused("SA 1 0 1"), "!9 3");
}

TEST(LineProtocol, ACommandIsCarriedOutOncePerSequence) {
    Host host;
    const std::string claim = Host::line(1, "DO 5 7 CLAIM");
    EXPECT_EQ(host.say(claim).substr(0, 2), "=1");
    EXPECT_EQ(host.rig.controller.owner(), 7U);
    EXPECT_EQ(host.say(Host::line(2, "DO 6 7 RELEASE")).substr(0, 2), "=2");
    EXPECT_EQ(host.say(claim).substr(0, 2), "=1") << "another sequence than the last";
    EXPECT_EQ(host.say(claim + claim).size(), 2 * host.say(claim).size()) << "repetitions are answered too";
    EXPECT_EQ(host.rig.controller.owner(), 7U);
}

}  // namespace
}  // namespace cmm::sim::test
