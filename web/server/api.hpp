// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/events.hpp"
#include "acquisition/run_review.hpp"
#include "drivers/link_stats.hpp"
#include "web/server/guard.hpp"
#include "web/server/message.hpp"
#include "web/server/run_folder.hpp"
#include "web/server/run_metrics.hpp"
#include "web/server/target.hpp"

namespace cmm::web {

/// The running job as the page may see and touch it. The functions may be called from any thread for as long as
/// `Api::end_job` has not returned.
struct LiveJob {
    std::string folder;                        ///< where the run file is, or will be
    std::function<std::string()> status;       ///< fields of a JSON object
    std::function<void()> stop;                ///< nullptr: cannot be stopped from here
    acquisition::EventHub* events = nullptr;   ///< told when an operator has decided about points
    std::function<drivers::LinkStats()> link;  ///< nullptr: there is none
};

/// What a service shows beside its runs; any thread, for as long as the routes live. Absent: nothing more.
struct ServiceView {
    std::function<std::string()> cell;          ///< GET /api/cell: a JSON object
    std::function<void(MetricsText&)> metrics;  ///< more of GET /metrics
};

/// The routes (docs/page.md) and what they need: the runs, each opened when it is asked for. One thread at a time.
class Api {
  public:
    Api(std::string runs_folder, std::optional<LiveJob> job, std::string version, ServiceView view = {});

    /// The guard has let the request pass.
    Response answer(const Request& request);

    /// Who wants to hear the events of which run, from where.
    struct Subscription {
        std::string run;
        std::uint64_t from = 1;
        bool live = false;      ///< the feed has its newest events ...
        std::uint64_t job = 0;  ///< ... as long as this is its job
    };
    /// Of "/api/events?run=ID&from=SEQ"; without a run the running job's. Otherwise why not.
    std::optional<Response> subscribe(const Request& request, Subscription& subscription);
    /// Events of a run from its run file, from this sequence and before `end` (nothing: to the last), each gap told by
    /// a line {"event": "Gap", "first_seq": ..., "last_seq": ...}. Moves `from` behind what was read.
    std::vector<std::string> recorded_events(const std::string& run, std::uint64_t& from,
                                             std::optional<std::uint64_t> end);

    /// The next job begins; the one before has ended.
    void begin_job(LiveJob job);
    /// What was counted; told of every event of every job.
    const std::shared_ptr<RunMetrics>& metrics() const { return metrics_; }
    /// The job has ended: its functions are not called any more. What an operator decided while it ran.
    acquisition::OperatorChoice end_job();

  private:
    using Answer = core::Result<std::string>;
    Response get(const Target& target);
    Response post(const Request& request, const Target& target);
    Answer of_run(const RunFolder& run, const Target& target);
    Response choose_points(const RunFolder& run, const std::string& body);
    core::Result<acquisition::RunReview*> review(const RunFolder& run);
    std::string runs();
    std::string status() const;
    Response metrics_page();
    bool is_live(const RunFolder& run) const;

    struct Open {
        std::unique_ptr<acquisition::RunReview> review;
        std::uint64_t file = 0;  ///< identity of the run file
        std::uint64_t used = 0;
    };
    struct Summary {
        std::int64_t written = 0;  ///< result.json, when
        std::uint64_t file = 0;    ///< identity of the run file
        std::string text;
    };
    RunFolders folders_;
    std::optional<LiveJob> job_;
    std::string version_;
    std::map<std::string, Open> open_;
    std::map<std::string, Summary> summaries_;
    std::uint64_t uses_ = 0;
    ServiceView view_;
    std::shared_ptr<RunMetrics> metrics_ = std::make_shared<RunMetrics>();
    std::optional<drivers::LinkStats> last_link_;  // of the job that ended last
};

}  // namespace cmm::web
