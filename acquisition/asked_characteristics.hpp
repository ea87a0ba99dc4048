// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>

#include "acquisition/characteristic_spec.hpp"
#include "acquisition/decision_rule.hpp"
#include "acquisition/nominal_measures.hpp"
#include "acquisition/section_result.hpp"
#include "fitting/best_fit.hpp"
#include "fitting/datum.hpp"
#include "fitting/measured_section.hpp"
#include "fitting/nominal.hpp"

namespace cmm::acquisition {

/// Makes the characteristics that a part file asks for, of a closed section; one that cannot be evaluated says why.
/// The best fit, which several of them need, is made once, when it is first asked for. The section and what is given
/// must outlive it; one owner.
class AskedCharacteristics {
  public:
    /// `measures`: of the nominal, for all that `make` will be asked for; with a nominal. `form`: the deviation profile
    /// of a zone after the best fit, given how points go to the nominal's frame; only called with a nominal.
    /// `deviation_mm`: as of the result, empty without a nominal. `datum`: by which the section was carried into the
    /// nominal's frame, where it was; outlives this.
    using FormProfile = std::function<Characteristic(const CharacteristicSpec&, const fitting::BestFit&)>;
    AskedCharacteristics(fitting::MeasuredSection& section, std::span<const std::optional<double>> deviation_mm,
                         const fitting::NominalSection* nominal, const NominalMeasures* measures, FormProfile form,
                         const DecisionRule& rule, const fitting::Datum* datum = nullptr);

    /// Where the section lies to its nominal; none where there is no best fit.
    std::optional<SectionPlacement> placement(const ZoneSet& zones);
    /// `known`: what is judged in any case; a radius is taken from there.
    Characteristic make(const CharacteristicSpec& spec, const SectionResult& known);

  private:
    const core::Result<fitting::BestFit>& best_fit(const ZoneSet& zones);
    core::Result<double> nominal_of(const CharacteristicSpec& spec) const;
    Characteristic curvature(const CharacteristicSpec& spec);
    Characteristic radius_in_window(const CharacteristicSpec& spec);
    fitting::NumberUncertainty uncertainty(const fitting::Measure& measure) const;
    Characteristic by_best_fit(const CharacteristicSpec& spec);
    void require(const CharacteristicSpec& spec, Characteristic& c);

    fitting::MeasuredSection& section_;
    std::span<const std::optional<double>> deviation_mm_;
    const fitting::NominalSection* nominal_;
    const NominalMeasures* measures_;
    FormProfile form_;
    DecisionRule rule_;
    const fitting::Datum* datum_;
    std::map<ZoneSet, core::Result<fitting::BestFit>> best_fits_;  // by the zones that take part
};

/// "; best fit of suction pressure", where not all zones take part.
std::string fit_zone_words(const CharacteristicSpec& spec);
/// The requirement of `spec` and, where the nominal is known (of a zone it is 0), its limits.
void set_limits(const CharacteristicSpec& spec, Characteristic& c);

}  // namespace cmm::acquisition
