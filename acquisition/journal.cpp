// SPDX-License-Identifier: Apache-2.0
#include "acquisition/journal.hpp"

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <condition_variable>
#include <cstring>
#include <deque>
#include <functional>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "acquisition/run_file.hpp"
#include "acquisition/sample_codec.hpp"
#include "acquisition/writer_lock.hpp"

namespace cmm::acquisition {
namespace {

using core::ErrorCode;
using core::Result;
using core::Sample;
using core::Status;

constexpr auto commit_interval = std::chrono::milliseconds(50);
constexpr std::size_t queue_samples = std::size_t{1} << 20U;
constexpr std::size_t queue_notes = std::size_t{1} << 16U;
constexpr std::size_t batches_per_transaction = 16;  // of a backlog; one is the rule

/// Reading is the same for a finished file and for one being written; only the flush before it differs.
class ReadableJournal : public Journal {
  public:
    const Header& header() const override { return header_; }
    Status each_batch_from(std::uint64_t from, const BatchVisitor& visit) const override {
        const auto reader = reader_now();
        return reader ? (*reader)->each_batch(from, visit) : Status(tl::unexpected(reader.error()));
    }
    Status each_event(std::uint64_t from_seq, const EventVisitor& visit) const override {
        const auto reader = reader_now();
        return reader ? (*reader)->each_event(from_seq, visit) : Status(tl::unexpected(reader.error()));
    }
    Result<std::vector<Sample>> samples() const override {
        std::vector<Sample> all;
        auto status = each_batch([&all](std::span<const Sample> batch) {
            all.insert(all.end(), batch.begin(), batch.end());
            return Status{};
        });
        if (!status) return tl::unexpected(std::move(status.error()));
        return all;
    }
    Result<std::uint64_t> last_event_seq() const override {
        return reader_now().and_then([](const auto& reader) { return reader->last_event_seq(); });
    }
    Result<std::vector<JournalPath>> paths() const override {
        return reader_now().and_then([](const auto& reader) { return reader->paths(); });
    }
    Result<std::map<std::string, double>> part_frame() const override {
        return reader_now().and_then([](const auto& reader) { return reader->part_frame(); });
    }
    Result<std::string> verdict() const override {
        return reader_now().and_then([](const auto& reader) { return reader->verdict(); });
    }

  protected:
    void change_origin(std::uint32_t boot_id, std::int64_t sequence_shift) {
        header_.boot_id = boot_id;
        header_.sequence_shift = sequence_shift;
    }
    ReadableJournal(std::string file, Header header) : file_(std::move(file)), header_(std::move(header)) {}
    virtual Status flush_queue() const = 0;

  private:
    /// A connection of its own for every read, so that readers and the writer never share one.
    Result<std::unique_ptr<RunFile>> reader_now() const {
        if (auto status = flush_queue(); !status) return tl::unexpected(std::move(status.error()));
        return RunFile::open(file_, RunFile::Access::read);
    }

    std::string file_;
    Header header_;
};

class ReadOnlyJournal final : public ReadableJournal {
  public:
    ReadOnlyJournal(std::string file, Header header, std::uint64_t last)
        : ReadableJournal(std::move(file), std::move(header)), last_(last) {}
    std::uint64_t durable_sequence() const noexcept override { return last_; }
    Status set_origin(std::uint32_t /*boot_id*/, std::int64_t /*sequence_shift*/) override { return refuse(); }
    Status set_part_frame(const std::map<std::string, double>& /*numbers*/) override { return refuse(); }
    Status append(std::span<const Sample> /*samples*/) override { return refuse(); }
    Result<bool> hasten() override { return true; }
    Status flush() override { return {}; }
    Status begin_path(const JournalPath& /*path*/) override { return refuse(); }
    Status finish_path(std::uint16_t /*path*/) override { return refuse(); }
    Status add_event(std::uint64_t /*seq*/, std::string_view /*kind*/, std::string_view /*line*/) override {
        return refuse();
    }
    Status finish_run(std::string_view /*verdict*/) override { return refuse(); }

  private:
    static Status refuse() { return core::fail(ErrorCode::internal, "the run file is open for reading only"); }
    Status flush_queue() const override { return {}; }
    std::uint64_t last_;
};

/// The queue between the producer and the writer thread. Samples lie in blocks of one batch; empty blocks are used
/// again, so that a steady stream allocates nothing. Notes (paths, events, verdict) remember the last sample before
/// them and reach the disk neither before it nor after the next one.
class WritingJournal final : public ReadableJournal {
  public:
    WritingJournal(const std::string& file, Header header, WriterLock lock, std::unique_ptr<RunFile> out,
                   std::vector<JournalPath> paths, std::uint64_t last)
        : ReadableJournal(file, std::move(header)),
          lock_(std::move(lock)),
          out_(std::move(out)),
          paths_(std::move(paths)),
          queued_(last),
          durable_(last),
          writer_([this] { write_until_closed(); }) {}

    ~WritingJournal() override {
        {
            const std::lock_guard guard(mutex_);
            closing_ = true;
        }
        work_.notify_all();
        writer_.join();
        // A finished run is settled; if that fails the file stays as valid as it was.
        if (run_finished_ && !failure_) static_cast<void>(out_->settle());
    }

    std::uint64_t durable_sequence() const noexcept override { return durable_.load(std::memory_order_acquire); }
    Status set_origin(std::uint32_t boot_id, std::int64_t sequence_shift) override;
    Status set_part_frame(const std::map<std::string, double>& numbers) override;
    Status append(std::span<const Sample> samples) override;
    Result<bool> hasten() override;
    Status flush() override { return flush_queue(); }
    Status begin_path(const JournalPath& path) override;
    Status finish_path(std::uint16_t path) override;
    Status add_event(std::uint64_t seq, std::string_view kind, std::string_view line) override {
        return add_note([seq, kind = std::string(kind), line = std::string(line)](RunFile& out) {
            return out.add_event(seq, kind, line);
        });
    }
    Status finish_run(std::string_view verdict) override;

  private:
    struct Note {
        std::uint64_t after_sequence;
        std::function<Status(RunFile&)> write;
    };
    using Block = std::vector<Sample>;
    struct Work {
        std::vector<Block> blocks;
        std::vector<Note> notes;
        bool empty() const { return blocks.empty() && notes.empty(); }
    };

    Status add_note(std::function<Status(RunFile&)> write);
    Status flush_queue() const override;
    void write_until_closed();
    Work take_work();
    Status write_work(const Work& work);
    void report(Work work, Status status);
    bool idle() const { return blocks_.empty() && notes_.empty() && !writing_; }

    WriterLock lock_;
    std::unique_ptr<RunFile> out_;  ///< the writer thread's alone while it runs
    mutable std::mutex mutex_;
    mutable std::condition_variable work_;
    mutable std::condition_variable done_;
    std::vector<JournalPath> paths_;
    std::deque<Block> blocks_;  ///< the last one is being filled
    std::vector<Block> spare_;
    std::deque<Note> notes_;
    std::size_t waiting_samples_ = 0;
    std::uint64_t queued_;
    std::optional<core::Error> failure_;
    mutable bool flush_wanted_ = false;
    bool writing_ = false;
    bool closing_ = false;
    bool run_finished_ = false;
    std::atomic<std::uint64_t> durable_;
    std::thread writer_;  // last: starts when all else stands
};

Status WritingJournal::set_origin(std::uint32_t boot_id, std::int64_t sequence_shift) {
    auto status = add_note([=](RunFile& out) { return out.set_origin(boot_id, sequence_shift); });
    if (status) status = flush();
    if (status) change_origin(boot_id, sequence_shift);
    return status;
}

Status WritingJournal::set_part_frame(const std::map<std::string, double>& numbers) {
    auto status = add_note([numbers](RunFile& out) { return out.set_part_frame(numbers); });
    return status ? flush() : status;
}

Status WritingJournal::append(std::span<const Sample> samples) {
    bool batch_ready = false;
    {
        const std::lock_guard guard(mutex_);
        if (failure_) return tl::unexpected(*failure_);
        for (std::size_t i = 0; i < samples.size(); ++i) {
            if (samples[i].sequence == queued_ + 1 + i) continue;
            return core::fail(ErrorCode::journal_corrupt, "sample " + std::to_string(samples[i].sequence) +
                                                              " came where " + std::to_string(queued_ + 1 + i) +
                                                              " must come: refused");
        }
        if (waiting_samples_ + samples.size() > queue_samples) {
            return core::fail(ErrorCode::journal_slow,
                              "the disk is too slow: " + std::to_string(waiting_samples_) + " samples wait for it");
        }
        waiting_samples_ += samples.size();
        queued_ += samples.size();
        while (!samples.empty()) {
            if (blocks_.empty() || blocks_.back().size() == max_batch_samples) {
                blocks_.push_back(spare_.empty() ? Block{} : std::move(spare_.back()));
                if (!spare_.empty()) spare_.pop_back();
                blocks_.back().reserve(max_batch_samples);
            }
            auto& block = blocks_.back();
            const auto part = samples.first(std::min(samples.size(), max_batch_samples - block.size()));
            block.insert(block.end(), part.begin(), part.end());
            samples = samples.subspan(part.size());
        }
        batch_ready = !blocks_.empty() && blocks_.front().size() == max_batch_samples;
    }
    if (batch_ready) work_.notify_one();
    return {};
}

Status WritingJournal::add_note(std::function<Status(RunFile&)> write) {
    const std::lock_guard guard(mutex_);
    if (failure_) return tl::unexpected(*failure_);
    if (notes_.size() >= queue_notes) return core::fail(ErrorCode::journal_slow, "the disk is too slow for the events");
    notes_.push_back({queued_, std::move(write)});
    return {};
}

Status WritingJournal::begin_path(const JournalPath& path) {
    {
        const std::lock_guard guard(mutex_);
        for (const auto& known : paths_) {
            if (known.path != path.path) continue;
            if (known.section == path.section && known.first_index == path.first_index && known.pass == path.pass)
                return {};
            return core::fail(ErrorCode::internal,
                              "path " + std::to_string(path.path) + " began before as another one");
        }
        paths_.push_back(path);
    }
    return add_note([path](RunFile& out) { return out.add_path(path); });
}

Status WritingJournal::finish_path(std::uint16_t path) {
    {
        const std::lock_guard guard(mutex_);
        const auto known = [path](const JournalPath& one) { return one.path == path; };
        if (std::none_of(paths_.begin(), paths_.end(), known)) {
            return core::fail(ErrorCode::internal, "path " + std::to_string(path) + " ended but never began");
        }
    }
    return add_note([path](RunFile& out) { return out.set_path_finished(path); });
}

Status WritingJournal::finish_run(std::string_view verdict) {
    auto status = add_note([verdict = std::string(verdict)](RunFile& out) { return out.set_verdict(verdict); });
    if (status) status = flush();
    if (status) {
        const std::lock_guard guard(mutex_);
        run_finished_ = true;
    }
    return status;
}

Result<bool> WritingJournal::hasten() {
    const std::lock_guard guard(mutex_);
    if (failure_) return tl::unexpected(*failure_);
    if (idle()) return true;
    flush_wanted_ = true;
    work_.notify_one();
    return false;
}

Status WritingJournal::flush_queue() const {
    std::unique_lock guard(mutex_);
    flush_wanted_ = !idle();
    work_.notify_one();
    done_.wait(guard, [this] { return failure_ || idle(); });
    return failure_ ? Status(tl::unexpected(*failure_)) : Status{};
}

void WritingJournal::write_until_closed() {
    std::unique_lock guard(mutex_);
    while (true) {
        const auto at_once = [this] {
            return closing_ || flush_wanted_ || (!blocks_.empty() && blocks_.front().size() == max_batch_samples);
        };
        work_.wait_for(guard, commit_interval, at_once);
        Work work = take_work();
        if (work.empty()) {
            if (closing_) return;
            continue;
        }
        writing_ = true;
        guard.unlock();
        auto status = write_work(work);
        guard.lock();
        writing_ = false;
        report(std::move(work), std::move(status));
        if (failure_) return;
    }
}

WritingJournal::Work WritingJournal::take_work() {
    Work work;
    std::uint64_t last = durable_.load(std::memory_order_relaxed);
    while (!blocks_.empty() && work.blocks.size() < batches_per_transaction) {
        work.blocks.push_back(std::move(blocks_.front()));
        blocks_.pop_front();
        last = work.blocks.back().back().sequence;
    }
    while (!notes_.empty() && notes_.front().after_sequence <= last) {
        work.notes.push_back(std::move(notes_.front()));
        notes_.pop_front();
    }
    if (blocks_.empty() && notes_.empty()) flush_wanted_ = false;
    return work;
}

Status WritingJournal::write_work(const Work& work) {
    auto status = out_->begin();
    for (const auto& block : work.blocks) {
        if (status) status = out_->add_batch(block);
    }
    for (const auto& note : work.notes) {
        if (status) status = note.write(*out_);
    }
    if (status) status = out_->commit();
    if (!status) out_->roll_back();
    return status;
}

/// Under the mutex: what the disk has now, or why it has not.
void WritingJournal::report(Work work, Status status) {
    if (!status) {
        failure_ = std::move(status.error());
    } else {
        for (auto& block : work.blocks) {
            durable_.store(block.back().sequence, std::memory_order_release);
            waiting_samples_ -= block.size();
            block.clear();
            if (spare_.size() < batches_per_transaction) spare_.push_back(std::move(block));
        }
    }
    if (failure_ || idle()) done_.notify_all();
}

/// Reads the whole file once: every CRC, every sequence. Answers the last one.
Result<std::uint64_t> check_samples(const RunFile& file) {
    std::uint64_t last = 0;
    auto status = file.each_batch(1, [&last](std::span<const Sample> batch) {
        if (!batch.empty()) last = batch.back().sequence;
        return Status{};
    });
    if (!status) return tl::unexpected(std::move(status.error()));
    return last;
}

}  // namespace

Result<std::unique_ptr<Journal>> Journal::create(const std::string& file, const Header& header) {
    if (auto status = RunFile::create(file, header); !status) return tl::unexpected(std::move(status.error()));
    return open(file);
}

Result<std::unique_ptr<Journal>> Journal::open(const std::string& file) {
    auto lock = WriterLock::take(file);
    if (!lock) return tl::unexpected(std::move(lock.error()));
    auto out = RunFile::open(file, RunFile::Access::write);
    if (!out) return tl::unexpected(std::move(out.error()));
    auto header = (*out)->header();
    if (!header) return tl::unexpected(std::move(header.error()));
    auto paths = (*out)->paths();
    if (!paths) return tl::unexpected(std::move(paths.error()));
    auto last = check_samples(**out);
    if (!last) return tl::unexpected(std::move(last.error()));
    return std::make_unique<WritingJournal>(file, std::move(*header), std::move(*lock), std::move(*out),
                                            std::move(*paths), *last);
}

Result<std::unique_ptr<Journal>> Journal::read(const std::string& file) {
    auto in = RunFile::open(file, RunFile::Access::read);
    if (!in) return tl::unexpected(std::move(in.error()));
    auto header = (*in)->header();
    if (!header) return tl::unexpected(std::move(header.error()));
    auto last = check_samples(**in);
    if (!last) return tl::unexpected(std::move(last.error()));
    return std::make_unique<ReadOnlyJournal>(file, std::move(*header), *last);
}

}  // namespace cmm::acquisition
