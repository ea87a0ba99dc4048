// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <chrono>

#include "cell/mqtt_publisher.hpp"
#include "cell/mqtt_queue.hpp"

namespace cmm::cell {
namespace {

TEST(MqttOptions, TheFormOfAnAddress) {
    const auto plain = MqttOptions::parse("mqtt://broker");
    ASSERT_TRUE(plain);
    EXPECT_EQ(plain->host, "broker");
    EXPECT_EQ(plain->port, 1883);
    EXPECT_EQ(plain->prefix, "cmmlive");
    const auto whole = MqttOptions::parse("mqtt://[fd00::1]:8883/hall/cell7");
    ASSERT_TRUE(whole);
    EXPECT_EQ(whole->host, "fd00::1");
    EXPECT_EQ(whole->port, 8883);
    EXPECT_EQ(whole->prefix, "hall/cell7");
    for (const char* wrong : {"broker", "http://broker", "mqtt://", "mqtt://b:0", "mqtt://b:65536", "mqtt://b:x",
                              "mqtt://b/", "mqtt://b//x", "mqtt://b/a/", "mqtt://b/a/#", "mqtt://b/+", "mqtt://b/$SYS",
                              "mqtt://b/a b", "mqtt://user@b"}) {
        const auto parsed = MqttOptions::parse(wrong);
        ASSERT_FALSE(parsed) << wrong;
        EXPECT_EQ(parsed.error().code, core::ErrorCode::usage);
    }
}

TEST(MqttQueue, OfARetainedTopicOnlyTheNewestWaits) {
    MqttQueue queue(3);
    queue.push({"state", "1", true});
    queue.push({"decision", "a", false});
    queue.push({"state", "2", true});
    EXPECT_EQ(queue.size(), 2U);
    EXPECT_EQ(queue.dropped(), 0U) << "superseded is not lost";
    EXPECT_EQ(queue.pop()->payload, "a");
    EXPECT_EQ(queue.pop()->payload, "2");
    EXPECT_FALSE(queue.pop());
}

TEST(MqttQueue, WhatIsRetainedOutlivesAFullQueue) {
    MqttQueue queue(3);
    queue.push({"result", "r", true});
    for (const char* payload : {"a", "b", "c", "d"})
        queue.push({"decision", payload, false});
    EXPECT_EQ(queue.dropped(), 2U);
    EXPECT_EQ(queue.pop()->payload, "r");
    EXPECT_EQ(queue.pop()->payload, "c");
    EXPECT_EQ(queue.pop()->payload, "d");
}

TEST(MqttPublisher, WithoutABrokerNothingWaits) {
    MqttOptions options;
    options.host = "127.0.0.1";
    options.port = 1;  // nobody listens there
    options.prefix = "test";
    const auto started = MqttPublisher::start(options, [](const std::string&) {});
    if (!started && started.error().message.find("speaks no MQTT") != std::string::npos)
        GTEST_SKIP() << started.error().text();
    ASSERT_TRUE(started) << started.error().text();
    const auto begun = std::chrono::steady_clock::now();
    for (int i = 0; i < 1000; ++i) {
        (*started)->publish("decision", std::to_string(i), false);
        (*started)->publish("state", std::to_string(i), true);
    }
    EXPECT_LT(std::chrono::steady_clock::now() - begun, std::chrono::seconds(2)) << "no network in 2000 messages";
    const auto counts = (*started)->counts();
    EXPECT_FALSE(counts.connected);
    EXPECT_EQ(counts.published, 0U);
    EXPECT_EQ(counts.waiting, 256U);
    EXPECT_EQ(counts.dropped, 1000U - 255U);
}

}  // namespace
}  // namespace cmm::cell
