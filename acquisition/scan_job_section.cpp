// SPDX-License-Identifier: Apache-2.0
// The part of a scan job that goes to the next section and measures it.
#include <algorithm>
#include <functional>
#include <utility>

#include "acquisition/json_text.hpp"
#include "acquisition/scan_job.hpp"
#include "acquisition/section_start.hpp"
#include "core/text.hpp"
#include "drivers/until_durable.hpp"

namespace cmm::acquisition {
namespace {

/// A plan that ends early once `enough` says so. Therefore the machine gets its points not long before it needs them.
class PathUntil final : public drivers::PathSource {
  public:
    PathUntil(std::span<const drivers::PathPoint> points, std::function<bool()> enough, SampleIntake& intake)
        : list_(points), enough_(std::move(enough)), intake_(intake), given_(intake.section()->points().size()) {}
    std::size_t next(std::span<drivers::PathPoint> room, bool& last) override {
        LiveSection* section = intake_.section();
        if (section == nullptr || enough_()) {
            last = true;
            if (section != nullptr) section->close_after(given_);
            return 0;
        }
        const std::size_t ahead = given_ - std::min(given_, section->points().size());
        if (ahead + room.size() > points_ahead) return 0;
        const std::size_t given = list_.next(room, last);
        given_ += given;
        return given;
    }

  private:
    static constexpr std::size_t points_ahead = 512;
    drivers::PointList list_;
    std::function<bool()> enough_;
    SampleIntake& intake_;
    std::size_t given_;
};

}  // namespace

boost::asio::awaitable<core::Result<bool>> ScanJob::approach() {
    const auto open = std::find(done_.begin(), done_.end(), false);
    if (rejected()) co_return false;
    if (open == done_.end()) {
        const auto more = co_await find_again();
        if (!more || !*more || again_.paths.empty()) co_return more;
        section_ = again_.paths.front().section;
    } else {
        section_ = static_cast<std::size_t>(open - done_.begin());
    }
    if (!capabilities_.moves) co_return true;
    progress("to " + section_text(section_, setups_[section_].z_mm));
    auto now = co_await machine_.state();
    if (!now) co_return tl::unexpected(now.error());
    if (plan_.paths[section_].points.empty() && restored_[section_].empty())
        co_return true;  // find_part goes there itself
    const bool again = open == done_.end();
    const auto& points = again ? again_.paths.front().points : plan_.paths[section_].points;
    const std::size_t next = again ? again_.paths.front().first : next_planned();
    const auto start = points.empty()
                           ? start_of_section(plan_, plan_.paths[section_], setups_[section_], restored_[section_])
                           : above(points[std::min(next, points.size() - 1)], plan_.approach_mm);
    // Resumed beside the last contact: already there. Without a nominal no way round the part is known that is safer.
    const bool beside = (now->position_mm - start).norm() < 2.0 * plan_.approach_mm && !restored_[section_].empty();
    auto find = [this, beside, from = now->position_mm, start] {
        return beside ? std::vector<Eigen::Vector3d>{start} : travel_route(plan_, from, start);
    };
    const auto route = co_await workers_.run(std::move(find));
    Eigen::Vector3d from = now->position_mm;
    for (const auto& point : route) {
        if (auto status = co_await travel(from, point); !status) {
            core::Error error = status.error();
            error.with_context("on the way to " + section_text(section_, setups_[section_].z_mm));
            co_return tl::unexpected(std::move(error));
        }
        from = point;
    }
    came_from_ = from;
    co_return !rejected();
}

/// Free and straight; should it end in a collision, the way back is known.
ScanJob::Step ScanJob::travel(Eigen::Vector3d from, Eigen::Vector3d to) {
    came_from_ = from;
    co_return co_await machine_.move(to, plan_.travel_speed_mm_s);
}

drivers::ScanPath ScanJob::next_path() const {
    drivers::ScanPath path;
    path.id = static_cast<std::uint16_t>(last_path_ + 1);
    path.section = section_;
    path.approach_mm = request_.part.scan.approach_mm;
    path.search_mm = request_.part.scan.search_mm;
    path.retract_mm = request_.part.scan.approach_mm;
    return path;
}

std::unique_ptr<LiveSection> ScanJob::new_section(std::size_t index) const {
    auto live = std::make_unique<LiveSection>(setups_[index], capabilities_.lsb_mm, machine_.part_from_machine(),
                                              expected_points(index));
    live->restore(restored_[index]);
    return live;
}

/// Written down for good before the machine goes: whose points these will be.
ScanJob::Step ScanJob::begin_path(JournalPath path, std::size_t points) {
    if (auto status = journal_->begin_path(path); !status) co_return status;
    if (auto status = co_await drivers::until_durable(*journal_); !status) co_return status;
    JsonFields fields;
    fields.add("section", section_).add("path", path.path).add("z_mm", setups_[section_].z_mm, 4).add("points", points);
    if (path.pass > 0) fields.add("pass", static_cast<std::size_t>(path.pass));
    events_.emit(EventKind::path_started, 0.0, fields.text());
    co_return core::Status{};
}

ScanJob::Step ScanJob::scan() {
    if (!again_.paths.empty()) co_return co_await scan_again();
    const auto path = next_path();
    last_path_ = path.id;
    JournalPath entry;
    entry.path = path.id;
    entry.section = section_;
    entry.first_index = static_cast<std::uint32_t>(restored_[section_].size());
    if (auto status = co_await begin_path(entry, expected_points(section_)); !status) co_return status;
    progress(section_text(section_, setups_[section_].z_mm));
    left_over_.reset();
    const bool unknown = plan_.paths[section_].points.empty();
    core::Status status;
    if (!capabilities_.moves) {
        status = co_await scan_by_hand(path);
    } else if (unknown) {
        status = co_await scan_unknown(path);
    } else {
        status = co_await scan_planned(path);
    }
    auto left = intake_->end();
    if (!status) {
        left_over_ = std::move(left);
        core::Error error = status.error();
        error.with_context("while scanning " + section_text(section_, setups_[section_].z_mm));
        co_return tl::unexpected(std::move(error));
    }
    if (left) section_completed(std::move(left));
    done_[section_] = true;
    if (out_) co_return core::Status{};  // the path is not finished: --resume may measure the rest
    co_return journal_->finish_path(path.id);
}

ScanJob::Step ScanJob::scan_planned(drivers::ScanPath path) {
    const auto& planned = plan_.paths[section_].points;
    const std::size_t first = next_planned();
    SampleIntake::Completed completed = [this](std::unique_ptr<LiveSection> section) {
        section_completed(std::move(section));
    };
    SampleIntake::Nearing nearing = [this, planned = std::span(planned)](const LiveSection& section, double left_ms) {
        rehearse(section, planned, left_ms);
    };
    intake_->begin(path.id, new_section(section_), std::move(completed), {}, std::move(nearing));
    const auto left = std::span<const drivers::PathPoint>(planned).subspan(first);
    drivers::PointList whole(left);
    bool below = false;  // since its neighbours said so, one below is out for certain
    std::function<bool()> enough = [this, &below] {
        if (is_out()) return true;
        below = out_ = finisher_->rejected();
        return out_;
    };
    PathUntil until_out(left, std::move(enough), *intake_);
    drivers::PathSource& source =
        request_.part.scan.stop_when_rejected ? static_cast<drivers::PathSource&>(until_out) : whole;
    if (touching_) co_return co_await touch_planned(path.id, source);
    auto scanned = co_await machine_.scan(path, source, *intake_);
    if (!scanned) co_return tl::unexpected(scanned.error());
    if (out_) {
        notice((below ? std::string("a section below") : section_text(section_, setups_[section_].z_mm)) +
               " is out of tolerance: the run ends");
    } else if (scanned->points_passed < planned.size() - first) {
        notice(section_text(section_, setups_[section_].z_mm) + ": the machine gave " +
               std::to_string(scanned->points_passed) + " of " + std::to_string(planned.size() - first) +
               " points; the gap is not evaluable");
    }
    co_return core::Status{};
}

/// Whether the section under the probe is out of tolerance for certain.
bool ScanJob::is_out() {
    out_ = out_ || intake_->section()->exceedance();
    return out_;
}

/// With the points that are there, and for the others the places where they are planned.
void ScanJob::rehearse(const LiveSection& section, std::span<const drivers::PathPoint> planned, double left_ms) {
    auto points = section.points();
    for (const auto& place : planned.subspan(std::min(points.size(), planned.size()))) {
        auto& point = points.emplace_back();
        point.sequence = points.size();
        point.centre_mm = place.centre_mm;
    }
    finisher_->rehearse(section.setup(), std::move(points), left_ms);
}

void ScanJob::section_completed(std::unique_ptr<LiveSection> section) {
    done_[section->setup().index] = true;
    again_.measured[section->setup().index] = section->points();
    left_over_.reset();
    progress(section_text(section->setup().index, section->setup().z_mm) + ": " +
             std::to_string(section->points().size()) + " points");
    finisher_->submit(std::move(section));
}

}  // namespace cmm::acquisition
