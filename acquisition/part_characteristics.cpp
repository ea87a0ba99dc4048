// SPDX-License-Identifier: Apache-2.0
#include "acquisition/part_characteristics.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "acquisition/asked_characteristics.hpp"
#include "acquisition/evaluation.hpp"
#include "core/error.hpp"

namespace cmm::acquisition {
namespace {

using Kind = CharacteristicKind;

constexpr double coverage_95 = 2.0;
constexpr double sure_of_direction = 3.0;  // standard uncertainties: nearer to none a distance answers in any direction

constexpr const char* one_section = "root and tip are the same section";

/// What is independent from section to section, standard, and how much of it the machine does place by place; and what
/// all sections have in common.
struct Number {
    double value = 0.0, standard = 0.0;
    double places = 0.0;  // variance
    fitting::FieldLoads loads = fitting::FieldLoads::Zero();

    Number times(double factor) const {
        return {factor * value, factor * standard, factor * factor * places, factor * loads};
    }
};

tl::unexpected<core::Error> missing(const std::string& why) {
    return core::fail(core::ErrorCode::fit_not_evaluable, why);
}

const char* part_method(Kind kind) {
    switch (kind) {
        case Kind::lean_x:
        case Kind::lean_y:
            return "LEAN: displacement (BESTFIT) of the tip less that of the root";
        case Kind::bow_x:
        case Kind::bow_y:
            return "BOW: displacement (BESTFIT) from the straight line between root and tip";
        case Kind::bow_true_position:
            return "BOWT: 2 sqrt(bow_x^2 + bow_y^2)";
        case Kind::relative_twist:
            return "TWIST (BESTFIT) less that of the reference section";
        default:
            return "GENERATRIX: band of the deviations along the span at one place of the side, about their straight "
                   "line";
    }
}

class PartMeasures {
  public:
    explicit PartMeasures(const PartResult& part) : part_(part) {
        for (const auto& section : part.sections)
            upwards_.push_back(&section);
        std::stable_sort(upwards_.begin(), upwards_.end(),
                         [](const auto* a, const auto* b) { return a->z_mm < b->z_mm; });
    }

    std::optional<std::size_t> root(const CharacteristicSpec& spec) const {
        if (spec.root) return spec.root;
        return upwards_.empty() ? std::nullopt : std::optional(upwards_.front()->index);
    }
    std::optional<std::size_t> tip(const CharacteristicSpec& spec) const {
        if (spec.tip) return spec.tip;
        return upwards_.empty() ? std::nullopt : std::optional(upwards_.back()->index);
    }

    core::Result<Number> lean(const CharacteristicSpec& spec) const {
        const auto a = placed(root(spec), spec), b = placed(tip(spec), spec);
        if (!a) return tl::unexpected(a.error());
        if (!b) return tl::unexpected(b.error());
        if (!(std::abs(b->z_mm - a->z_mm) > 0.0)) return missing(one_section);
        const Eigen::Index axis = spec.kind == Kind::lean_x ? 0 : 1;
        const auto &from = a->placement, &to = b->placement;
        // A tilt of the part's frame leans both the same way; twist and bow do not feel it.
        double tilt_mm = 0.0;
        if (part_.part_frame) {
            // What the frame has in common with the sections stands in their loads.
            const Eigen::Index turn = axis == 0 ? 4 : 3;
            tilt_mm = (b->z_mm - a->z_mm) * std::sqrt(std::max(0.0, part_.part_frame->covariance(turn, turn)));
        }
        return Number{to.shift_mm[axis] - from.shift_mm[axis],
                      std::sqrt(from.covariance(axis, axis) + to.covariance(axis, axis) + tilt_mm * tilt_mm),
                      from.places(axis, axis) + to.places(axis, axis),
                      (to.loads.row(axis) - from.loads.row(axis)).transpose()};
    }

    core::Result<Number> bow(const CharacteristicSpec& spec, std::size_t section) const {
        const auto a = placed(root(spec), spec), b = placed(tip(spec), spec), c = placed(section, spec);
        for (const auto* one : {&a, &b, &c})
            if (!*one) return tl::unexpected(one->error());
        const double span = b->z_mm - a->z_mm;
        if (!(std::abs(span) > 0.0)) return missing(one_section);
        const double share = (c->z_mm - a->z_mm) / span;
        const auto &low = a->placement, &high = b->placement, &here = c->placement;
        const Eigen::Vector2d off = here.shift_mm - (1.0 - share) * low.shift_mm - share * high.shift_mm;
        const Eigen::Matrix2d covariance =
            in_plane(here) + std::pow(1.0 - share, 2) * in_plane(low) + share * share * in_plane(high);
        const Eigen::Matrix2d places = here.places.topLeftCorner<2, 2>() +
                                       std::pow(1.0 - share, 2) * low.places.topLeftCorner<2, 2>() +
                                       share * share * high.places.topLeftCorner<2, 2>();
        const Eigen::Matrix<double, 2, fitting::error_fields> loads =
            (here.loads - (1.0 - share) * low.loads - share * high.loads).topRows<2>();
        const auto along = [&](const Eigen::Vector2d& direction, double value) {
            return Number{value, std::sqrt(direction.dot(covariance * direction)), direction.dot(places * direction),
                          loads.transpose() * direction};
        };
        if (spec.kind == Kind::bow_x) return along(Eigen::Vector2d::UnitX(), off.x());
        if (spec.kind == Kind::bow_y) return along(Eigen::Vector2d::UnitY(), off.y());
        const double distance = off.norm();
        const auto random = loads.leftCols<fitting::error_fields - 1>();
        const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> all(covariance + random * random.transpose());
        if (distance >= sure_of_direction * std::sqrt(all.eigenvalues()[1]))
            return along(off / distance, distance).times(2.0);
        Number out = along(all.eigenvectors().col(1), distance);
        out.standard = std::sqrt(
            Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(covariance, Eigen::EigenvaluesOnly).eigenvalues()[1]);
        return out.times(2.0);
    }

    core::Result<Number> relative_twist(const CharacteristicSpec& spec, std::size_t section) const {
        const auto a = placed(spec.reference_section ? spec.reference_section : root(spec), spec),
                   b = placed(section, spec);
        if (!a) return tl::unexpected(a.error());
        if (!b) return tl::unexpected(b.error());
        const auto &from = a->placement, &to = b->placement;
        return Number{to.turn_rad - from.turn_rad, std::sqrt(from.covariance(2, 2) + to.covariance(2, 2)),
                      from.places(2, 2) + to.places(2, 2), (to.loads.row(2) - from.loads.row(2)).transpose()};
    }

    core::Result<Number> generatrix(const CharacteristicSpec& spec) const {
        std::vector<const SpanPoint*> points;
        std::vector<double> heights;
        for (const auto* section : upwards_) {
            if (!spec.is_of(section->index)) continue;
            const auto at = std::find_if(section->span_points.begin(), section->span_points.end(),
                                         [&](const SpanPoint& point) { return point.label == spec.label; });
            if (at == section->span_points.end())
                return missing(section_text(section->index, section->z_mm) + " has no point there");
            points.push_back(&*at);
            heights.push_back(section->z_mm);
        }
        const auto n = static_cast<Eigen::Index>(points.size());
        if (n < 3) return missing("it takes three sections");
        Eigen::MatrixXd line(n, 2);
        Eigen::VectorXd deviation(n);
        for (Eigen::Index k = 0; k < n; ++k) {
            line.row(k) << 1.0, heights[static_cast<std::size_t>(k)];
            deviation[k] = points[static_cast<std::size_t>(k)]->deviation_mm;
        }
        const Eigen::MatrixXd left =
            Eigen::MatrixXd::Identity(n, n) - line * (line.transpose() * line).inverse() * line.transpose();
        const Eigen::VectorXd residual = left * deviation;
        Eigen::Index high = 0, low = 0;
        const double band = residual.maxCoeff(&high) - residual.minCoeff(&low);
        Number out{band};
        double variance = 0.0;
        for (Eigen::Index k = 0; k < n; ++k) {
            const SpanPoint& point = *points[static_cast<std::size_t>(k)];
            const double weight = left(high, k) - left(low, k);
            variance += std::pow(weight * std::hypot(point.scatter_mm, point.place_mm), 2);
            out.places += std::pow(weight * point.place_mm, 2);
            out.loads += weight * point.loads;
        }
        out.standard = std::sqrt(variance);
        return out;
    }

  private:
    static Eigen::Matrix2d in_plane(const SectionPlacement& placement) {
        return placement.covariance.topLeftCorner<2, 2>();
    }

    struct Placed {
        double z_mm;
        SectionPlacement placement;
    };
    core::Result<Placed> placed(const std::optional<std::size_t>& index, const CharacteristicSpec& spec) const {
        const auto found = std::find_if(part_.sections.begin(), part_.sections.end(),
                                        [&](const SectionResult& section) { return index && section.index == *index; });
        if (found == part_.sections.end())
            return missing("section " + (index ? std::to_string(*index) : std::string("of the root")) +
                           " was not measured");
        const auto* placement = found->placement(spec.fit_zones);
        if (placement == nullptr)
            return missing(section_text(found->index, found->z_mm) + ": " +
                           (found->why.empty() ? "it could not be laid onto its nominal" : found->why));
        return Placed{found->z_mm, *placement};
    }

    const PartResult& part_;
    std::vector<const SectionResult*> upwards_;
};

fitting::ErrorBudget budget_of(const Number& number) {
    fitting::ErrorBudget budget;
    budget.noise = std::sqrt(std::max(0.0, number.standard * number.standard - number.places));
    for (std::size_t k = 0; k < fitting::error_sources; ++k)
        budget.machine[k] = std::sqrt(fitting::variance_of(number.loads, static_cast<fitting::ErrorSource>(k)));
    double& length = budget.of(fitting::ErrorSource::length);
    length = std::hypot(length, std::sqrt(number.places));
    budget.bound = std::abs(fitting::known_of(number.loads));
    return budget;
}

/// `with_machine`: something is known of it.
Characteristic made(const CharacteristicSpec& spec, const core::Result<Number>& number, const DecisionRule& rule,
                    bool with_machine) {
    Characteristic c;
    c.name = spec.label;
    c.method = part_method(spec.kind) + fit_zone_words(spec);
    c.unit = unit_of(spec.kind);
    c.nominal = nominal_without_section(spec);
    set_limits(spec, c);
    if (number) {
        c.value = number->value;
        c.u95 = coverage_95 * std::hypot(number->standard, std::sqrt(fitting::variance_of(number->loads))) +
                std::abs(fitting::known_of(number->loads));
        if (with_machine) c.budget = budget_of(*number);
        decide(c, rule);
    } else {
        c.decision = Decision::not_evaluable;
        c.note = number.error().message;
    }
    return c;
}

/// What is asked of sections that there are not: nobody else says that it was not judged.
void add_missing_sections(const CharacteristicSpec& spec, PartResult& part) {
    std::string missing;
    for (const std::size_t index : spec.sections)
        if (std::none_of(part.sections.begin(), part.sections.end(),
                         [&](const SectionResult& section) { return section.index == index; }))
            missing += (missing.empty() ? "section " : ", ") + std::to_string(index);
    if (missing.empty()) return;
    Characteristic c;
    c.name = spec.label;
    c.method = std::string(to_string(spec.kind));
    c.unit = unit_of(spec.kind);
    c.nominal = nominal_without_section(spec);
    set_limits(spec, c);
    c.decision = Decision::not_evaluable;
    c.note = missing + ": there is no such section; they count from 0";
    part.characteristics.push_back({std::move(c), std::nullopt});
}

}  // namespace

void add_part_characteristics(const std::vector<CharacteristicSpec>& asked, const DecisionRule& rule,
                              PartResult& part) {
    part.characteristics.clear();
    const PartMeasures measures(part);
    const bool with_machine = part.uncertainty.errors().any();
    for (const auto& spec : asked) {
        if (part.complete) add_missing_sections(spec, part);
        if (!is_of_part(spec.kind)) continue;
        const auto add = [&](std::optional<std::size_t> section, core::Result<Number> number) {
            if (!part.complete) number = missing("not all sections are measured");
            part.characteristics.push_back({made(spec, number, rule, with_machine), section});
        };
        if (spec.kind == Kind::lean_x || spec.kind == Kind::lean_y) {
            add(std::nullopt, measures.lean(spec));
        } else if (spec.kind == Kind::generatrix) {
            add(std::nullopt, measures.generatrix(spec));
        } else {
            const bool twist = spec.kind == Kind::relative_twist;
            const auto root = twist && spec.reference_section ? spec.reference_section : measures.root(spec);
            const auto tip = twist ? std::nullopt : measures.tip(spec);
            // Of the ends themselves it is nought by definition.
            const auto is_end = [&](const SectionResult& section) {
                return section.index == root || section.index == tip;
            };
            if (std::all_of(part.sections.begin(), part.sections.end(), is_end))
                add(std::nullopt, missing(twist ? "no section beside that of reference was measured"
                                                : "no section between root and tip was measured"));
            for (const auto& section : part.sections) {
                if (!spec.is_of(section.index) || is_end(section)) continue;
                add(section.index,
                    twist ? measures.relative_twist(spec, section.index) : measures.bow(spec, section.index));
            }
        }
    }
}

}  // namespace cmm::acquisition
