// SPDX-License-Identifier: Apache-2.0
#include "drivers/registry.hpp"

#include <gtest/gtest.h>

#include <boost/asio/io_context.hpp>
#include <filesystem>
#include <fstream>

namespace cmm::drivers {
namespace {

class TemporaryFile {
  public:
    TemporaryFile(const std::string& name, const std::string& content)
        : path_(std::filesystem::temp_directory_path() / (std::to_string(::getpid()) + "-" + name)) {
        std::ofstream(path_) << content;
    }
    ~TemporaryFile() { std::filesystem::remove(path_); }
    TemporaryFile(const TemporaryFile&) = delete;
    TemporaryFile& operator=(const TemporaryFile&) = delete;
    std::string path() const { return path_.string(); }

  private:
    std::filesystem::path path_;
};

TEST(Registry, MakesAMachineForAKnownScheme) {
    boost::asio::io_context io;
    const core::SystemClock clock;
    const auto settings = link_settings_from("modbus+tcp://127.0.0.1:502");
    ASSERT_TRUE(settings);
    const auto made = standard_registry().make(*settings, {io.get_executor(), clock, 1});
    ASSERT_TRUE(made) << made.error().text();
    EXPECT_EQ((*made)->link_stats().ok, 0U);
}

TEST(Registry, AnUnknownSchemeListsWhatThereIs) {
    boost::asio::io_context io;
    const core::SystemClock clock;
    const auto settings = link_settings_from("modbus+tpc://h");
    ASSERT_TRUE(settings);
    const auto made = standard_registry().make(*settings, {io.get_executor(), clock, 1});
    ASSERT_FALSE(made);
    EXPECT_EQ(made.error().code, core::ErrorCode::usage);
    EXPECT_NE(made.error().message.find("there are: modbus+tcp"), std::string::npos) << made.error().message;
    EXPECT_NE(made.error().message.find("did you mean \"modbus+tcp\""), std::string::npos) << made.error().message;
}

TEST(Registry, PortZeroIsForListenersOnly) {
    boost::asio::io_context io;
    const core::SystemClock clock;
    const auto settings = link_settings_from("modbus+tcp://h:0");
    ASSERT_TRUE(settings);
    const auto made = standard_registry().make(*settings, {io.get_executor(), clock, 1});
    ASSERT_FALSE(made);
    EXPECT_EQ(made.error().code, core::ErrorCode::usage);
}

TEST(Registry, AddedDriversAreServed) {
    Registry registry;
    bool asked = false;
    registry.add({"vendor", "a test", [&asked](const LinkSettings&, const DriverContext&) {
                      asked = true;
                      return core::Result<std::unique_ptr<Machine>>(nullptr);
                  }});
    boost::asio::io_context io;
    const core::SystemClock clock;
    const auto settings = link_settings_from("vendor:x");
    ASSERT_TRUE(settings);
    EXPECT_TRUE(registry.make(*settings, {io.get_executor(), clock, 1}));
    EXPECT_TRUE(asked);
    ASSERT_EQ(registry.entries().size(), 1U);
}

TEST(MachineFile, TheExampleAndTheSimulatorsFileAreReadable) {
    for (const char* file :
         {"config/machines/modbus-rtu.toml", "config/machines/line-serial.toml", "config/machines/dro-serial.toml"}) {
        const auto serial = load_link_settings(file);
        ASSERT_TRUE(serial) << serial.error().text();
        EXPECT_EQ(serial->endpoint.place(), "/dev/ttyUSB0");
    }
    const auto linuxcnc = load_link_settings("config/machines/linuxcnc.toml");
    ASSERT_TRUE(linuxcnc) << linuxcnc.error().text();
    EXPECT_EQ(linuxcnc->endpoint.port, 5007);
    EXPECT_FALSE(linuxcnc->linuxcnc.reset_estop);
    const auto example = load_link_settings("config/machines/modbus-tcp.toml");
    ASSERT_TRUE(example) << example.error().text();
    EXPECT_EQ(example->endpoint.scheme, "modbus+tcp");
    EXPECT_TRUE(std::filesystem::equivalent(example->map_file, "config/maps/cmm-v1.toml"));
    EXPECT_DOUBLE_EQ(example->response_timeout_ms, LinkSettings().response_timeout_ms);
    const auto simulator = link_settings_from("config/machines/sim.toml");
    ASSERT_TRUE(simulator) << simulator.error().text();
    EXPECT_EQ(simulator->endpoint.host, "127.0.0.1");
}

TEST(MachineFile, SaysByHowMuchTheMachineMayErr) {
    const TemporaryFile file("figures.toml",
                             "[link]\nurl = \"modbus+tcp://h\"\n[uncertainty]\nlength_um = 1.9\n"
                             "length_k_mm_per_um = 250\nprobing_form_um = 1.7\n");
    const auto settings = load_link_settings(file.path());
    ASSERT_TRUE(settings) << settings.error().text();
    EXPECT_DOUBLE_EQ(*settings->errors.length_mm, 1.9e-3);
    EXPECT_DOUBLE_EQ(*settings->errors.length_share, 4e-6);
    EXPECT_DOUBLE_EQ(*settings->errors.probing_form_mm, 1.7e-3);
    EXPECT_FALSE(settings->errors.probing_size_mm);
    EXPECT_EQ(link_settings_from("modbus+tcp://h")->errors, MachineErrors());
    // The temperature is the part's.
    const TemporaryFile wrong("wrong.toml",
                              "[link]\nurl = \"modbus+tcp://h\"\n[uncertainty]\npart_temperature_c = 21\n");
    const auto refused = load_link_settings(wrong.path());
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().message.find(wrong.path() + ":4:1: unknown key uncertainty.part_temperature_c"),
              std::string::npos)
        << refused.error().message;
}

TEST(MachineFile, ErrorsNameThePlace) {
    const TemporaryFile missing("no-url.toml", "[link]\nmap = \"m.toml\"\n");
    const auto without_url = load_link_settings(missing.path());
    ASSERT_FALSE(without_url);
    EXPECT_NE(without_url.error().message.find("link.url is missing"), std::string::npos)
        << without_url.error().message;

    const TemporaryFile bad("bad-url.toml", "[link]\nurl = \"modbus+tcp://h:70000\"\n");
    const auto bad_url = load_link_settings(bad.path());
    ASSERT_FALSE(bad_url);
    EXPECT_NE(bad_url.error().message.find(bad.path() + ":2"), std::string::npos) << bad_url.error().message;
    EXPECT_NE(bad_url.error().message.find("65535"), std::string::npos) << bad_url.error().message;

    const TemporaryFile typo("typo.toml", "[link]\nurl = \"modbus+tcp://h\"\nresponse_timout_ms = 5\n");
    const auto unknown = load_link_settings(typo.path());
    ASSERT_FALSE(unknown);
    EXPECT_NE(unknown.error().message.find("response_timeout_ms"), std::string::npos) << unknown.error().message;

    EXPECT_EQ(link_settings_from("no/such/file.toml").error().code, core::ErrorCode::input_missing);
}

}  // namespace
}  // namespace cmm::drivers
