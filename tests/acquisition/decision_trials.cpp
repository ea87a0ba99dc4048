// SPDX-License-Identifier: Apache-2.0
#include "tests/acquisition/decision_trials.hpp"

#include <array>
#include <cmath>
#include <numbers>
#include <span>
#include <vector>

#include "acquisition/ball_path.hpp"
#include "acquisition/evaluation.hpp"
#include "acquisition/live_section.hpp"
#include "acquisition/section_setup.hpp"
#include "support/drawn_errors.hpp"
#include "support/section_truth.hpp"
#include "tests/acquisition/decision_subject.hpp"

namespace cmm::acquisition::decisions {
namespace {

using fitting::families::Blade;
using fitting::families::BladeScan;

/// Of the points before the path has come round.
std::vector<double> places_of(const Blade& blade, const PlannedPath& lap) {
    std::vector<double> places;
    for (const auto& point : std::span(lap.points).first(lap.points.size() - SamplingOptions().overlap))
        places.push_back(place_of(blade, point));
    return places;
}

/// What does not depend on the noise.
struct Subject {
    Blade blade;
    SectionSetup drawn, too_thick, too_thin;
    std::vector<double> places;
    double chord = 0.0, thickness = 0.0, stagger = 0.0;

    Subject(const Task& task, std::uint64_t seed)
        : blade(fitting::families::make(task.family, seed)),
          drawn(setup_of(blade, 0.0)),
          too_thick(setup_of(blade, half_zone_mm)),
          too_thin(setup_of(blade, -half_zone_mm)),
          places(places_of(blade, planned_lap(drawn, task.points))) {
        for (SectionSetup* const setup : {&drawn, &too_thick, &too_thin})
            setup->fields = fitting::ErrorFields(task.errors, 0.0);
        drawn.gate.characteristics.resize(1);
        drawn.gate.characteristics.front().kind = CharacteristicKind::stagger;
        drawn.gate.characteristics.front().label = "stagger";
        const fitting::section_truth::SectionTruth truth(fitting::section_truth::of_family(blade));
        chord = (truth.tail() - truth.nose()).norm();
        thickness = truth.thickest().diameter;
        stagger = truth.stagger();
    }
};

class Trials {
  public:
    explicit Trials(Table& table) : table_(table) {}

    void run(const Subject& subject, const fitting::families::ScanOptions& scanning,
             const fitting::drawn_errors::Machine& machine) {
        const Blade& blade = subject.blade;
        BladeScan plain = scan(blade, scanning);
        fitting::drawn_errors::displace(blade, machine, plain);
        const auto fit = fitting::fit_section(plain.points, {}, section_options(subject.drawn));
        sizes(subject, judged(plain, fit, subject.drawn));
        profiles(plain, fit, subject.too_thick, ", all of it outwards");
        profiles(plain, fit, subject.too_thin, ", all of it inwards");
        for (const auto& [width, where] : {std::pair{0.08, ", at one place"}, std::pair{0.02, ", at a narrow place"}}) {
            BladeScan swollen = plain;
            for (std::size_t i = 0; i < swollen.points.size(); ++i)
                swollen.points[i] += half_zone_mm * swelling(swollen.t[i], width) * blade.at(swollen.t[i]).normal();
            const auto swollen_fit = fitting::fit_section(swollen.points, {}, section_options(subject.drawn));
            profile_at_limit("profile_suction", where, judged(swollen, swollen_fit, subject.drawn));
            count_early(std::string("while measuring") + where, swollen, subject.drawn);
        }
    }

  private:
    static SectionResult judged(const BladeScan& scan, const core::Result<fitting::SectionFit>& fit,
                                const SectionSetup& setup) {
        SectionResult section;
        section.points = recorded(scan.points);
        return judge_fit(std::move(section), fit, setup);
    }

    void count(const std::string& name, Decision decision) { table_[name].count(decision); }

    /// The true value as the upper limit, and as the lower one.
    void size_at_limit(const std::string& name, const Characteristic* c, double truth) {
        if (c == nullptr || !c->value) {
            count(name + ", upper", Decision::not_evaluable);
            count(name + ", lower", Decision::not_evaluable);
            return;
        }
        const DecisionRule rule;
        const auto guards = rule.guards(*c->u95);
        measure(name + ", upper", *c->value - truth, guards.reject, *c->u95);
        count(name + ", upper", rule.decide(*c->value, guards, std::nullopt, truth));
        count(name + ", lower", rule.decide(*c->value, guards, truth, std::nullopt));
    }

    void sizes(const Subject& subject, const SectionResult& result) {
        size_at_limit("chord", result.find("chord"), subject.chord);
        size_at_limit("max_thickness", result.find("max_thickness"), subject.thickness);
        size_at_limit("le_radius", result.find("le_radius"), subject.blade.le().nose_radius());
        const auto* stagger = result.find("stagger");
        const double measured = stagger != nullptr ? stagger->value.value_or(0.0) : 0.0;
        size_at_limit("stagger", stagger,
                      measured + std::remainder(subject.stagger - measured, 2.0 * std::numbers::pi));
    }

    void measure(const std::string& name, double error, double guard, double u95) {
        Rates& rates = table_[name];
        ++rates.intervals;
        rates.held += std::abs(error) <= u95 ? 1 : 0;
        rates.error += error;
        rates.squares += error * error;
        rates.guard += guard;
    }

    void profile_at_limit(const std::string& name, const std::string& where, const SectionResult& result) {
        const auto* c = result.find(name);
        count(name + where, c != nullptr ? c->decision : Decision::not_evaluable);
        if (c == nullptr || !c->value) return;
        measure(name + where, *c->value - *c->upper, result.has_contour() ? *c->guard_reject : 0.0, *c->u95);
    }

    void profiles(const BladeScan& scan, const core::Result<fitting::SectionFit>& fit, const SectionSetup& setup,
                  const std::string& where) {
        const auto result = judged(scan, fit, setup);
        for (const char* name : {"profile_le", "profile_suction", "profile_te", "profile_pressure"})
            profile_at_limit(name, where, result);
        count_early("while measuring" + where, scan, setup);
    }

    void count_early(const std::string& name, const BladeScan& scan, const SectionSetup& setup) {
        LiveSection live(setup, 1.0, core::PartFromMachine(), scan.points.size());
        live.restore(recorded(scan.points));
        count(name, live.exceedance() ? Decision::reject : Decision::undecided);
    }

    Table& table_;
};

/// P(X <= count) of a binomial, by summing the logarithms' exponentials.
double binomial_cdf(std::size_t count, std::size_t trials, double share) {
    if (share <= 0.0) return 1.0;
    if (share >= 1.0) return count >= trials ? 1.0 : 0.0;
    const auto n = static_cast<double>(trials);
    double sum = 0.0;
    for (std::size_t k = 0; k <= count; ++k) {
        const auto i = static_cast<double>(k);
        sum += std::exp(std::lgamma(n + 1) - std::lgamma(i + 1) - std::lgamma(n - i + 1) + i * std::log(share) +
                        (n - i) * std::log1p(-share));
    }
    return sum;
}

template <class Above>
double bisect(const Above& above) {
    double low = 0.0, high = 1.0;
    for (int step = 0; step < 60; ++step) {
        const double middle = 0.5 * (low + high);
        (above(middle) ? high : low) = middle;
    }
    return 0.5 * (low + high);
}

}  // namespace

void Rates::count(Decision decision) {
    if (decision == Decision::not_evaluable || decision == Decision::reported) {
        ++refused;
        return;
    }
    ++trials;
    accepted += decision == Decision::accept ? 1 : 0;
    rejected += decision == Decision::reject ? 1 : 0;
}

void Rates::add(const Rates& other) {
    trials += other.trials;
    accepted += other.accepted;
    rejected += other.rejected;
    refused += other.refused;
    held += other.held;
    intervals += other.intervals;
    error += other.error;
    squares += other.squares;
    guard += other.guard;
}

std::vector<Table> run(const Task& task) {
    std::vector<Table> tables(task.sigmas_mm.size());
    for (std::uint64_t seed = task.first_seed; seed < task.first_seed + task.blades; ++seed) {
        const Subject subject(task, seed);
        for (std::size_t k = 0; k < tables.size(); ++k) {
            fitting::families::ScanOptions scanning;
            scanning.ball_mm = ball_mm;
            scanning.places = subject.places;
            scanning.sigma_mm = task.sigmas_mm[k];
            scanning.bad_share = task.bad_share;
            scanning.seed = 104729 * seed + k;
            core::Rng machines = core::Rng::keyed(seed, 0xDEC, k);
            Trials(tables[k]).run(subject, scanning, fitting::drawn_errors::draw(task.errors, machines));
        }
    }
    return tables;
}

std::pair<double, double> binomial_interval(std::size_t count, std::size_t trials, double outside) {
    const double tail = 0.5 * outside;
    if (trials == 0) return {0.0, 1.0};
    const double low =
        count == 0 ? 0.0 : bisect([&](double share) { return 1.0 - binomial_cdf(count - 1, trials, share) > tail; });
    const double high =
        count == trials ? 1.0 : bisect([&](double share) { return binomial_cdf(count, trials, share) < tail; });
    return {low, high};
}

}  // namespace cmm::acquisition::decisions
