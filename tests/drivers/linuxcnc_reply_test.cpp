// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "core/config.hpp"
#include "drivers/linuxcnc/linuxcnc_settings.hpp"
#include "drivers/linuxcnc/rsh_reply.hpp"

namespace cmm::drivers::linuxcnc {
namespace {

using core::ErrorCode;
using Kind = Reply::Kind;

TEST(RshReply, TellsRepliesApart) {
    struct Case {
        std::string line;
        Kind kind;
        std::string name, text;
    };
    for (const Case& expected : {
             Case{"HELLO ACK EMCNETSVR 1.1", Kind::hello, "HELLO", "EMCNETSVR 1.1"},
             Case{"HELLO NAK", Kind::stranger, "HELLO", ""},
             Case{"SET MDI ACK", Kind::done, "MDI", ""},
             Case{"Set Mdi Nak", Kind::refused, "MDI", ""},
             Case{"GET NONSENSE NAK", Kind::not_told, "NONSENSE", ""},
             Case{"ESTOP OFF", Kind::value, "ESTOP", "OFF"},
             Case{"ERROR Probe tripped during non-probe move.", Kind::value, "ERROR",
                  "Probe tripped during non-probe move."},
             Case{"set echo off", Kind::meaningless, "ECHO", ""},
             Case{"GET ESTOP ACK", Kind::meaningless, "ESTOP", ""},
             Case{"HELLO", Kind::meaningless, "HELLO", ""},
             Case{"", Kind::meaningless, "", ""},
         }) {
        const Reply reply = read_reply(expected.line);
        EXPECT_EQ(reply.kind, expected.kind) << expected.line;
        EXPECT_EQ(reply.name, expected.name) << expected.line;
        EXPECT_EQ(reply.text, expected.text) << expected.line;
    }
}

TEST(RshReply, ReadsPositionsFlagsAndUnits) {
    EXPECT_EQ(read_position("1.500000 -2.000000 3.250000 0.000000 0.000000 0.000000"),
              Eigen::Vector3d(1.5, -2.0, 3.25));
    EXPECT_FALSE(read_position("1.5 2.5"));
    EXPECT_FALSE(read_position("1.5 nan 2.5"));
    EXPECT_EQ(read_homed("YES YES YES NO NO NO", 3), true);
    EXPECT_EQ(read_homed("YES YES YES NO NO NO", 4), false);
    EXPECT_FALSE(read_homed("YES YES", 3));
    EXPECT_FALSE(read_homed("YES 17 YES", 3));
    EXPECT_EQ(read_switch("ON"), true);
    EXPECT_EQ(read_switch("NO"), false);
    EXPECT_EQ(read_switch("1"), true);
    EXPECT_FALSE(read_switch("PERHAPS"));
    EXPECT_EQ(read_unit_mm("INCH"), 25.4);
    EXPECT_EQ(read_unit_mm("MM"), 1.0);
    EXPECT_FALSE(read_unit_mm("CUSTOM"));
}

TEST(RshReply, ReportsAreOursOnly) {
    const auto report = read_report("CMMLIVE 17 3.000000 1.000000 -0.500000");
    ASSERT_TRUE(report);
    EXPECT_EQ(report->tag, 17U);
    EXPECT_EQ(report->values, (std::vector<double>{3.0, 1.0, -0.5}));
    for (const char* text : {"OK", "CMMLIVE", "CMMLIVE x 1", "CMMLIVE 1.5 2", "CMMLIVE -1 2", "CMMLIVE 5000000000 2",
                             "Tool change", "CMMLIVE 1 inf"})
        EXPECT_FALSE(read_report(text)) << text;
}

TEST(RshReply, ErrorTextsGetTheirCodes) {
    EXPECT_EQ(error_of_text("Linear move on line 0 would exceed X's positive limit").code, ErrorCode::machine_limit);
    EXPECT_EQ(error_of_text("Probe tripped during non-probe move.").code, ErrorCode::machine_fault);
    EXPECT_EQ(error_of_text("joint 1 following error").code, ErrorCode::machine_position);
    EXPECT_EQ(error_of_text("must be homed before MDI").code, ErrorCode::machine_refused);
    const auto other = error_of_text("something else");
    EXPECT_EQ(other.code, ErrorCode::machine_fault);
    EXPECT_NE(other.message.find("something else"), std::string::npos);
}

core::Status read(const std::string& text, LinuxcncSettings& settings) {
    const auto table = core::ConfigTable::parse(text, "m.toml");
    EXPECT_TRUE(table);
    settings = read_linuxcnc_settings(*table);
    return table->finish();
}

TEST(LinuxcncSettings, AreReadAndChecked) {
    LinuxcncSettings settings;
    ASSERT_TRUE(
        read("joints = 4\nreset_estop = true\nlimit_min_mm = [0, 0, -300]\nlimit_max_mm = [500, 400, 0]\n"
             "latch_delay_us = 500\nmax_speed_mm_s = 200\nconnect_password = \"a\"",
             settings));
    EXPECT_EQ(settings.joints, 4U);
    EXPECT_TRUE(settings.reset_estop);
    EXPECT_EQ(settings.limit_max_mm, Eigen::Vector3d(500.0, 400.0, 0.0));
    EXPECT_EQ(settings.latch_delay_us, 500.0);
    for (const char* wrong :
         {"limit_min_mm = [0, 0, 0]", "limit_min_mm = [0, 0]\nlimit_max_mm = [1, 1, 1]", "joints = 0",
          "limit_min_mm = [0, 0, 0]\nlimit_max_mm = [1, 0, 1]", "enable_password = \"two words\"", "joint = 3"})
        EXPECT_FALSE(read(wrong, settings)) << wrong;
}

}  // namespace
}  // namespace cmm::drivers::linuxcnc
