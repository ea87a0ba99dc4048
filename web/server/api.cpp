// SPDX-License-Identifier: Apache-2.0
#include "web/server/api.hpp"

#include <sys/stat.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "acquisition/exports.hpp"
#include "acquisition/json_text.hpp"
#include "acquisition/run_file.hpp"
#include "web/server/choice_request.hpp"
#include "web/server/documents.hpp"

namespace cmm::web {
namespace {

using acquisition::JsonFields;

constexpr std::size_t most_open_runs = 4;
constexpr std::size_t most_lines = 2000;  // of a run file at a time

Response of(const core::Result<std::string>& document) {
    if (!document) {
        const bool missing = document.error().code == core::ErrorCode::input_missing;
        return refusal(missing ? 404 : 500, document.error().text());
    }
    Response response;
    response.body = *document;
    return response;
}

/// Another file under the same name is another run.
std::uint64_t identity_of(const std::string& file) {
    struct stat about {};
    return ::stat(file.c_str(), &about) == 0 ? static_cast<std::uint64_t>(about.st_ino) : 0;
}

std::int64_t written_at(const std::string& file) {
    struct stat about {};
    if (::stat(file.c_str(), &about) != 0) return 0;
    constexpr std::int64_t second_ns = 1'000'000'000;
    return about.st_mtim.tv_sec * second_ns + about.st_mtim.tv_nsec;
}

std::string gap_line(std::uint64_t first, std::uint64_t last) {
    return "{" + JsonFields().add("event", "Gap").add("first_seq", first).add("last_seq", last).text() + "}";
}

}  // namespace

Api::Api(std::string runs_folder, std::optional<LiveJob> job, std::string version, ServiceView view)
    : folders_(std::move(runs_folder), job ? job->folder : std::string()),
      job_(std::move(job)),
      version_(std::move(version)),
      view_(std::move(view)) {}

bool Api::is_live(const RunFolder& run) const {
    return job_ && folders_.live() && run.id == folders_.live()->id;
}

Response Api::answer(const Request& request) {
    const auto target = parse_target(request.target);
    if (!target) return refusal(400, "the address makes no sense");
    return request.method == "POST" ? post(request, *target) : get(*target);
}

Response Api::get(const Target& target) {
    const auto& path = target.path;
    if (path.size() == 2 && path[1] == "runs") return of(runs());
    if (path.size() == 2 && path[1] == "status") return of(status());
    if (path.size() == 2 && path[1] == "cell" && view_.cell) return of(view_.cell() + "\n");
    if (path.size() == 1 && path[0] == "metrics") return metrics_page();
    if (path.size() >= 3 && path[1] == "run") {
        if (const auto run = folders_.find(path[2])) return of(of_run(*run, target));
        return refusal(404, "there is no such run");
    }
    return refusal(404, "there is nothing under this address");
}

Api::Answer Api::of_run(const RunFolder& run, const Target& target) {
    const auto opened = review(run);
    if (!opened) return tl::unexpected(opened.error());
    const std::string what = target.path.size() > 3 ? target.path[3] : "";
    if (target.path.size() == 3) return result_document(run.id, **opened);
    if (target.path.size() == 4 && what == "plan") return plan_document(run.id, **opened);
    if (target.path.size() == 4 && what == "points")
        return points_document(**opened, target.number("after").value_or(0));
    if (target.path.size() == 4 && what == "section") {
        const auto index = target.number("index");
        if (index) return section_document(**opened, static_cast<std::size_t>(*index));
    }
    return core::fail(core::ErrorCode::input_missing, "there is nothing under this address");
}

core::Result<acquisition::RunReview*> Api::review(const RunFolder& run) {
    const std::uint64_t file = identity_of(run.run_file());
    auto known = open_.find(run.id);
    if (known != open_.end() && known->second.file != file) {
        open_.erase(known);
        known = open_.end();
    }
    if (known != open_.end()) {
        if (auto status = known->second.review->refresh(); !status) return tl::unexpected(status.error());
    } else {
        auto opened = acquisition::RunReview::open(run.run_file());
        if (!opened) return tl::unexpected(opened.error());
        (*opened)->choose(recorded_choice(run.path, (*opened)->journal().header().run_id));
        if (open_.size() >= most_open_runs) {
            open_.erase(std::min_element(open_.begin(), open_.end(),
                                         [](const auto& a, const auto& b) { return a.second.used < b.second.used; }));
        }
        known = open_.emplace(run.id, Open{std::move(*opened), file, 0}).first;
    }
    known->second.used = ++uses_;
    return known->second.review.get();
}

std::string Api::runs() {
    std::string rows;
    std::map<std::string, Summary> current;
    for (const auto& run : folders_.list()) {
        const std::int64_t written = written_at(run.path + "/result.json");
        const auto known = summaries_.find(run.id);
        const std::uint64_t file = identity_of(run.run_file());
        const bool fresh =
            known != summaries_.end() && written != 0 && known->second.written == written && known->second.file == file;
        auto& summary = current[run.id];
        summary = fresh ? known->second : Summary{written, file, summary_document(run.id, run.path)};
        rows += (rows.empty() ? "" : ",") + summary.text;
    }
    summaries_ = std::move(current);
    return "{\"runs\":[" + rows + "]}\n";
}

std::string Api::status() const {
    JsonFields fields;
    fields.add("version", version_);
    std::string job = "null";
    if (folders_.live()) {
        JsonFields live;
        live.add("id", folders_.live()->id).add("running", job_.has_value()).add("may_stop", job_ && job_->stop);
        job = "{" + live.text() + (job_ ? "," + job_->status() : std::string()) + "}";
    }
    return "{" + fields.raw("job", job).text() + "}\n";
}

/// Prometheus' text format.
Response Api::metrics_page() {
    MetricsText text;
    text.family("cmmlive_build_info", "gauge", "The version that runs.").value(1.0, {{"version", version_}});
    text.one("cmmlive_run_under_way", "gauge", "Whether a run goes on.", job_ ? 1.0 : 0.0);
    std::size_t recorded = folders_.list().size();
    text.one("cmmlive_recorded_runs", "gauge", "Runs in the folder, at most 1000.", static_cast<double>(recorded));
    metrics_->print(text);
    if (job_ && job_->link) last_link_ = job_->link();
    if (last_link_) print_link(text, *last_link_);
    if (view_.metrics) view_.metrics(text);
    Response response;
    response.content_type = "text/plain; version=0.0.4; charset=utf-8";
    response.body = text.text();
    return response;
}

Response Api::post(const Request& request, const Target& target) {
    const auto& path = target.path;
    if (path.size() == 2 && path[1] == "stop") {
        if (!job_ || !job_->stop) return refusal(409, "nothing runs here that could be stopped");
        job_->stop();
        return of(std::string("{\"stopping\":true}\n"));
    }
    if (path.size() == 4 && path[1] == "run" && path[3] == "points") {
        if (const auto run = folders_.find(path[2])) return choose_points(*run, request.body);
        return refusal(404, "there is no such run");
    }
    return refusal(404, "there is nothing to change under this address");
}

Response Api::choose_points(const RunFolder& run, const std::string& body) {
    const auto opened = review(run);
    if (!opened) return of(tl::unexpected(opened.error()));
    auto& reviewed = **opened;
    const auto before = reviewed.choice();
    auto choice = before;
    if (auto status = apply_choice(body, choice); !status) return refusal(400, status.error().message);
    reviewed.choose(choice);
    const auto result = reviewed.result();
    if (!result) {
        reviewed.choose(before);
        return refusal(result.error().code == core::ErrorCode::usage ? 409 : 500, result.error().text());
    }
    const std::string document = choice_document(reviewed.choice());
    if (is_live(run)) {
        if (job_->events != nullptr) {
            job_->events->emit(acquisition::EventKind::points_chosen, 0.0, document.substr(1, document.size() - 2));
        }
    } else if (auto status = acquisition::write_outputs(*result, run.path); !status) {
        reviewed.choose(before);
        return refusal(500, status.error().text());
    }
    return of(document + "\n");
}

std::optional<Response> Api::subscribe(const Request& request, Subscription& subscription) {
    const auto target = parse_target(request.target);
    if (!target) return refusal(400, "the address makes no sense");
    if (target->path != std::vector<std::string>{"api", "events"}) return refusal(404, "events are under /api/events");
    if (target->query.contains("from") && !target->number("from")) return refusal(400, "from is no sequence number");
    subscription.from = std::max<std::uint64_t>(1, target->number("from").value_or(1));
    const auto named = target->query.find("run");
    if (named != target->query.end()) {
        subscription.run = named->second;
    } else if (folders_.live()) {
        subscription.run = folders_.live()->id;
    }
    const auto run = folders_.find(subscription.run);
    if (!run) return refusal(404, "there is no such run");
    subscription.live = folders_.live() && run->id == folders_.live()->id;
    return {};
}

std::vector<std::string> Api::recorded_events(const std::string& run, std::uint64_t& from,
                                              std::optional<std::uint64_t> end) {
    std::vector<std::string> lines;
    const std::uint64_t limit = end.value_or(std::numeric_limits<std::int64_t>::max());
    const auto folder = folders_.find(run);
    if (!folder) return lines;
    // A file that cannot be read now is read later.
    if (const auto opened = acquisition::RunFile::open(folder->run_file(), acquisition::RunFile::Access::read)) {
        const auto take = [&](std::uint64_t seq, std::string_view line) -> core::Status {
            if (seq >= limit || lines.size() >= most_lines) return core::fail(core::ErrorCode::cancelled, "enough");
            if (seq > from) lines.push_back(gap_line(from, seq - 1));
            lines.emplace_back(line);
            from = std::max(from, seq + 1);
            return {};
        };
        static_cast<void>((*opened)->each_event(from, take));
    }
    if (end && from < *end && lines.size() < most_lines) {
        lines.push_back(gap_line(from, *end - 1));
        from = *end;
    }
    return lines;
}

void Api::begin_job(LiveJob job) {
    folders_.begin(job.folder);
    job_ = std::move(job);
}

acquisition::OperatorChoice Api::end_job() {
    if (job_ && job_->link) last_link_ = job_->link();
    job_.reset();
    const auto& live = folders_.live();
    const auto known = live ? open_.find(live->id) : open_.end();
    return known == open_.end() ? acquisition::OperatorChoice() : known->second.review->choice();
}

}  // namespace cmm::web
