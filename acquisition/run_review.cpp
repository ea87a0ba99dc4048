// SPDX-License-Identifier: Apache-2.0
#include "acquisition/run_review.hpp"

#include <algorithm>
#include <utility>

#include "acquisition/part_characteristics.hpp"
#include "acquisition/part_judge.hpp"
#include "acquisition/recorded_machine.hpp"
#include "acquisition/traceability.hpp"

namespace cmm::acquisition {
namespace {

core::Result<PartFile> kept_part(const Journal::Header& header, const std::string& run_file) {
    auto part = parse_part_file(header.part_text, header.part_path);
    if (!part) return tl::unexpected(std::move(part.error()).with_context("the part file kept in " + run_file));
    return part;
}

}  // namespace

core::Result<PartFile> part_of_run(const std::string& run_file) {
    const auto journal = Journal::read(run_file);
    if (!journal) return tl::unexpected(journal.error());
    return kept_part((*journal)->header(), run_file);
}

RunReview::RunReview(std::unique_ptr<Journal> journal, PartFile part, std::shared_ptr<const Nominal> nominal)
    : journal_(std::move(journal)), part_(std::move(part)), sources_(sources_of(part_)), nominal_(std::move(nominal)) {
    // The ball that measured, whatever a second part file says.
    part_.stylus.radius_mm = journal_->header().ball_radius_mm;
    part_.uncertainty.machine = recorded_errors(journal_->header());
}

core::Result<std::unique_ptr<RunReview>> RunReview::open(const std::string& run_file, const PartFile* part) {
    auto journal = Journal::read(run_file);
    if (!journal) return tl::unexpected(journal.error());
    auto used = part != nullptr ? core::Result<PartFile>(*part) : kept_part((*journal)->header(), run_file);
    if (!used) return tl::unexpected(used.error());
    auto nominal = load_nominal(used->nominal);
    if (!nominal) return tl::unexpected(nominal.error());
    std::unique_ptr<RunReview> review(new RunReview(std::move(*journal), std::move(*used), std::move(*nominal)));
    if (auto status = review->refresh(); !status) return tl::unexpected(status.error());
    return review;
}

void RunReview::choose(OperatorChoice choice) {
    choice_ = std::move(choice);
    judged_.clear();
    compensated_.clear();
}

/// The plan's where the part file has it, else the mean of the points.
double RunReview::height_mm(std::size_t index) const {
    if (index < part_.scan.heights_mm.size()) return part_.scan.heights_mm[index];
    const auto& all = recorded_.all();
    const auto found = std::find_if(all.begin(), all.end(), [&](const auto& known) { return known.index == index; });
    if (found == all.end() || found->points.empty()) return 0.0;
    double sum = 0.0;
    for (const auto& point : found->points)
        sum += point.centre_mm.z();
    return sum / static_cast<double>(found->points.size());
}

core::Result<const SectionSetup*> RunReview::setup(std::size_t index) {
    const auto known = setups_.find(index);
    // Asked for while the datum points of a running measurement are still being touched, it knows no frame yet.
    const bool waits = known != setups_.end() && part_.alignment.six_points && !known->second.frame;
    if (known != setups_.end() && !waits) return &known->second;
    const auto frame = part_frame();
    if (!frame) return tl::unexpected(frame.error());
    if (waits && !*frame) return &known->second;
    auto made = make_section_setup(part_, nominal_.get(), index, height_mm(index));
    if (!made) return tl::unexpected(made.error());
    if (*frame) take_frame(*made, **frame);
    return &setups_.insert_or_assign(index, std::move(*made)).first->second;
}

core::Result<std::optional<PartFrame>> RunReview::part_frame() const {
    const auto numbers = journal_->part_frame();
    if (!numbers) return tl::unexpected(numbers.error());
    auto frame = frame_from_numbers(*numbers);
    if (frame && *frame) **frame = with_errors(std::move(**frame), part_.uncertainty.errors());
    return frame;
}

bool RunReview::whole() const {
    const auto& sections = recorded_.all();
    return sections.size() == part_.scan.heights_mm.size() &&
           std::all_of(sections.begin(), sections.end(), [](const auto& one) { return one.finished; });
}

/// A section of which a part is missing may be one that is being measured: what is made of it so far is nothing that
/// the others should rest on, or be judged anew for with every point.
bool RunReview::takes_part(std::size_t place, Taken taken) const {
    const SectionResult& alone = judged_[place].result;
    return alone.has_contour() && (alone.all_round() || taken == Taken::all || recorded_.all()[place].finished);
}

core::Status RunReview::judge_all(Taken taken) {
    const auto& sections = recorded_.all();
    for (std::size_t i = 0; i < sections.size(); ++i) {
        const bool known = i < judged_.size() && judged_[i].result.index == sections[i].index &&
                           judged_[i].points == sections[i].points.size();
        if (known) continue;
        for (std::size_t later = i; later < judged_.size(); ++later)
            if (judged_[later].takes_part) compensated_all_ = false;
        judged_.resize(i);  // without a nominal the edges of later sections follow those of earlier ones
        const auto of_section = setup(sections[i].index);
        if (!of_section) return tl::unexpected(of_section.error());
        auto points = sections[i].points;
        choice_.apply(points);
        Judged judged;
        if (i > 0) judged.judge = judged_[i - 1].judge;
        judged.points = points.size();
        judged.result = judged.judge.finish(**of_section, std::move(points));
        judged_.push_back(std::move(judged));
    }
    for (std::size_t place = 0; place < judged_.size(); ++place)
        if (const bool takes = takes_part(place, taken); std::exchange(judged_[place].takes_part, takes) != takes)
            compensated_all_ = false;
    if (compensated_whole_ != whole() && part_.alignment.kind == AlignmentKind::blade) compensated_all_ = false;
    compensated_whole_ = whole();
    if (std::exchange(compensated_all_, true)) return {};
    PartJudge judge;
    for (std::size_t place = 0; place < judged_.size(); ++place)
        if (judged_[place].takes_part) judge.take_over(setups_.at(judged_[place].result.index), judged_[place].result);
    judge.complete(compensated_whole_);
    compensated_ = judge.take();
    return {};
}

const SectionResult& RunReview::at(std::size_t place) const {
    const auto& alone = judged_[place].result;
    const auto found = std::find_if(compensated_.begin(), compensated_.end(),
                                    [&](const SectionResult& result) { return result.index == alone.index; });
    return judged_[place].takes_part ? *found : alone;
}

core::Result<const SectionResult*> RunReview::result_at(std::size_t place) {
    if (auto status = judge_all(Taken::finished); !status) return tl::unexpected(status.error());
    return &at(place);
}

core::Result<PartResult> RunReview::result() {
    if (auto status = judge_all(Taken::all); !status) return tl::unexpected(status.error());
    const auto frame = part_frame();
    if (!frame) return tl::unexpected(frame.error());
    const auto& header = journal_->header();
    PartResult result;
    result.part_frame = *frame;
    result.part_name = part_.name;
    result.part_serial = part_.serial;
    result.started_utc = header.started_utc;
    result.machine = header.machine_model + " " + header.machine_serial + " (" + header.machine_url + ")";
    result.run_id = header.run_id;
    result.software_version = header.software_version;
    result.sources = sources_;
    result.plan_hash = header.plan_hash;
    result.ball_radius_mm = header.ball_radius_mm;
    result.has_nominal = has_nominal();
    result.decision_rule = part_.gate.rule.worded();
    result.uncertainty = part_.uncertainty;
    const auto& sections = recorded_.all();
    result.complete = whole();
    for (std::size_t place = 0; place < sections.size(); ++place)
        result.sections.push_back(at(place));
    add_part_characteristics(part_.gate.characteristics, part_.gate.rule, result);
    if (auto status = choice_.all_found(); !status) return tl::unexpected(status.error());
    return result;
}

core::Result<PartResult> results_of_run(const std::string& run_file, const PartFile* part, OperatorChoice choice) {
    auto review = RunReview::open(run_file, part);
    if (!review) return tl::unexpected(review.error());
    (*review)->choose(std::move(choice));
    return (*review)->result();
}

}  // namespace cmm::acquisition
