// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <atomic>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>

#include "core/clock.hpp"
#include "tests/web/raw_client.hpp"
#include "tests/web/recorded_run.hpp"
#include "web/server/page_server.hpp"

namespace cmm::web {
namespace {

using namespace test;
using nlohmann::json;

std::uint16_t port_of(const std::string& url) {
    return static_cast<std::uint16_t>(std::stoi(url.substr(url.find(':', 7) + 1)));
}
std::string token_of(const std::string& url) {
    return url.substr(url.find("#token=") + 7);
}

/// A page server over a real socket, with a job that only counts its stops.
struct Served : ::testing::Test {
    RecordedRun run;
    const core::SystemClock clock;
    acquisition::EventHub hub{clock};
    std::atomic<int> stops{0};
    std::unique_ptr<PageServer> server;
    std::uint16_t port = 0;
    std::string token;

    void SetUp() override { start({}); }
    void start(std::optional<LiveJob> job) {
        PageOptions options;
        options.listen = "127.0.0.1:0";
        options.runs_folder = run.runs.path("");
        options.version = "test";
        auto started = PageServer::start(options, std::move(job), &hub);
        ASSERT_TRUE(started) << started.error().text();
        server = std::move(*started);
        port = port_of(server->url());
        token = token_of(server->url());
    }
    void start_job() {
        LiveJob job;
        job.folder = run.folder;
        job.status = [] { return std::string("\"share\":0.25"); };
        job.stop = [this] { ++stops; };
        job.events = &hub;
        start(std::move(job));
    }
};

TEST_F(Served, ThePageComesWithItsRules) {
    for (const char* file : {"/", "/app.js", "/style.css", "/icon.svg"}) {
        const auto answer = get(port, file);
        EXPECT_EQ(answer.status, 200) << file;
        EXPECT_GT(answer.body.size(), 200U);
        EXPECT_NE(answer.head.find("default-src 'self'"), std::string::npos);
        EXPECT_EQ(answer.head.find("unsafe"), std::string::npos);
        EXPECT_NE(answer.head.find("X-Content-Type-Options: nosniff"), std::string::npos);
    }
    const std::string page = get(port, "/").body;
    EXPECT_EQ(page.find("<script>"), std::string::npos) << "nothing inline";
    EXPECT_EQ(page.find("style=\""), std::string::npos);
    const auto head = ask(port, "HEAD / HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n");
    EXPECT_EQ(head.status, 200);
    EXPECT_TRUE(head.body.empty());
}

TEST_F(Served, RunsAreListedAndShown) {
    const auto runs = json::parse(get(port, "/api/runs").body).at("runs");
    ASSERT_EQ(runs.size(), 1U);
    EXPECT_EQ(runs[0].at("id"), "first");
    EXPECT_EQ(json::parse(get(port, "/api/run/first/plan").body).at("part"), "blade");
    EXPECT_EQ(json::parse(get(port, "/api/run/first/points?after=3").body).at("points").size(), run.points + 40 - 3);
    EXPECT_TRUE(json::parse(get(port, "/api/run/first/section?index=0").body).at("closed"));
    EXPECT_EQ(json::parse(get(port, "/api/run/first").body).at("result").at("schema"), "cmmlive-result");
    EXPECT_TRUE(json::parse(get(port, "/api/status").body).at("job").is_null());
    for (const char* nowhere :
         {"/api/run/second", "/api/run/first/section?index=9", "/api/run/first/section", "/api/run/first/nothing",
          "/api", "/api/", "/api/stop", "/nothing", "/index.html", "/api/run/first/plan/more"})
        EXPECT_GE(get(port, nowhere).status, 400) << nowhere;
}

TEST_F(Served, NothingLeadsOutOfTheFolder) {
    for (const char* path : {"/../etc/passwd", "/..%2fetc%2fpasswd", "/api/run/..", "/api/run/../first",
                             "/api/run/%2e%2e/plan", "/api/run/..%2f..%2fetc", "/api/run/%2Fetc",
                             "/api/run/first%00/plan", "//etc/passwd", "/app.js/../../etc/passwd"}) {
        const auto answer = get(port, path);
        EXPECT_TRUE(answer.status == 400 || answer.status == 404) << path << ": " << answer.status;
        EXPECT_EQ(answer.body.find("root:"), std::string::npos);
    }
}

TEST_F(Served, AnotherOriginOrNameGetsNothing) {
    EXPECT_EQ(get(port, "/api/runs", "Origin: http://evil.example\r\n").status, 403);
    EXPECT_EQ(ask(port, "GET /api/runs HTTP/1.1\r\nHost: evil.example\r\n\r\n").status, 403);
    EXPECT_EQ(ask(port, "GET / HTTP/1.1\r\nHost: evil.example\r\n\r\n").status, 403);
    EXPECT_EQ(ask(port, "GET /api/runs HTTP/1.1\r\n\r\n").status, 403);
    RawClient socket(port);
    socket.send(upgrade_request(port, "/api/events?run=first", "Origin: http://evil.example\r\n"));
    EXPECT_TRUE(socket.answer().starts_with("HTTP/1.1 403"));
}

TEST_F(Served, NothingMovesWithoutTheToken) {
    start_job();
    EXPECT_EQ(post(port, "/api/stop", "{}").status, 401);
    EXPECT_EQ(post(port, "/api/stop", "{}", bearer("0123456789abcdef")).status, 401);
    EXPECT_EQ(post(port, "/api/stop", "{}", bearer("")).status, 401);
    EXPECT_EQ(post(port, "/api/stop?token=" + token, "{}").status, 401) << "not in the address";
    EXPECT_EQ(post(port, "/api/run/first/points", "{\"reject\":[7]}").status, 401);
    EXPECT_EQ(get(port, "/api/stop", bearer(token)).status, 404);
    EXPECT_EQ(post(port, "/api/stop", "{}", bearer(token) + "Origin: http://evil.example\r\n").status, 403);
    EXPECT_EQ(stops, 0);
    EXPECT_EQ(post(port, "/api/stop", "{}", bearer(token)).status, 200);
    EXPECT_EQ(stops, 1);
    EXPECT_EQ(json::parse(get(port, "/api/status").body).at("job").at("share"), 0.25);
    EXPECT_TRUE(server->end_job().empty());
    EXPECT_EQ(post(port, "/api/stop", "{}", bearer(token)).status, 409) << "the job is over";
    EXPECT_EQ(stops, 1);
}

TEST_F(Served, MetricsAreReadLikeTheRestOfTheApi) {
    start_job();
    hub.emit(acquisition::EventKind::run_started, 0.0, "\"part\":\"p\"");
    const auto answer = get(port, "/metrics");
    EXPECT_EQ(answer.status, 200);
    EXPECT_NE(answer.head.find("text/plain; version=0.0.4"), std::string::npos) << answer.head;
    EXPECT_NE(answer.body.find("\ncmmlive_runs_started_total 1\n"), std::string::npos) << answer.body;
    EXPECT_NE(answer.body.find("\ncmmlive_recorded_runs 1\n"), std::string::npos);
    EXPECT_NE(answer.body.find("\ncmmlive_run_under_way 1\n"), std::string::npos);
    EXPECT_EQ(get(port, "/metrics", "Origin: http://evil.example\r\n").status, 403);
    EXPECT_EQ(post(port, "/metrics", "{}", bearer(token)).status, 404);
    EXPECT_EQ(get(port, "/metrics/more").status, 404);
    EXPECT_EQ(get(port, "/api/cell").status, 404) << "there is no cell";
    server->end_job();
    EXPECT_NE(get(port, "/metrics").body.find("\ncmmlive_run_under_way 0\n"), std::string::npos);
}

TEST_F(Served, OneJobAfterAnother) {
    const std::string second = run.runs.path("second");
    acquisition::EventHub next{clock};
    start_job();
    hub.emit(acquisition::EventKind::run_started, 0.0, "\"part\":\"p\"");
    RawClient watcher(port);
    watcher.send(upgrade_request(port, "/api/events?run=first&from=1"));
    ASSERT_TRUE(watcher.answer().starts_with("HTTP/1.1 101"));
    EXPECT_NE(watcher.frame().find("RunStarted"), std::string::npos);
    server->end_job();
    LiveJob job;
    job.folder = second;
    job.status = [] { return std::string("\"share\":0.5"); };
    job.stop = [this] { stops += 10; };
    server->begin_job(std::move(job), next);
    EXPECT_EQ(json::parse(get(port, "/api/status").body).at("job").at("id"), "second");
    EXPECT_EQ(post(port, "/api/stop", "{}", bearer(token)).status, 200);
    EXPECT_EQ(stops, 10) << "the job that runs, no other";
    next.emit(acquisition::EventKind::hold, 0.0, "\"code\":\"second\"");
    RawClient newcomer(port);
    newcomer.send(upgrade_request(port, "/api/events?run=second&from=1"));
    ASSERT_TRUE(newcomer.answer().starts_with("HTTP/1.1 101"));
    EXPECT_NE(newcomer.frame().find("\"code\":\"second\""), std::string::npos);
    // Who watches the first run goes on with its run file, and hears nothing of the second.
    for (int i = 0; i < 20; ++i)
        next.emit(acquisition::EventKind::hold, 0.0, "\"code\":\"second\"");
    const std::string rest = watcher.frame();
    EXPECT_NE(rest.find("\"seq\":2"), std::string::npos) << rest;
    EXPECT_EQ(rest.find("second"), std::string::npos) << rest;
    EXPECT_EQ(watcher.frame(std::chrono::milliseconds(500)), "");
}

TEST_F(Served, PointsAreLeftOutAndTakenBack) {
    const auto decide = [&](const std::string& body) {
        return post(port, "/api/run/first/points", body, bearer(token));
    };
    const auto reason = [&](std::size_t point) {
        return json::parse(get(port, "/api/run/first/section?index=0").body)
            .at("points")
            .at(point)
            .at(3)
            .get<std::string>();
    };
    EXPECT_EQ(decide("{\"reject\":[7]}").status, 200);
    EXPECT_EQ(reason(6), "by_operator");
    EXPECT_TRUE(std::filesystem::exists(run.folder + "/result.json")) << "the files of the run follow";
    EXPECT_EQ(decide("{\"reject\":[999999]}").status, 409) << "there is no such point";
    EXPECT_EQ(decide("{\"nonsense\":[7]}").status, 400);
    start({});  // a server that begins anew knows it from the files
    EXPECT_EQ(reason(6), "by_operator");
    EXPECT_EQ(decide("{\"undo\":[7]}").status, 200);
    EXPECT_EQ(reason(6), "none");
}

TEST_F(Served, WhatAnOperatorDecidesDuringAJobIsAnEventAndKept) {
    start_job();
    RawClient socket(port);
    socket.send(upgrade_request(port, "/api/events"));
    ASSERT_TRUE(socket.answer().starts_with("HTTP/1.1 101"));
    EXPECT_EQ(post(port, "/api/run/first/points", "{\"reject\":[7]}", bearer(token)).status, 200);
    const auto event = json::parse(socket.frame());
    EXPECT_EQ(event.at("event"), "PointsChosen");
    EXPECT_EQ(event.at("rejected"), json::parse("[7]"));
    EXPECT_FALSE(std::filesystem::exists(run.folder + "/result.json")) << "the job writes the files when it ends";
    EXPECT_EQ(server->end_job().rejected(), (std::set<std::uint64_t>{7}));
}

TEST_F(Served, EventsComeInOrderFromWhereAPageIs) {
    start_job();
    for (int i = 0; i < 1000; ++i)
        hub.emit(acquisition::EventKind::sample_batch, 0.0, "\"count\":1");
    RawClient socket(port);
    socket.send(upgrade_request(port, "/api/events?from=11"));
    ASSERT_TRUE(socket.answer().starts_with("HTTP/1.1 101"));
    std::uint64_t next = 11;
    const auto take = [&] {
        const std::string message = socket.frame();
        std::istringstream lines(message);
        for (std::string line; std::getline(lines, line);)
            EXPECT_EQ(json::parse(line).at("seq"), next++);
        return !message.empty();
    };
    while (next <= 1000 && take()) {
    }
    EXPECT_EQ(next, 1001U);
    hub.emit(acquisition::EventKind::hold, 0.0, "");
    EXPECT_TRUE(take());
    EXPECT_EQ(next, 1002U);
}

TEST_F(Served, WhatTheRingHasLostComesFromTheRunFileWithItsGaps) {
    start_job();
    constexpr int more_than_the_ring = 9000;
    for (int i = 0; i < more_than_the_ring; ++i)
        hub.emit(acquisition::EventKind::sample_batch, 0.0, "");
    RawClient socket(port);
    socket.send(upgrade_request(port, "/api/events?from=2"));
    ASSERT_TRUE(socket.answer().starts_with("HTTP/1.1 101"));
    // The run file has 2 and 5; what it has not is told.
    std::istringstream lines(socket.frame());
    std::vector<json> events;
    for (std::string line; std::getline(lines, line);)
        events.push_back(json::parse(line));
    ASSERT_EQ(events.size(), 4U);
    EXPECT_EQ(events[0].at("seq"), 2);
    EXPECT_EQ(events[1], json::parse(R"({"event":"Gap","first_seq":3,"last_seq":4})"));
    EXPECT_EQ(events[2].at("seq"), 5);
    EXPECT_EQ(events[3].at("event"), "Gap");
    EXPECT_EQ(events[3].at("first_seq"), 6);
    const std::string next = socket.frame();
    EXPECT_EQ(json::parse(next.substr(0, next.find('\n'))).at("seq").get<std::uint64_t>(),
              events[3].at("last_seq").get<std::uint64_t>() + 1);
}

TEST_F(Served, EventsOfAFinishedRunComeFromItsFile) {
    RawClient socket(port);
    socket.send(upgrade_request(port, "/api/events?run=first"));
    ASSERT_TRUE(socket.answer().starts_with("HTTP/1.1 101"));
    EXPECT_EQ(socket.frame(),
              "{\"seq\":1}\n{\"seq\":2}\n{\"event\":\"Gap\",\"first_seq\":3,\"last_seq\":4}\n{\"seq\":5}");
    for (const char* target :
         {"/api/events", "/api/events?run=second", "/api/events?run=first&from=x", "/api/runs", "/"}) {
        RawClient other(port);
        other.send(upgrade_request(port, target));
        EXPECT_TRUE(other.answer().starts_with("HTTP/1.1 4")) << target;
    }
}

TEST_F(Served, TooMuchIsRefusedBeforeItIsRead) {
    EXPECT_EQ(get(port, "/api/runs", "X-Filler: " + std::string(10'000, 'a') + "\r\n").status, 431);
    EXPECT_EQ(ask(port, "POST /api/stop HTTP/1.1\r\nHost: localhost\r\nContent-Length: 100000000\r\n\r\n").status, 413);
    EXPECT_EQ(post(port, "/api/run/first/points", std::string(70'000, ' '), bearer(token)).status, 413);
    EXPECT_EQ(get(port, "/" + std::string(2000, 'a')).status, 404);
    EXPECT_EQ(get(port, "/api/" + std::string(2000, 'a')).status, 400);
    EXPECT_EQ(get(port, "/").status, 200) << "and it is still there";
}

TEST_F(Served, NonsenseIsRefused) {
    for (const std::string& bytes :
         {std::string("nonsense\r\n\r\n"), std::string("GET\r\n\r\n"), std::string("GET / HTTP/9.9\r\n\r\n"),
          std::string(64, '\0'), std::string("\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03", 11),
          std::string("GET / HTTP/1.1\r\nHost localhost\r\n\r\n"),
          std::string("POST /api/stop HTTP/1.1\r\nHost: localhost\r\nContent-Length: -1\r\n\r\n")}) {
        const auto answer = ask(port, bytes);
        EXPECT_TRUE(answer.status == 400 || answer.status == 0) << bytes << answer.status;
    }
    EXPECT_EQ(ask(port, "DELETE /api/runs HTTP/1.1\r\nHost: localhost\r\n\r\n").status, 405);
    EXPECT_EQ(post(port, "/", "{}", bearer(token)).status, 404);
    EXPECT_EQ(get(port, "/").status, 200);
}

TEST_F(Served, HalfARequestHoldsNobodyUp) {
    RawClient half(port), silent(port);
    half.send("POST /api/stop HTTP/1.1\r\nHost: localhost\r\nContent-Le");
    EXPECT_EQ(get(port, "/api/runs").status, 200);
    RawClient page(port);
    page.send(upgrade_request(port, "/api/events?run=first"));
    ASSERT_TRUE(page.answer().starts_with("HTTP/1.1 101"));
    page.send(std::string("\x81\xfe\xff\xff", 4));  // a frame of 64 KiB that never comes
    EXPECT_EQ(get(port, "/api/runs").status, 200);
    server.reset();  // with all of them open
    EXPECT_TRUE(silent.closed(std::chrono::seconds(5)));
}

TEST_F(Served, OnlySoManyConnections) {
    std::vector<std::unique_ptr<RawClient>> many;
    for (int i = 0; i < 64; ++i) {
        many.push_back(std::make_unique<RawClient>(port));
        many.back()->send("GET / HTTP/1.1\r\nHost: localhost\r\n\r\n");
        ASSERT_FALSE(many.back()->answer().empty()) << i;
    }
    EXPECT_EQ(get(port, "/").status, 0);
    many.clear();
    bool free_again = false;
    for (int i = 0; i < 200 && !free_again; ++i)
        free_again = get(port, "/").status == 200;
    EXPECT_TRUE(free_again);
}

TEST_F(Served, OtherMachinesNeedTheTokenForEverything) {
    PageOptions options;
    options.listen = "0.0.0.0:0";
    options.runs_folder = run.runs.path("");
    const auto refused = PageServer::start(options, {}, nullptr);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, core::ErrorCode::usage);
    EXPECT_NE(refused.error().message.find("--token-file"), std::string::npos);

    options.token_file = run.runs.write("token", "0123456789abcdef");
    ASSERT_EQ(::chmod(options.token_file.c_str(), 0600), 0);
    const auto open = PageServer::start(options, {}, nullptr);
    ASSERT_TRUE(open) << open.error().text();
    const auto at = port_of((*open)->url());
    EXPECT_EQ(get(at, "/").status, 200) << "the page itself tells nothing";
    EXPECT_EQ(get(at, "/api/runs").status, 401);
    EXPECT_EQ(get(at, "/api/runs", bearer("0123456789abcdef")).status, 200);
    RawClient without(at), with(at);
    without.send(upgrade_request(at, "/api/events?run=first"));
    EXPECT_TRUE(without.answer().starts_with("HTTP/1.1 401"));
    with.send(
        upgrade_request(at, "/api/events?run=first", "Sec-WebSocket-Protocol: cmmlive.token.0123456789abcdef\r\n"));
    EXPECT_TRUE(with.answer().starts_with("HTTP/1.1 101"));
}

TEST_F(Served, AnAddressInUseOrNoneIsAnError) {
    PageOptions options;
    for (const std::string& listen :
         {"127.0.0.1:" + std::to_string(port), std::string("127.0.0.1"), std::string("127.0.0.1:x"),
          std::string("127.0.0.1:99999"), std::string("127.0.0.999:0"), std::string("")}) {
        options.listen = listen;
        const auto refused = PageServer::start(options, {}, nullptr);
        ASSERT_FALSE(refused) << listen;
        EXPECT_EQ(refused.error().code, core::ErrorCode::usage);
    }
}

}  // namespace
}  // namespace cmm::web
