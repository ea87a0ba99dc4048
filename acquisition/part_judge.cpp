// SPDX-License-Identifier: Apache-2.0
#include "acquisition/part_judge.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "fitting/closed_curve.hpp"
#include "fitting/contact_section.hpp"
#include "fitting/lean_by_sections.hpp"
#include "fitting/lean_of_nominal.hpp"
#include "fitting/surface_section.hpp"

namespace cmm::acquisition {
namespace {

using fitting::ContourPoint;

/// Sections that a growing surface is made of: what lies below them says nothing of the lean at its top.
constexpr std::size_t most_growing = 16;

std::vector<Eigen::Vector2d> positions(const std::vector<ContourPoint>& contour) {
    std::vector<Eigen::Vector2d> points;
    points.reserve(contour.size());
    for (const auto& point : contour)
        points.push_back(point.position_mm);
    return points;
}

/// Points that lie on the part need no compensation, and in the plane it is done already.
Compensation compensation_at_first(const SectionResult& section, const SectionSetup& setup) {
    Compensation out;
    out.asked = setup.fitting.compensation;
    if (out.asked == CompensationMethod::flat)
        out.note = "asked for";
    else if (section.has_contour() && setup.ball_radius_mm > 0.0)
        out.state = Compensation::State::provisional;
    return out;
}

/// Of what was measured.
double largest_distance(const std::vector<ContourPoint>& from, const std::vector<ContourPoint>& to) {
    const auto curve = fitting::ClosedCurve::through(positions(to));
    if (!curve) return 0.0;
    std::vector<fitting::ClosestPoint> feet(from.size());
    curve->closest(positions(from), feet);
    double largest = 0.0;
    for (std::size_t i = 0; i < from.size(); ++i)
        if (from[i].measured) largest = std::max(largest, std::abs(feet[i].distance_mm));
    return largest;
}

/// None where there is no nominal.
fitting::NominalNormal nominal_normal(const SectionSetup& setup) {
    if (!setup.nominal) return {};
    return [&reference = setup.nominal->reference](const Eigen::Vector2d& centre, const Eigen::Vector2d& outward) {
        return reference.touched_normal(centre, outward);
    };
}

/// What tells the lean where the sections do not: two of them do not say how the surface bends. None from the third on,
/// and where the nominal does not say which way it leans.
fitting::NominalNormal nominal_lean(const SectionSetup& setup, std::size_t sections) {
    const bool needed = sections <= 2 && setup.nominal && setup.nominal->reference.knows_lean();
    return needed ? nominal_normal(setup) : fitting::NominalNormal();
}

}  // namespace

SectionResult PartJudge::close(const SectionSetup& setup, std::vector<RecordedPoint> points) {
    auto closed = alone_.close(setup, std::move(points));
    closed.compensation = compensation_at_first(closed, setup);
    return closed;
}

bool PartJudge::changes_when_judged(const SectionResult& closed) {
    return closed.compensation.state == Compensation::State::provisional &&
           !fitting::needs_neighbours(closed.compensation.asked);
}

const SectionResult& PartJudge::finish(const SectionSetup& setup, std::vector<RecordedPoint> points) {
    return take_over(setup, judge_laid(close(setup, std::move(points)), setup));
}

const SectionResult& PartJudge::take_over(const SectionSetup& setup, SectionResult result) {
    const auto known = std::find_if(sections_.begin(), sections_.end(),
                                    [&](const auto& section) { return section->result.index == setup.index; });
    const auto place = static_cast<std::size_t>(known - sections_.begin());
    if (known == sections_.end()) sections_.push_back(std::make_unique<Judged>());
    Judged& judged = *sections_[place];
    judged = Judged{&setup, std::move(result), false, {}, {}, {}};
    judged.result.compensation = compensation_at_first(judged.result, setup);
    judged.has_ball = judged.result.compensation.state == Compensation::State::provisional;
    if (changes_when_judged(judged.result)) compensate_by_points(judged, {centre_row(judged)});
    return judged.result;
}

/// What a gap bridges tells nothing of the lean: the surface is made of sections that miss little, and none of an edge.
bool PartJudge::tells_lean(const Judged& judged) {
    const fitting::SectionFit& flat = judged.in_plane();
    return misses_little(flat) && std::none_of(flat.contour.begin(), flat.contour.end(), [](const ContourPoint& p) {
               return !p.measured && (p.zone == fitting::Zone::le || p.zone == fitting::Zone::te);
           });
}

fitting::CentreRow PartJudge::centre_row(const Judged& judged) {
    return {judged.result.z_mm, judged.in_plane().centres.points, judged.in_plane().noise_sigma_mm};
}

/// The surface says also of the other methods whether sections continue each other.
core::Status PartJudge::Stack::add(const Judged& judged) {
    const fitting::SectionFit& flat = judged.in_plane();
    auto status = surface.add(flat.centres.curve, judged.result.z_mm, flat.le_point_mm, flat.te_point_mm);
    if (status) members.push_back(&judged);
    return status;
}

core::Status PartJudge::Stack::fit() {
    if (members.size() < 2) return {};  // then each says itself why it stays flat
    const bool by_surface = members.back()->setup->fitting.compensation == CompensationMethod::surface;
    return by_surface ? surface.fit() : core::Status();
}

/// One that was judged a second time may have no centres any more; one with gaps is none of the members.
std::vector<fitting::CentreRow> PartJudge::Stack::rows_with(const Judged& judged) const {
    std::vector<fitting::CentreRow> rows;
    for (const Judged* const member : members)
        if (member->has_ball && member != &judged) rows.push_back(centre_row(*member));
    const auto above =
        std::find_if(rows.begin(), rows.end(), [&](const auto& row) { return row.z_mm > judged.result.z_mm; });
    rows.insert(above, centre_row(judged));
    return rows;
}

void PartJudge::stay_flat(Judged& judged, const core::Error& why) {
    judged.keep_flat();
    judged.result = judge_fit(std::move(judged.result), *judged.flat, *judged.setup);
    judged.result.compensation = {};
    judged.result.compensation.note = why.text();
    judged.result.compensation.asked = judged.setup->fitting.compensation;
}

void PartJudge::compensate_by_points(Judged& judged, const std::vector<fitting::CentreRow>& rows) {
    const SectionSetup& setup = *judged.setup;
    const CompensationMethod method = setup.fitting.compensation;
    const double z_mm = judged.result.z_mm;
    const auto row = std::find_if(rows.begin(), rows.end(), [&](const auto& r) { return r.z_mm == z_mm; });
    const auto contacts = fitting::contacts_by(method, rows, static_cast<std::size_t>(row - rows.begin()),
                                               setup.ball_radius_mm, nominal_normal(setup));
    if (!contacts) return stay_flat(judged, contacts.error());
    auto section = fitting::section_of_contacts(*contacts, z_mm, fitting::knows_lean(method), judged.in_plane(),
                                                section_options(setup));
    if (!section) return stay_flat(judged, section.error());
    Compensation how;
    how.state = Compensation::State::final;
    how.share = 1.0;
    how.asked = method;
    how.set_aside = section->set_aside;
    take_contour(judged, std::move(section->fit), std::move(how));
}

void PartJudge::take_contour(Judged& judged, fitting::SectionFit fit, Compensation how) {
    how.change_mm = largest_distance(fit.contour, judged.result.fit->contour);
    judged.keep_flat();
    how.from_flat_mm = largest_distance(fit.contour, judged.flat_contour());
    judged.result = judge_fit(std::move(judged.result), std::move(fit), *judged.setup);
    judged.result.compensation = std::move(how);
}

void PartJudge::compensate(Judged& judged, const Stack& stack) {
    if (judged.setup->fitting.compensation != CompensationMethod::surface)
        return compensate_by_points(judged, stack.rows_with(judged));
    const auto options = section_options(*judged.setup);
    const double z_mm = judged.result.z_mm;
    const auto rows = stack.surface.rows();
    const bool reached = stack.surface.centres() && z_mm >= rows.front().z_mm() && z_mm <= rows.back().z_mm();
    const auto nominal = nominal_lean(*judged.setup, rows.size());
    auto section = reached ? fitting::compensate_section(stack.surface, z_mm, judged.in_plane(), options, nominal)
                           : compensate_beside_others(judged, options);
    if (!section) return stay_flat(judged, section.error());
    Compensation how;
    how.state = Compensation::State::final;
    how.share = section->share;
    if (!reached) how.note = "by the sections beside it: none that go all round lie both above and below";
    take_contour(judged, std::move(section->fit), std::move(how));
}

/// Where the surface of the sections that go all round does not reach, or there is none.
core::Result<fitting::SurfaceSection> PartJudge::compensate_beside_others(
    const Judged& judged, const fitting::SectionOptions& options) const {
    std::vector<fitting::SectionInPlane> all{{judged.result.z_mm, &judged.in_plane()}};
    for (const Judged* const other : completion_->all)
        if (other != &judged) all.push_back({other->result.z_mm, &other->in_plane()});
    return fitting::compensate_by_sections(all, 0, options);
}

std::vector<const SectionResult*> PartJudge::grow() {
    if (sections_.empty()) return {};
    Judged& newest = *sections_.back();
    if (newest.result.compensation.state != Compensation::State::provisional || !tells_lean(newest)) return {};
    if (!growing_) growing_.emplace(Stack{fitting::SurfaceCompensation(newest.setup->ball_radius_mm, most_growing)});
    if (auto status = growing_->add(newest); !status) {
        stay_flat(newest, status.error());
        return {&newest.result};
    }
    Judged* const below = std::exchange(top_, &newest);
    if (below == nullptr) return {};
    if (auto status = growing_->fit(); !status) {
        stay_flat(*below, status.error());
    } else {
        compensate(*below, *growing_);
    }
    return {&below->result};
}

const SectionResult* PartJudge::foretell() {
    if (top_ == nullptr || top_ != sections_.back().get()) return nullptr;
    const SectionSetup& setup = *top_->setup;
    if (setup.fitting.compensation != CompensationMethod::surface) return nullptr;
    const fitting::SurfaceCompensation& surface = growing_->surface;
    const auto nominal = nominal_lean(setup, surface.rows().size());
    if (!surface.centres() && !nominal) return nullptr;
    const auto options = section_options(setup);
    auto section = surface.centres()
                       ? fitting::compensate_section(surface, top_->result.z_mm, top_->in_plane(), options, nominal)
                       : fitting::compensate_by_nominal(top_->in_plane(), options, nominal);
    if (!section) return nullptr;
    Compensation how;
    how.state = Compensation::State::provisional;
    how.share = section->share;
    take_contour(*top_, std::move(section->fit), std::move(how));
    return &top_->result;
}

bool PartJudge::rejects_for_certain(std::size_t index) const {
    const auto found = std::find_if(sections_.begin(), sections_.end(),
                                    [&](const auto& section) { return section->result.index == index; });
    if (found == sections_.end() || (*found)->result.decision() != Decision::reject) return false;
    const Judged& judged = **found;
    if (judged.result.compensation.state != Compensation::State::provisional) return true;
    if (!judged.setup->nominal) return false;
    return judge_fit(judged.result, judged.in_plane(), *judged.setup, nullptr, Lean::doubted).decision() ==
           Decision::reject;
}

bool PartJudge::has(std::size_t index) const {
    return std::any_of(sections_.begin(), sections_.end(),
                       [&](const auto& section) { return section->result.index == index; });
}

std::vector<SectionResult> PartJudge::results() const {
    std::vector<SectionResult> all;
    for (const auto& section : sections_)
        all.push_back(section->result);
    std::stable_sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.index < b.index; });
    return all;
}

/// All sections as one body, by their contours as they are now.
void PartJudge::align() {
    aligned_ = true;
    std::vector<AlignedMember> members;
    for (const Judged* const section : to_align_)
        members.push_back(
            {&*section->result.fit, &section->setup->nominal->section.curve(), reached(section->result.deviation_mm)});
    const auto& setup = *to_align_.front()->setup;
    auto found = align_blade(members, setup.alignment, {setup.gate.profile_mm, setup.gate.edge_profile_mm});
    for (std::size_t k = 0; k < to_align_.size(); ++k) {
        auto& alignment = to_align_[k]->alignment;
        if (found) {
            alignment = std::move((*found)[k]);
            if (!whole_) {
                alignment->alignment.state = Alignment::State::provisional;
                alignment->alignment.note = "by the sections that were measured";
            }
        } else {
            alignment.emplace();
            alignment->alignment.spec = setup.alignment;
            alignment->alignment.state = Alignment::State::refused;
            alignment->alignment.note = found.error().message;
        }
    }
}

const SectionResult* PartJudge::align_next() {
    if (to_align_.empty()) return nullptr;
    if (!aligned_) align();
    Judged& section = *to_align_.back();
    to_align_.pop_back();
    auto fit = std::move(*section.result.fit);
    section.result = judge_fit(std::move(section.result), std::move(fit), *section.setup, &*section.alignment);
    return &section.result;
}

std::vector<const SectionResult*> PartJudge::begin_completion(bool whole) {
    growing_.reset();
    top_ = nullptr;
    to_align_.clear();
    whole_ = whole;
    aligned_ = false;
    for (const auto& section : sections_) {
        // One that could not be laid onto the nominal even by itself stays as it is.
        const bool takes_part = section->setup->alignment.kind == AlignmentKind::blade &&
                                section->result.has_contour() && section->result.alignment.done();
        if (takes_part) to_align_.push_back(section.get());
    }
    std::stable_sort(to_align_.begin(), to_align_.end(),
                     [](const Judged* a, const Judged* b) { return a->result.z_mm > b->result.z_mm; });
    std::vector<Judged*> upwards;
    for (const auto& section : sections_)
        if (section->has_ball && fitting::needs_neighbours(section->setup->fitting.compensation))
            upwards.push_back(section.get());
    if (upwards.empty()) return {};
    for (Judged* const section : upwards)
        if (section->alone) section->flat = std::exchange(section->alone, std::nullopt);
    std::stable_sort(upwards.begin(), upwards.end(),
                     [](const Judged* a, const Judged* b) { return a->result.z_mm < b->result.z_mm; });
    std::vector<const SectionResult*> revised;
    auto laid = lay_stack(upwards, revised);
    if (laid && leave_out_strays()) laid = lay_stack(upwards, revised);
    if (laid) return revised;
    for (Judged* const section : std::exchange(completion_->left, {})) {
        stay_flat(*section, laid.error());
        revised.push_back(&section->result);
    }
    return revised;
}

/// The stack of all sections that tell the lean; those that do not continue it stay flat. Errors: those of its fit.
core::Status PartJudge::lay_stack(const std::vector<Judged*>& upwards, std::vector<const SectionResult*>& revised) {
    completion_.emplace(Completion{{fitting::SurfaceCompensation(upwards.front()->setup->ball_radius_mm)}, {}});
    revised.clear();
    std::vector<Judged*>& joined = completion_->left;
    for (Judged* const section : upwards) {
        if (!tells_lean(*section)) {
            joined.push_back(section);
        } else if (auto status = completion_->stack.add(*section); !status) {
            stay_flat(*section, status.error());
            revised.push_back(&section->result);
        } else {
            joined.push_back(section);
        }
    }
    std::reverse(joined.begin(), joined.end());
    completion_->all.assign(joined.begin(), joined.end());
    return completion_->stack.fit();
}

/// Bad points that only the other sections betray. A section that is rejected by itself stays as it is: points are not
/// left out to accept it. False when there are none.
bool PartJudge::leave_out_strays() {
    bool any = false;
    for (Judged* const section : completion_->left) {
        auto fit =
            fit_without_strays(completion_->stack.surface, *section->setup, section->result, section->in_plane());
        if (!fit) continue;
        if (judge_fit(section->result, section->in_plane(), *section->setup).decision() == Decision::reject) continue;
        section->alone = section->in_plane();
        section->flat = std::move(*fit);
        any = true;
    }
    return any;
}

const SectionResult* PartJudge::complete_next() {
    if (!completion_ || completion_->left.empty()) return align_next();
    Judged& section = *completion_->left.back();
    completion_->left.pop_back();
    compensate(section, completion_->stack);
    return &section.result;
}

std::vector<const SectionResult*> PartJudge::complete(bool whole) {
    auto revised = begin_completion(whole);
    while (const auto* section = complete_next())
        if (std::find(revised.begin(), revised.end(), section) == revised.end()) revised.push_back(section);
    return revised;
}

std::vector<SectionResult> PartJudge::take() {
    std::vector<SectionResult> results;
    for (auto& section : sections_)
        results.push_back(std::move(section->result));
    sections_.clear();
    growing_.reset();
    completion_.reset();
    to_align_.clear();
    top_ = nullptr;
    std::stable_sort(results.begin(), results.end(), [](const auto& a, const auto& b) { return a.index < b.index; });
    return results;
}

}  // namespace cmm::acquisition
