// SPDX-License-Identifier: Apache-2.0
#include "acquisition/run_file.hpp"

#include <sqlite3.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <optional>
#include <system_error>
#include <thread>
#include <utility>

namespace cmm::acquisition {
namespace {

using core::ErrorCode;
using core::Result;
using core::Status;

constexpr int application_id = 0x434D4D4C;  // "CMML"
constexpr int busy_timeout_ms = 2000;
constexpr const char* settled = "PRAGMA journal_mode=DELETE";

/// One step of the schema; a file of version n gets every step above n. Steps are never changed, only added.
struct Migration {
    int version;
    const char* sql;
};
constexpr std::array migrations{Migration{1, R"sql(
CREATE TABLE run(
  id INTEGER PRIMARY KEY CHECK(id = 1), run_id TEXT NOT NULL, started_utc TEXT NOT NULL, part_path TEXT NOT NULL,
  part_text TEXT NOT NULL, machine_url TEXT NOT NULL, machine_model TEXT NOT NULL, machine_serial TEXT NOT NULL,
  software_version TEXT NOT NULL, plan_hash TEXT NOT NULL, lsb_mm REAL NOT NULL, boot_id INTEGER NOT NULL,
  sequence_shift INTEGER NOT NULL,   ball_radius_mm REAL NOT NULL, verdict TEXT NOT NULL DEFAULT '') STRICT;
CREATE TABLE path(
  id INTEGER PRIMARY KEY, path INTEGER NOT NULL UNIQUE, section INTEGER NOT NULL, first_index INTEGER NOT NULL,
  finished INTEGER NOT NULL DEFAULT 0) STRICT;
CREATE TABLE batch(first_seq INTEGER PRIMARY KEY, count INTEGER NOT NULL, data BLOB NOT NULL) STRICT;
CREATE TABLE event(id INTEGER PRIMARY KEY, seq INTEGER NOT NULL, kind TEXT NOT NULL, line TEXT NOT NULL) STRICT;
CREATE INDEX event_seq ON event(seq);
)sql"},
                                Migration{2, R"sql(
CREATE TABLE capability(name TEXT PRIMARY KEY, value REAL NOT NULL) STRICT;
)sql"},
                                Migration{3, R"sql(
ALTER TABLE path ADD COLUMN pass INTEGER NOT NULL DEFAULT 0;
)sql"},
                                Migration{4, R"sql(
CREATE TABLE part_frame(name TEXT PRIMARY KEY, value REAL NOT NULL) STRICT;
)sql"}};
constexpr int schema_version = migrations.back().version;

/// ENOSPC comes as SQLITE_FULL; a quota or a file size limit as a write error with its errno.
ErrorCode code_of(int rc, int system_error) {
    if (rc == SQLITE_FULL || system_error == ENOSPC || system_error == EDQUOT || system_error == EFBIG) {
        return ErrorCode::journal_full;
    }
    const bool damaged =
        rc == SQLITE_CORRUPT || rc == SQLITE_NOTADB || rc == SQLITE_CONSTRAINT || rc == SQLITE_MISMATCH;
    return damaged ? ErrorCode::journal_corrupt : ErrorCode::journal_io;
}

class Statement {
  public:
    Statement(sqlite3* db, const char* sql) { sqlite3_prepare_v3(db, sql, -1, 0, &handle_, nullptr); }
    ~Statement() { sqlite3_finalize(handle_); }
    Statement(const Statement&) = delete;
    Statement& operator=(const Statement&) = delete;

    void bind(int at, std::int64_t value) { sqlite3_bind_int64(handle_, at, value); }
    void bind(int at, double value) { sqlite3_bind_double(handle_, at, value); }
    void bind(int at, std::string_view text) {
        sqlite3_bind_text64(handle_, at, text.data(), text.size(), SQLITE_TRANSIENT, SQLITE_UTF8);
    }
    void bind(int at, std::span<const std::uint8_t> blob) {
        sqlite3_bind_blob64(handle_, at, blob.data(), blob.size(), SQLITE_TRANSIENT);
    }
    /// SQLITE_ROW, SQLITE_DONE or an error; a statement that did not prepare is an error too.
    int step() { return sqlite3_step(handle_); }

    std::int64_t integer(int column) const { return sqlite3_column_int64(handle_, column); }
    double number(int column) const { return sqlite3_column_double(handle_, column); }
    std::string_view text(int column) const {
        const auto* bytes = reinterpret_cast<const char*>(sqlite3_column_text(handle_, column));
        return bytes == nullptr ? std::string_view{} : std::string_view(bytes, size(column));
    }
    std::span<const std::uint8_t> blob(int column) const {
        const auto* bytes = static_cast<const std::uint8_t*>(sqlite3_column_blob(handle_, column));
        return bytes == nullptr ? std::span<const std::uint8_t>{} : std::span(bytes, size(column));
    }

  private:
    std::size_t size(int column) const { return static_cast<std::size_t>(sqlite3_column_bytes(handle_, column)); }
    sqlite3_stmt* handle_ = nullptr;
};

}  // namespace

struct RunFile::Connection {
    std::string file;
    sqlite3* db = nullptr;

    explicit Connection(std::string name) : file(std::move(name)) {}
    ~Connection() { sqlite3_close_v2(db); }
    Connection(const Connection&) = delete;
    Connection& operator=(const Connection&) = delete;

    tl::unexpected<core::Error> failure(const char* doing) const {
        const int last_errno = errno;
        const int rc = sqlite3_errcode(db);
        if (rc == SQLITE_NOTADB) return corrupt("is not a run file of cmmlive");
        int system = 0;
        if (rc == SQLITE_IOERR || rc == SQLITE_CANTOPEN) {
            system = sqlite3_system_errno(db);
            if (system == 0) system = last_errno;  // SQLite forgets it when a COMMIT fails
        }
        std::string text = file + ": cannot " + doing + ": " + sqlite3_errmsg(db);
        if (system != 0) text += std::string(" (") + std::strerror(system) + ")";
        return core::fail(code_of(rc, system), std::move(text));
    }
    tl::unexpected<core::Error> corrupt(const std::string& what) const {
        return core::fail(ErrorCode::journal_corrupt, file + ": " + what);
    }
    Status open(int flags) {
        if (sqlite3_open_v2(file.c_str(), &db, flags | SQLITE_OPEN_NOMUTEX, nullptr) != SQLITE_OK) {
            return failure("open");
        }
        sqlite3_busy_timeout(db, busy_timeout_ms);
        return run("PRAGMA trusted_schema=OFF; PRAGMA cell_size_check=ON", "open");
    }
    Status run(const char* sql, const char* doing) const {
        if (sqlite3_exec(db, sql, nullptr, nullptr, nullptr) != SQLITE_OK) return failure(doing);
        return {};
    }
    Status done(Statement& statement, const char* doing) const {
        if (statement.step() != SQLITE_DONE) return failure(doing);
        return {};
    }
    Result<std::int64_t> single(const char* sql) const {
        Statement statement(db, sql);
        if (statement.step() != SQLITE_ROW) return failure("read");
        return statement.integer(0);
    }
    Status migrate(std::int64_t from) const {
        for (const auto& step : migrations) {
            if (step.version <= from) continue;
            const std::string sql = std::string("BEGIN IMMEDIATE;") + step.sql +
                                    "PRAGMA user_version=" + std::to_string(step.version) + ";COMMIT;";
            if (auto status = run(sql.c_str(), "set up the schema"); !status) return status;
        }
        return {};
    }
    Status check_kind(Access access) const {
        const auto id = single("PRAGMA application_id");
        if (!id) return tl::unexpected(id.error());
        if (*id != application_id) return corrupt("is not a run file of cmmlive");
        const auto version = single("PRAGMA user_version");
        if (!version) return tl::unexpected(version.error());
        if (*version > schema_version) {
            return corrupt("was written by a newer version (schema " + std::to_string(*version) + ", known up to " +
                           std::to_string(schema_version) + ")");
        }
        if (*version < 1) return corrupt("has no schema of cmmlive");
        if (auto status = check_objects(); !status) return status;
        return access == Access::write ? migrate(*version) : Status{};
    }
    /// A file may come from anywhere: a view or a trigger would run statements that are not ours.
    Status check_objects() const {
        const auto foreign = single("SELECT count(*) FROM sqlite_schema WHERE type NOT IN ('table', 'index')");
        if (!foreign) return tl::unexpected(foreign.error());
        return *foreign == 0 ? Status{} : corrupt("holds views or triggers, which no run file has");
    }
    Status write_header(const Journal::Header& h) const {
        Statement insert(db,
                         "INSERT INTO run(id, run_id, started_utc, part_path, part_text, machine_url, machine_model, "
                         "machine_serial, software_version, plan_hash, lsb_mm, boot_id, sequence_shift, "
                         "ball_radius_mm) VALUES(1, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)");
        int at = 0;
        for (const auto* text : {&h.run_id, &h.started_utc, &h.part_path, &h.part_text, &h.machine_url,
                                 &h.machine_model, &h.machine_serial, &h.software_version, &h.plan_hash}) {
            insert.bind(++at, std::string_view(*text));
        }
        insert.bind(++at, h.lsb_mm);
        insert.bind(++at, std::int64_t{h.boot_id});
        insert.bind(++at, h.sequence_shift);
        insert.bind(++at, h.ball_radius_mm);
        if (auto status = done(insert, "write the header"); !status) return status;
        return write_numbers("INSERT INTO capability(name, value) VALUES(?, ?)", h.capabilities,
                             "write the machine's capabilities");
    }
    Status write_numbers(const char* insert, const std::map<std::string, double>& numbers, const char* doing) const {
        for (const auto& [name, value] : numbers) {
            Statement row(db, insert);
            row.bind(1, std::string_view(name));
            row.bind(2, value);
            if (auto status = done(row, doing); !status) return status;
        }
        return {};
    }
    /// Of a table of names and numbers that the schema has since a version.
    Result<std::map<std::string, double>> numbers(const char* select, std::int64_t since, const char* doing) const {
        std::map<std::string, double> found;
        const auto version = single("PRAGMA user_version");
        if (!version) return tl::unexpected(version.error());
        if (*version < since) return found;
        Statement query(db, select);
        int rc = SQLITE_ROW;
        while ((rc = query.step()) == SQLITE_ROW)
            found.emplace(query.text(0), query.number(1));
        if (rc != SQLITE_DONE) return failure(doing);
        return found;
    }
};

RunFile::RunFile(std::unique_ptr<Connection> connection) : connection_(std::move(connection)) {}
RunFile::~RunFile() = default;

Status RunFile::create(const std::string& file, const Journal::Header& header) {
    std::error_code ignored;
    if (std::filesystem::exists(file, ignored)) {
        return core::fail(ErrorCode::journal_io,
                          file + ": exists; a run is never overwritten (use --resume or another folder)");
    }
    const std::string draft = file + ".new";
    std::filesystem::remove(draft, ignored);
    {
        Connection connection(draft);
        auto status = connection.open(SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE);
        const auto mark = "PRAGMA synchronous=FULL; PRAGMA application_id=" + std::to_string(application_id);
        if (status) status = connection.run(mark.c_str(), "create");
        if (status) status = connection.migrate(0);
        if (status) status = connection.write_header(header);
        if (!status) {
            std::filesystem::remove(draft, ignored);
            return status;
        }
    }
    std::error_code error;
    std::filesystem::rename(draft, file, error);
    if (error) return core::fail(ErrorCode::journal_io, file + ": cannot create: " + error.message());
    return {};
}

Result<std::unique_ptr<RunFile>> RunFile::open(const std::string& file, Access access) {
    auto connection = std::make_unique<Connection>(file);
    std::error_code ignored;
    if (!std::filesystem::is_regular_file(file, ignored)) {
        return core::fail(ErrorCode::journal_io, file + ": is not there or not a file");
    }
    auto status = connection->open(access == Access::write ? SQLITE_OPEN_READWRITE : SQLITE_OPEN_READONLY);
    if (status) status = connection->check_kind(access);
    if (status && access == Access::write) {
        status = connection->run("PRAGMA journal_mode=WAL; PRAGMA synchronous=FULL;", "open for writing");
    }
    if (!status) return tl::unexpected(status.error());
    return std::unique_ptr<RunFile>(new RunFile(std::move(connection)));
}

Status RunFile::begin() {
    return connection_->run("BEGIN IMMEDIATE", "write");
}
Status RunFile::commit() {
    return connection_->run("COMMIT", "write");
}
void RunFile::roll_back() noexcept {
    if (sqlite3_get_autocommit(connection_->db) == 0)
        sqlite3_exec(connection_->db, "ROLLBACK", nullptr, nullptr, nullptr);
}

Status RunFile::set_origin(std::uint32_t boot_id, std::int64_t sequence_shift) {
    Statement update(connection_->db, "UPDATE run SET boot_id = ?, sequence_shift = ?");
    update.bind(1, std::int64_t{boot_id});
    update.bind(2, sequence_shift);
    return connection_->done(update, "write the origin");
}

Status RunFile::set_part_frame(const std::map<std::string, double>& numbers) {
    return connection_->write_numbers("INSERT INTO part_frame(name, value) VALUES(?, ?)", numbers,
                                      "write the frame of the part");
}

Status RunFile::add_batch(std::span<const core::Sample> samples) {
    const auto packed = encoder_.encode(samples);
    if (!packed) return tl::unexpected(packed.error());
    Statement insert(connection_->db, "INSERT INTO batch(first_seq, count, data) VALUES(?, ?, ?)");
    insert.bind(1, static_cast<std::int64_t>(samples.front().sequence));
    insert.bind(2, static_cast<std::int64_t>(samples.size()));
    insert.bind(3, *packed);
    return connection_->done(insert, "write samples");
}

Status RunFile::add_path(const JournalPath& path) {
    Statement insert(connection_->db,
                     "INSERT INTO path(path, section, first_index, finished, pass) VALUES(?, ?, ?, ?, ?)");
    insert.bind(1, std::int64_t{path.path});
    insert.bind(2, static_cast<std::int64_t>(path.section));
    insert.bind(3, std::int64_t{path.first_index});
    insert.bind(4, std::int64_t{path.finished ? 1 : 0});
    insert.bind(5, std::int64_t{path.pass});
    return connection_->done(insert, "write a path");
}

Status RunFile::set_path_finished(std::uint16_t path) {
    Statement update(connection_->db, "UPDATE path SET finished = 1 WHERE path = ?");
    update.bind(1, std::int64_t{path});
    return connection_->done(update, "write a path");
}

Status RunFile::add_event(std::uint64_t seq, std::string_view kind, std::string_view line) {
    Statement insert(connection_->db, "INSERT INTO event(seq, kind, line) VALUES(?, ?, ?)");
    insert.bind(1, static_cast<std::int64_t>(seq));
    insert.bind(2, kind);
    insert.bind(3, line);
    return connection_->done(insert, "write an event");
}

Status RunFile::set_verdict(std::string_view verdict) {
    Statement update(connection_->db, "UPDATE run SET verdict = ?");
    update.bind(1, verdict);
    return connection_->done(update, "write the verdict");
}

Status RunFile::settle() {
    // SQLite does not wait here for those who are just reading, whatever the busy time-out.
    constexpr auto pause = std::chrono::milliseconds(10);
    const auto give_up = std::chrono::steady_clock::now() + std::chrono::milliseconds(busy_timeout_ms);
    auto status = connection_->run(settled, "close");
    while (!status && sqlite3_errcode(connection_->db) == SQLITE_BUSY && std::chrono::steady_clock::now() < give_up) {
        std::this_thread::sleep_for(pause);
        status = connection_->run(settled, "close");
    }
    return status;
}

Result<Journal::Header> RunFile::header() const {
    Statement query(connection_->db,
                    "SELECT run_id, started_utc, part_path, part_text, machine_url, machine_model, machine_serial, "
                    "software_version, plan_hash, lsb_mm, boot_id, sequence_shift, ball_radius_mm FROM run");
    const int rc = query.step();
    if (rc == SQLITE_DONE) return connection_->corrupt("has no header");
    if (rc != SQLITE_ROW) return connection_->failure("read the header");
    Journal::Header h;
    int at = 0;
    for (auto* text : {&h.run_id, &h.started_utc, &h.part_path, &h.part_text, &h.machine_url, &h.machine_model,
                       &h.machine_serial, &h.software_version, &h.plan_hash}) {
        *text = query.text(at++);
    }
    h.lsb_mm = query.number(at);
    h.boot_id = static_cast<std::uint32_t>(query.integer(at + 1));
    h.sequence_shift = query.integer(at + 2);
    h.ball_radius_mm = query.number(at + 3);
    auto capabilities =
        connection_->numbers("SELECT name, value FROM capability", 2, "read the machine's capabilities");
    if (!capabilities) return tl::unexpected(capabilities.error());
    h.capabilities = std::move(*capabilities);
    return h;
}

Status RunFile::each_batch(std::uint64_t from, const Journal::BatchVisitor& visit) const {
    Statement query(connection_->db,
                    "SELECT first_seq, count, data FROM batch WHERE first_seq >= (SELECT coalesce(max(first_seq), 1) "
                    "FROM batch WHERE first_seq <= ?) ORDER BY first_seq");
    query.bind(1, static_cast<std::int64_t>(from));
    std::vector<core::Sample> samples;
    std::optional<std::uint64_t> next;  // of the whole file, or of the batch that the reading begins with
    if (from <= 1) next = 1;
    int rc = SQLITE_ROW;
    while ((rc = query.step()) == SQLITE_ROW) {
        const auto where = "samples from " + std::to_string(query.integer(0)) + ": ";
        if (auto status = decode_samples(query.blob(2), samples); !status) {
            return connection_->corrupt(where + status.error().message);
        }
        if (static_cast<std::int64_t>(samples.size()) != query.integer(1))
            return connection_->corrupt(where + "wrong count");
        std::uint64_t expected = next.value_or(static_cast<std::uint64_t>(query.integer(0)));
        for (const auto& sample : samples) {
            if (sample.sequence == expected++) continue;
            return connection_->corrupt(where + "sequence " + std::to_string(sample.sequence) + " where " +
                                        std::to_string(expected - 1) + " must be");
        }
        next = expected;
        if (auto status = visit(samples); !status) return status;
    }
    return rc == SQLITE_DONE ? Status{} : connection_->failure("read samples");
}

Status RunFile::each_event(std::uint64_t from_seq, const Journal::EventVisitor& visit) const {
    Statement query(connection_->db, "SELECT seq, line FROM event WHERE seq >= ? ORDER BY seq, id");
    query.bind(1, static_cast<std::int64_t>(from_seq));
    int rc = SQLITE_ROW;
    while ((rc = query.step()) == SQLITE_ROW) {
        if (auto status = visit(static_cast<std::uint64_t>(query.integer(0)), query.text(1)); !status) return status;
    }
    return rc == SQLITE_DONE ? Status{} : connection_->failure("read events");
}

Result<std::vector<JournalPath>> RunFile::paths() const {
    const auto version = connection_->single("PRAGMA user_version");
    if (!version) return tl::unexpected(version.error());
    Statement query(connection_->db, *version < 3
                                         ? "SELECT path, section, first_index, finished, 0 FROM path ORDER BY id"
                                         : "SELECT path, section, first_index, finished, pass FROM path ORDER BY id");
    std::vector<JournalPath> paths;
    int rc = SQLITE_ROW;
    while ((rc = query.step()) == SQLITE_ROW) {
        paths.push_back({static_cast<std::uint16_t>(query.integer(0)), static_cast<std::size_t>(query.integer(1)),
                         static_cast<std::uint32_t>(query.integer(2)), query.integer(3) != 0,
                         static_cast<std::uint8_t>(query.integer(4))});
    }
    if (rc != SQLITE_DONE) return connection_->failure("read paths");
    return paths;
}

Result<std::map<std::string, double>> RunFile::part_frame() const {
    return connection_->numbers("SELECT name, value FROM part_frame", 4, "read the frame of the part");
}

Result<std::string> RunFile::verdict() const {
    Statement query(connection_->db, "SELECT verdict FROM run");
    if (query.step() != SQLITE_ROW) return connection_->failure("read the verdict");
    return std::string(query.text(0));
}

Result<std::uint64_t> RunFile::last_event_seq() const {
    const auto seq = connection_->single("SELECT coalesce(max(seq), 0) FROM event");
    if (!seq) return tl::unexpected(seq.error());
    return static_cast<std::uint64_t>(*seq);
}

}  // namespace cmm::acquisition
