// SPDX-License-Identifier: Apache-2.0
#include "acquisition/gauge_study.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "acquisition/listed_characteristic.hpp"

namespace cmm::acquisition {
namespace {

constexpr double coverage = 2.0;  // of U95
constexpr std::size_t fewest_trials = 2;

tl::unexpected<core::Error> refused(const std::string& why) {
    return core::fail(core::ErrorCode::input_invalid, why);
}

std::size_t place_in(std::vector<std::string>& names, const std::string& name) {
    const auto found = std::find(names.begin(), names.end(), name);
    if (found != names.end()) return static_cast<std::size_t>(found - names.begin());
    names.push_back(name);
    return names.size() - 1;
}

/// A profile's zone begins at 0; one limit alone is no width.
std::optional<double> width_of(const Characteristic& one) {
    if (one.lower && one.upper) return *one.upper - *one.lower;
    return one.upper && one.name.starts_with("profile_") ? one.upper : std::nullopt;
}

bool asks_the_same(const Characteristic& a, const Characteristic& b) {
    return a.method == b.method && a.unit == b.unit && width_of(a) == width_of(b);
}

/// Checks the runs and knows where each of them stands in the design.
class Design {
  public:
    explicit Design(const std::vector<StudyRun>& runs) : runs_(runs) {}

    core::Status check(GaugeStudy& study) {
        if (runs_.empty()) return refused("a study needs runs");
        std::set<std::string> seen;
        for (const auto& run : runs_) {
            if (!seen.insert(run.run_id).second) return refused("run " + run.run_id + " is named twice");
            if (run.part_name != runs_.front().part_name || run.plan != runs_.front().plan)
                return refused("run " + run.run_id + " (" + run.part_name + ") has another part program than run " +
                               runs_.front().run_id + " (" + runs_.front().part_name + ")");
            if (run.part.empty())
                return refused("run " + run.run_id +
                               " does not say which part it measured: give [part] serial, or a design file");
            if (run.appraiser.empty())
                return refused("run " + run.run_id + " does not say who measured: name that in a design file");
            places_.push_back({place_in(study.parts, run.part), place_in(study.appraisers, run.appraiser), 0.0});
        }
        study.part_name = runs_.front().part_name;
        study.runs = runs_.size();
        return count(study);
    }

    /// A characteristic as the first run with a value has it, and a run that has another one under its name.
    struct Asked {
        const Characteristic* sample;
        std::string differs;
    };
    std::vector<Asked> asked() const {
        std::vector<Asked> all;
        for (const auto& run : runs_)
            for (const auto& one : run.characteristics) {
                const auto same = std::find_if(all.begin(), all.end(),
                                               [&](const Asked& known) { return known.sample->name == one.name; });
                if (same == all.end()) {
                    all.push_back({&one, {}});
                } else if (one.value && !same->sample->value) {
                    same->sample = &one;  // what is not evaluable may say neither method nor limits
                } else if (one.value && !asks_the_same(one, *same->sample) && same->differs.empty()) {
                    same->differs = run.run_id + " (" + one.method + ")";
                }
            }
        return all;
    }

    StudyCharacteristic one(const GaugeStudy& study, const std::string& name) const {
        StudyCharacteristic out;
        out.name = name;
        std::vector<StudyValue> all;
        std::vector<double> declared;
        for (std::size_t k = 0; k < runs_.size(); ++k) {
            const auto* found = find(runs_[k], name);
            if (found == nullptr || !found->value) continue;
            all.push_back(places_[k]);
            all.back().value = *found->value;
            // What the machine shares between runs shows in none of their differences.
            if (found->budget)
                declared.push_back(found->budget->noise + found->budget->bound / coverage);
            else if (found->u95)
                declared.push_back(*found->u95 / coverage);
        }
        out.missing = runs_.size() - all.size();
        balance(study, std::move(all), out);
        if (!declared.empty()) {
            double squares = 0.0;
            for (const double standard : declared)
                squares += standard * standard;
            out.declared = std::sqrt(squares / static_cast<double>(declared.size()));
        }
        return out;
    }

    static const Characteristic* find(const StudyRun& run, const std::string& name) {
        const auto found = std::find_if(run.characteristics.begin(), run.characteristics.end(),
                                        [&](const Characteristic& c) { return c.name == name; });
        return found == run.characteristics.end() ? nullptr : &*found;
    }

  private:
    core::Status count(GaugeStudy& study) const {
        std::vector<std::size_t> counts(study.parts.size() * study.appraisers.size(), 0);
        for (const auto& at : places_)
            ++counts[at.part * study.appraisers.size() + at.appraiser];
        const auto [fewest, most] = std::minmax_element(counts.begin(), counts.end());
        study.fewest = *fewest;
        study.most = *most;
        if (*fewest >= fewest_trials) return {};
        const auto cell = static_cast<std::size_t>(fewest - counts.begin());
        return refused("part " + study.parts[cell / study.appraisers.size()] + " was measured " +
                       std::to_string(*fewest) + (*fewest == 1 ? " time by " : " times by ") +
                       study.appraisers[cell % study.appraisers.size()] +
                       ": every appraiser has to measure every part twice at least, best all of them equally often");
    }

    /// As many values of each part and appraiser as all of them have.
    static void balance(const GaugeStudy& study, std::vector<StudyValue> all, StudyCharacteristic& out) {
        const std::size_t appraisers = study.appraisers.size();
        std::vector<std::size_t> have(study.parts.size() * appraisers, 0);
        for (const auto& value : all)
            ++have[value.part * appraisers + value.appraiser];
        const auto fewest = std::min_element(have.begin(), have.end());
        if (*fewest < fewest_trials) {
            const auto cell = static_cast<std::size_t>(fewest - have.begin());
            out.why = std::to_string(*fewest) + (*fewest == 1 ? " value" : " values") + " of part " +
                      study.parts[cell / appraisers] + " by " + study.appraisers[cell % appraisers];
            out.values = std::move(all);
            return;
        }
        out.trials = *fewest;
        GaugeValues values(study.parts.size(), appraisers, out.trials);
        std::fill(have.begin(), have.end(), 0);
        for (const auto& value : all) {
            auto& trial = have[value.part * appraisers + value.appraiser];
            if (trial == out.trials) {
                ++out.left_out;
                continue;
            }
            values.at(value.part, value.appraiser, trial++) = value.value;
            out.values.push_back(value);
        }
        out.components = analyse_gauge(values);
    }

    const std::vector<StudyRun>& runs_;
    std::vector<StudyValue> places_;  // of the runs, without values
};

}  // namespace

StudyRun study_run(const PartResult& result, const std::string& plan, const std::string& part,
                   const std::string& appraiser) {
    StudyRun run{part, appraiser, result.run_id, result.started_utc, result.part_name, plan, {}};
    for (const auto& [name, number] : all_characteristics(result)) {
        run.characteristics.push_back(*number);
        run.characteristics.back().name = name;
    }
    return run;
}

std::optional<double> StudyCharacteristic::observed_to_declared() const {
    if (!components || !declared || *declared <= 0.0) return std::nullopt;
    return components->repeatability.deviation / *declared;
}

core::Result<GaugeStudy> make_gauge_study(std::vector<StudyRun> runs) {
    std::stable_sort(runs.begin(), runs.end(),
                     [](const StudyRun& a, const StudyRun& b) { return a.started_utc < b.started_utc; });
    GaugeStudy study;
    Design design(runs);
    if (auto status = design.check(study); !status) return tl::unexpected(status.error());
    for (const auto& asked : design.asked()) {
        auto found = design.one(study, asked.sample->name);
        found.method = asked.sample->method;
        found.unit = asked.sample->unit;
        found.tolerance = width_of(*asked.sample);
        if (!asked.differs.empty()) {
            found.components.reset();
            found.why = "another method or tolerance in run " + asked.differs;
        }
        study.characteristics.push_back(std::move(found));
    }
    return study;
}

}  // namespace cmm::acquisition
