// SPDX-License-Identifier: Apache-2.0
// The part of a scan job that measures what no nominal describes: find the section, feel its direction, go round it.
#include <utility>

#include "acquisition/scan_job.hpp"
#include "acquisition/unknown_scan.hpp"
#include "core/text.hpp"

namespace cmm::acquisition {
namespace {

// After a miss the next places lie farther round the edge that was overrun; a third would lie back beside the part.
constexpr std::size_t most_missed_predicted = 2;

/// Tells the live section how many points it will have, as soon as the path knows its last.
class ClosingSource final : public drivers::PathSource {
  public:
    ClosingSource(UnknownScan& scan, SampleIntake& intake, std::size_t before)
        : scan_(scan), intake_(intake), given_(before) {}
    std::size_t next(std::span<drivers::PathPoint> room, bool& last) override {
        const std::size_t count = scan_.next(room, last);
        given_ += count;
        if (last && intake_.section() != nullptr) intake_.section()->close_after(given_);
        return count;
    }

  private:
    UnknownScan& scan_;
    SampleIntake& intake_;
    std::size_t given_;
};

}  // namespace

boost::asio::awaitable<core::Result<Entry>> ScanJob::find_part() {
    const auto& scan = request_.part.scan;
    const double beside_mm = 0.3;
    for (const auto& line : touch_lines(plan_.paths[section_], request_.part, entry_)) {
        const auto where = co_await ready();
        if (!where) co_return tl::unexpected(where.error());
        Eigen::Vector3d from = *where;
        for (const auto& point : travel_route(plan_, *where, line.from)) {
            if (auto moved = co_await travel(from, point); !moved) co_return tl::unexpected(moved.error());
            from = point;
        }
        came_from_ = from;
        const auto found = co_await machine_.touch(line.to, plan_.approach_speed_mm_s, scan.approach_mm, *intake_);
        if (!found) {
            if (stop_requested_ || found.error().code != core::ErrorCode::machine_no_contact)
                co_return tl::unexpected(found.error());
            continue;
        }
        const Eigen::Vector2d direction = (line.to - line.from).head<2>().normalized();
        const Eigen::Vector3d step(-direction.y() * beside_mm, direction.x() * beside_mm, 0.0);
        const Eigen::Vector3d deeper(direction.x() * 2.0 * scan.approach_mm, direction.y() * 2.0 * scan.approach_mm,
                                     0.0);
        std::vector<Eigen::Vector2d> beside;
        for (const double side : {1.0, -1.0}) {
            const Eigen::Vector3d above = *found + side * step - 0.5 * deeper;
            came_from_ = *found - 0.5 * deeper;
            if (auto moved = co_await machine_.move(above, plan_.approach_speed_mm_s); !moved)
                co_return tl::unexpected(moved.error());
            came_from_ = above;
            const auto contact = co_await machine_.touch(*found + side * step + deeper, plan_.approach_speed_mm_s,
                                                         scan.approach_mm, *intake_);
            if (contact) {
                beside.emplace_back(contact->head<2>());
                continue;
            }
            if (contact.error().code != core::ErrorCode::machine_no_contact) co_return tl::unexpected(contact.error());
            if (auto where_now = co_await ready(); !where_now) co_return tl::unexpected(where_now.error());
            if (auto moved = co_await machine_.move(above, plan_.approach_speed_mm_s); !moved)
                co_return tl::unexpected(moved.error());
        }
        co_return Entry{*found, outward_normal(found->head<2>(), beside, direction)};
    }
    co_return core::fail(
        core::ErrorCode::machine_no_contact,
        "no part was found at z " + std::to_string(setups_[section_].z_mm) + " mm; give [scan] start_mm and toward_mm",
        core::Motion::stopped);
}

ScanJob::Step ScanJob::scan_unknown(drivers::ScanPath path) {
    const auto& restored = restored_[section_];
    std::vector<Eigen::Vector3d> measured;
    for (const auto& point : restored)
        measured.push_back(point.centre_mm);
    if (measured.empty()) {
        auto found = co_await find_part();
        if (!found) co_return tl::unexpected(found.error());
        entry_ = *found;
    } else {
        entry_ = entry_of(measured);
    }
    UnknownScan scan(unknown_scan_options(request_.part), entry_->contact_mm, entry_->outward);
    bool complete = false;
    for (const auto& point : restored) {
        drivers::PathPoint ignored;
        scan.next(std::span(&ignored, 1), complete);
        const bool no_contact = point.verdict.reason == fitting::RejectReason::no_contact;
        if (auto status = scan.on_sample(point.centre_mm, no_contact); !status) co_return status;
    }
    SampleIntake::Completed completed = [this](std::unique_ptr<LiveSection> section) {
        section_completed(std::move(section));
    };
    SampleIntake::Follower follower = [this, &scan](const core::Sample& sample) {
        return scan.on_sample(core::centre_mm(sample, capabilities_.lsb_mm),
                              (sample.flags & core::sample_flag::no_contact) != 0);
    };
    intake_->begin(path.id, new_section(section_), std::move(completed), std::move(follower));
    // The host was cut off between the last sample and the note that the section is there.
    if (complete) co_return core::Status{};
    ClosingSource source(scan, *intake_, restored.size());
    if (touching_) {
        const Missed note = [&scan](const drivers::PathPoint& place, std::size_t in_row) -> core::Status {
            if (in_row <= most_missed_predicted) return scan.on_sample(place.centre_mm, true);
            return core::fail(core::ErrorCode::machine_no_contact,
                              "the surface was lost: nothing to touch at " + std::to_string(in_row) +
                                  " places in a row, the last of them at x " + core::fixed(place.centre_mm.x(), 3) +
                                  ", y " + core::fixed(place.centre_mm.y(), 3) + " mm",
                              core::Motion::stopped);
        };
        co_return co_await touch_along(path.id, source, note);
    }
    auto scanned = co_await machine_.scan(path, source, *intake_);
    if (!scanned) co_return tl::unexpected(scanned.error());
    co_return core::Status{};
}

}  // namespace cmm::acquisition
