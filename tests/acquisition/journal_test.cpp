// SPDX-License-Identifier: Apache-2.0
#include "acquisition/journal.hpp"

#include <gtest/gtest.h>
#include <sqlite3.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <new>
#include <thread>

#include "core/rng.hpp"

namespace cmm::acquisition {
namespace {

namespace fs = std::filesystem;
using core::ErrorCode;
using core::Sample;
using Clock = std::chrono::steady_clock;

Journal::Header header() {
    Journal::Header h;
    h.run_id = "run-1";
    h.started_utc = "2025-01-02T03:04:05Z";
    h.part_path = "parts/rotor.toml";
    h.part_text = "[part]\nname = \"r\"\n";
    h.machine_url = "modbus+tcp://localhost:1502?unit=1";
    h.machine_model = "CMM";
    h.machine_serial = "7";
    h.software_version = "0.1.0";
    h.plan_hash = "abc";
    h.lsb_mm = 1e-4;
    h.boot_id = 0xBEEF0001;
    h.sequence_shift = -5;
    h.ball_radius_mm = 1.25;
    return h;
}

Sample sample(std::uint64_t sequence) {
    Sample s;
    s.sequence = sequence;
    s.machine_time_us = static_cast<std::int64_t>(1000 * sequence);
    s.host_time_ns = static_cast<std::int64_t>(1'000'003 * sequence);
    const auto noise = static_cast<std::int32_t>((sequence * 2654435761U) >> 26U & 31U);
    s.counts = {static_cast<std::int32_t>(17 * sequence) + noise, -static_cast<std::int32_t>(sequence % 1000), 5};
    s.path = static_cast<std::uint16_t>(1 + sequence / 5000);
    return s;
}

std::vector<Sample> samples(std::uint64_t first, std::size_t count) {
    std::vector<Sample> block;
    for (std::size_t i = 0; i < count; ++i)
        block.push_back(sample(first + i));
    return block;
}

class JournalTest : public ::testing::Test {
  protected:
    void SetUp() override {
        std::string pattern = (fs::temp_directory_path() / "cmm-journal-XXXXXX").string();
        ASSERT_NE(::mkdtemp(pattern.data()), nullptr);
        dir_ = pattern;
        file_ = dir_ + "/run.cmmrun";
    }
    void TearDown() override { fs::remove_all(dir_); }
    std::unique_ptr<Journal> make() {
        auto journal = Journal::create(file_, header());
        EXPECT_TRUE(journal) << journal.error().text();
        return std::move(*journal);
    }
    void sql(const char* text) const {
        sqlite3* db = nullptr;
        ASSERT_EQ(sqlite3_open(file_.c_str(), &db), SQLITE_OK);
        EXPECT_EQ(sqlite3_exec(db, text, nullptr, nullptr, nullptr), SQLITE_OK) << sqlite3_errmsg(db);
        sqlite3_close(db);
    }
    std::string dir_, file_;
};

TEST_F(JournalTest, IsReadFromASequenceOn) {
    auto journal = make();
    ASSERT_TRUE(journal->append(samples(1, 9000)));
    ASSERT_TRUE(journal->flush());
    for (const std::uint64_t from : {1U, 2U, 4096U, 4097U, 9000U, 9001U}) {
        std::uint64_t first = 0, last = 0;
        ASSERT_TRUE(journal->each_batch_from(from, [&](std::span<const Sample> batch) {
            if (first == 0) first = batch.front().sequence;
            last = batch.back().sequence;
            return core::Status{};
        }));
        EXPECT_LE(first, from) << "the batch that holds it";
        EXPECT_LT(from, first + 4097) << "and none before";
        EXPECT_EQ(last, 9000U);
    }
}

TEST_F(JournalTest, IsSettledThoughSomebodyReads) {
    {
        auto journal = make();
        ASSERT_TRUE(journal->append(samples(1, 100)));
        ASSERT_TRUE(journal->finish_run("accept"));
        sqlite3* reader = nullptr;
        ASSERT_EQ(sqlite3_open(file_.c_str(), &reader), SQLITE_OK);
        ASSERT_EQ(sqlite3_exec(reader, "SELECT count(*) FROM batch", nullptr, nullptr, nullptr), SQLITE_OK);
        std::thread gone([reader] {
            std::this_thread::sleep_for(std::chrono::milliseconds(100));
            sqlite3_close(reader);
        });
        journal.reset();
        gone.join();
    }
    EXPECT_FALSE(fs::exists(file_ + "-wal")) << "a finished run is one file";
}

TEST_F(JournalTest, KeepsEverythingAcrossReopening) {
    {
        auto journal = make();
        ASSERT_TRUE(journal->begin_path({7, 2, 0, false}));
        ASSERT_TRUE(journal->append(samples(1, 5000)));
        ASSERT_TRUE(journal->finish_path(7));
        ASSERT_TRUE(journal->begin_path({8, 3, 40, false}));
        ASSERT_TRUE(journal->add_event(1, "RunStarted", R"({"seq":1})"));
        ASSERT_TRUE(journal->add_event(2, "PathStarted", R"({"seq":2})"));
        ASSERT_TRUE(journal->finish_run("accept"));
        EXPECT_EQ(journal->durable_sequence(), 5000U);
    }
    EXPECT_FALSE(fs::exists(file_ + "-wal")) << "a finished run is one file";
    const auto journal = Journal::read(file_);
    ASSERT_TRUE(journal) << journal.error().text();
    const auto& h = (*journal)->header();
    EXPECT_EQ(h.run_id, "run-1");
    EXPECT_EQ(h.part_text, header().part_text);
    EXPECT_EQ(h.lsb_mm, 1e-4);
    EXPECT_EQ(h.boot_id, 0xBEEF0001);
    EXPECT_EQ(h.sequence_shift, -5);
    EXPECT_EQ(h.ball_radius_mm, 1.25);
    EXPECT_EQ((*journal)->verdict().value(), "accept");
    EXPECT_EQ((*journal)->durable_sequence(), 5000U);
    const auto all = (*journal)->samples();
    ASSERT_TRUE(all);
    ASSERT_EQ(all->size(), 5000U);
    for (std::size_t i = 0; i < all->size(); ++i) {
        ASSERT_EQ((*all)[i].sequence, i + 1);
        ASSERT_EQ((*all)[i].counts, sample(i + 1).counts);
        ASSERT_EQ((*all)[i].host_time_ns, sample(i + 1).host_time_ns);
    }
    const auto paths = (*journal)->paths();
    ASSERT_TRUE(paths);
    ASSERT_EQ(paths->size(), 2U);
    EXPECT_TRUE((*paths)[0].finished);
    EXPECT_EQ((*paths)[1].first_index, 40U);
    EXPECT_FALSE((*paths)[1].finished);
    EXPECT_EQ((*journal)->last_event_seq().value(), 2U);
    std::vector<std::string> lines;
    ASSERT_TRUE((*journal)->each_event(2, [&](std::uint64_t, std::string_view line) {
        lines.emplace_back(line);
        return core::Status{};
    }));
    EXPECT_EQ(lines, std::vector<std::string>{R"({"seq":2})"});
}

TEST_F(JournalTest, ReadersSeeWhatWasAppendedWhileTheRunGoesOn) {
    auto journal = make();
    ASSERT_TRUE(journal->append(samples(1, 100)));
    EXPECT_EQ(journal->samples()->size(), 100U);
    ASSERT_TRUE(journal->append(samples(101, 10)));
    ASSERT_TRUE(journal->flush());
    const auto reader = Journal::read(file_);
    ASSERT_TRUE(reader) << reader.error().text();
    EXPECT_EQ((*reader)->samples()->size(), 110U);
    EXPECT_EQ((*reader)->verdict().value(), "");
    EXPECT_FALSE((*reader)->append(samples(111, 1)));
}

TEST_F(JournalTest, WithoutAFlushTheDiskHasItSoon) {
    auto journal = make();
    ASSERT_TRUE(journal->append(samples(1, 15)));
    const auto deadline = Clock::now() + std::chrono::seconds(20);
    while (journal->durable_sequence() < 15 && Clock::now() < deadline)
        std::this_thread::yield();
    EXPECT_EQ(journal->durable_sequence(), 15U);
}

TEST_F(JournalTest, GapsAndRepeatsAreRefusedWhole) {
    auto journal = make();
    EXPECT_FALSE(journal->append(samples(2, 1)));
    ASSERT_TRUE(journal->append(samples(1, 10)));
    const auto repeated = journal->append(samples(10, 5));
    ASSERT_FALSE(repeated);
    EXPECT_EQ(repeated.error().code, ErrorCode::journal_corrupt);
    auto holed = samples(11, 5);
    holed.erase(holed.begin() + 2);
    EXPECT_FALSE(journal->append(holed));
    ASSERT_TRUE(journal->append(samples(11, 5)));
    EXPECT_EQ(journal->samples()->size(), 15U);
}

TEST_F(JournalTest, ResumedRunsCountOn) {
    {
        auto journal = make();
        ASSERT_TRUE(journal->begin_path({1, 0, 0, false}));
        ASSERT_TRUE(journal->append(samples(1, 4100)));
    }
    auto journal = Journal::open(file_);
    ASSERT_TRUE(journal) << journal.error().text();
    EXPECT_EQ((*journal)->durable_sequence(), 4100U);
    EXPECT_FALSE((*journal)->append(samples(4100, 1)));
    ASSERT_TRUE((*journal)->append(samples(4101, 900)));
    EXPECT_TRUE((*journal)->begin_path({1, 0, 0, false})) << "the same facts again are no news";
    EXPECT_FALSE((*journal)->begin_path({1, 1, 0, false}));
    EXPECT_TRUE((*journal)->set_origin(77, 4100));
    EXPECT_EQ((*journal)->header().boot_id, 77U);
    EXPECT_EQ(Journal::read(file_).value()->header().sequence_shift, 4100);
    EXPECT_FALSE((*journal)->finish_path(2));
    EXPECT_TRUE((*journal)->finish_path(1));
    EXPECT_EQ((*journal)->samples()->size(), 5000U);
    EXPECT_TRUE((*journal)->paths()->front().finished);
}

TEST_F(JournalTest, ExistingRunsAreNotOverwritten) {
    { auto journal = make(); }
    const auto again = Journal::create(file_, header());
    ASSERT_FALSE(again);
    EXPECT_EQ(again.error().code, ErrorCode::journal_io);
}

TEST_F(JournalTest, ASecondWriterIsKeptAway) {
    auto journal = make();
    const auto second = Journal::open(file_);
    ASSERT_FALSE(second);
    EXPECT_EQ(second.error().code, ErrorCode::journal_io);
    EXPECT_NE(second.error().message.find("another run"), std::string::npos);
}

TEST_F(JournalTest, UnwritablePlacesAreInputOutputErrors) {
    EXPECT_EQ(Journal::create(dir_ + "/no/such/run.cmmrun", header()).error().code, ErrorCode::journal_io);
    EXPECT_EQ(Journal::create("/proc/run.cmmrun", header()).error().code, ErrorCode::journal_io);
    EXPECT_EQ(Journal::open(file_).error().code, ErrorCode::journal_io);
    EXPECT_EQ(Journal::read(dir_).error().code, ErrorCode::journal_io);
}

TEST_F(JournalTest, ForeignFilesAreRecognised) {
    std::ofstream(file_)
        << "x,y,z\n1,2,3\n and much more text than the head of a database has, so that it is no database\n"
        << std::string(4000, 'x');
    EXPECT_EQ(Journal::read(file_).error().code, ErrorCode::journal_corrupt);
    EXPECT_EQ(Journal::open(file_).error().code, ErrorCode::journal_corrupt);
    fs::remove(file_);
    sql("CREATE TABLE t(a); INSERT INTO t VALUES(1)");
    EXPECT_EQ(Journal::open(file_).error().code, ErrorCode::journal_corrupt);
    fs::remove(file_);
    std::ofstream{file_};
    EXPECT_EQ(Journal::open(file_).error().code, ErrorCode::journal_corrupt);
}

TEST_F(JournalTest, DamageIsFoundAndNamed) {
    {
        auto journal = make();
        ASSERT_TRUE(journal->append(samples(1, 9000)));
        ASSERT_TRUE(journal->finish_run("accept"));
    }
    const auto good = file_ + ".good";
    fs::copy_file(file_, good);
    const std::vector<std::pair<const char*, const char*>> damages{
        {"DELETE FROM batch WHERE first_seq = 4097", "sequence 8193 where 4097"},
        {"UPDATE batch SET data = zeroblob(100) WHERE first_seq = 4097", "samples from 4097"},
        {"UPDATE batch SET count = 5 WHERE first_seq = 1", "wrong count"},
        {"DELETE FROM run", "header"},
        {"PRAGMA user_version = 99", "newer version"},
    };
    for (const auto& [statement, words] : damages) {
        fs::copy_file(good, file_, fs::copy_options::overwrite_existing);
        sql(statement);
        for (const auto& result : {Journal::read(file_), Journal::open(file_)}) {
            ASSERT_FALSE(result) << statement;
            EXPECT_EQ(result.error().code, ErrorCode::journal_corrupt) << statement;
            EXPECT_NE(result.error().message.find(words), std::string::npos) << result.error().message;
        }
    }
}

TEST_F(JournalTest, AFullDiskIsSaidAndTheFileStaysValid) {
    auto journal = make();
    ASSERT_TRUE(journal->append(samples(1, 4096)));
    ASSERT_TRUE(journal->flush());
    // A file size limit acts on this process like a full disk, without needing one.
    rlimit before{};
    ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
    const auto handler = std::signal(SIGXFSZ, SIG_IGN);
    rlimit tight = before;
    tight.rlim_cur = 256 * 1024;
    ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &tight), 0);
    core::Rng rng(3);
    core::Status status;
    std::uint64_t next = 4097;
    for (int round = 0; round < 100 && status; ++round) {
        auto block = samples(next, 4096);
        for (auto& s : block)
            s.machine_time_us = static_cast<std::int64_t>(rng.next());
        status = journal->append(block);
        if (status) status = journal->flush();
        next += block.size();
    }
    ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &before), 0);
    std::signal(SIGXFSZ, handler);
    ASSERT_FALSE(status);
    EXPECT_EQ(status.error().code, ErrorCode::journal_full) << status.error().text();
    EXPECT_EQ(journal->append(samples(next, 1)).error().code, ErrorCode::journal_full) << "the failure is remembered";
    const auto durable = journal->durable_sequence();
    EXPECT_GE(durable, 4096U);
    journal.reset();
    const auto reopened = Journal::open(file_);
    ASSERT_TRUE(reopened) << reopened.error().text();
    EXPECT_EQ((*reopened)->durable_sequence(), durable);
}

/// The child appends as a scan does and tells through shared memory how far the disk has it; it never returns.
[[noreturn]] void append_until_killed(const std::string& file, std::atomic<std::uint64_t>& told) {
    auto journal = Journal::create(file, header());
    if (!journal) ::_exit(1);
    std::uint64_t next = 1;
    while (true) {
        const auto path = static_cast<std::uint16_t>(next % 50'000);  // a path of 1500 samples
        static_cast<void>((*journal)->begin_path({path, 0, 0, false}));
        if (!(*journal)->append(samples(next, 1500))) ::_exit(2);
        static_cast<void>((*journal)->finish_path(path));
        next += 1500;
        told.store((*journal)->durable_sequence());
        while (next > told.load() + 50'000)
            told.store((*journal)->durable_sequence());
    }
}

TEST_F(JournalTest, KilledAtAnyInstantItHoldsAGapFreePrefix) {
    auto* shared =
        ::mmap(nullptr, sizeof(std::atomic<std::uint64_t>), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    ASSERT_NE(shared, MAP_FAILED);
    core::Rng rng(20);
    for (int round = 0; round < 20; ++round) {
        auto* told = new (shared) std::atomic<std::uint64_t>(0);
        const auto file = dir_ + "/killed" + std::to_string(round) + ".cmmrun";
        const auto child = ::fork();
        ASSERT_GE(child, 0);
        if (child == 0) append_until_killed(file, *told);
        // The instant is drawn in samples, then in microseconds.
        const auto goal = rng.below(20'000);
        const auto deadline = Clock::now() + std::chrono::seconds(20);
        while ((told->load() < goal || !fs::exists(file)) && Clock::now() < deadline)
            std::this_thread::yield();
        const auto instant = Clock::now() + std::chrono::microseconds(rng.below(20'000));
        while (Clock::now() < instant) {
        }
        ASSERT_EQ(::kill(child, SIGKILL), 0);
        int state = 0;
        ASSERT_EQ(::waitpid(child, &state, 0), child);
        ASSERT_TRUE(WIFSIGNALED(state)) << "the child failed by itself: " << WEXITSTATUS(state);

        auto journal = Journal::open(file);
        ASSERT_TRUE(journal) << journal.error().text();
        const auto durable = (*journal)->durable_sequence();
        EXPECT_GE(durable, told->load());
        EXPECT_GE(durable, goal);
        EXPECT_EQ((*journal)->samples()->size(), durable);
        const auto paths = (*journal)->paths();
        ASSERT_TRUE(paths);
        for (const auto& path : *paths) {
            EXPECT_TRUE(!path.finished || durable >= path.path + 1499U) << "ended before its samples were kept";
        }
        EXPECT_TRUE((*journal)->append(samples(durable + 1, 10)));
        EXPECT_TRUE((*journal)->flush());
    }
    ::munmap(shared, sizeof(std::atomic<std::uint64_t>));
}

std::size_t resident_bytes() {
    std::ifstream statm("/proc/self/statm");
    std::size_t total = 0;
    std::size_t resident = 0;
    statm >> total >> resident;
    return resident * static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
}

TEST_F(JournalTest, AMillionSamplesNeedNoMemory) {
    auto journal = make();
    std::uint64_t next = 1;
    const auto feed = [&](std::uint64_t last) {
        while (next <= last) {
            ASSERT_TRUE(journal->append(samples(next, 500)));
            next += 500;
            while (next > journal->durable_sequence() + 100'000)
                std::this_thread::yield();
        }
    };
    feed(200'000);
    ASSERT_TRUE(journal->flush());
    const auto memory = resident_bytes();
    feed(1'000'000);
    ASSERT_TRUE(journal->flush());
    const auto grown = resident_bytes() > memory ? resident_bytes() - memory : 0;
    RecordProperty("grown_bytes", std::to_string(grown));
#ifdef NDEBUG
    EXPECT_LT(grown, 16U << 20U);
#endif
    std::uint64_t count = 0;
    ASSERT_TRUE(journal->each_batch([&](std::span<const Sample> batch) {
        count += batch.size();
        return core::Status{};
    }));
    EXPECT_EQ(count, 1'000'000U);
}

}  // namespace
}  // namespace cmm::acquisition
