// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "acquisition/characteristic_spec.hpp"
#include "core/error.hpp"
#include "fitting/measured_section.hpp"
#include "fitting/nominal.hpp"

namespace cmm::acquisition {

/// A nominal as a section that was measured without error, with 1 200 points.
fitting::SectionFit section_of_nominal(const fitting::NominalSection& nominal);

/// Of a radius.
fitting::EdgeName edge_of(const CharacteristicSpec& spec);

/// What a section says of a number that needs nothing but its contour. Errors: fit_not_evaluable.
core::Result<fitting::Measure> measure_of(const CharacteristicSpec& spec, fitting::MeasuredSection& section);

/// That of the part file, and 0 of displacement and twist; of others none: it is that of the nominal section.
std::optional<double> nominal_without_section(const CharacteristicSpec& spec);

/// The numbers that are asked of a section, of its nominal: they do not depend on the measurement and are found before
/// it. Refers to nothing; immutable after construction, any thread; mm, rad.
class NominalMeasures {
  public:
    /// Those of `asked` that are of the section `index` and that the part file does not give.
    NominalMeasures(const fitting::NominalSection& nominal, std::size_t index,
                    std::span<const CharacteristicSpec> asked);
    NominalMeasures(const NominalMeasures&) = delete;
    NominalMeasures& operator=(const NominalMeasures&) = delete;

    const fitting::ContourGeometry& contour() const { return measured_.contour(); }
    /// nullptr: it was not among them.
    const core::Result<double>* find(const CharacteristicSpec& spec) const;

  private:
    core::Result<double> value_of(const CharacteristicSpec& spec, const fitting::NominalSection& nominal);

    fitting::SectionFit fit_;
    fitting::MeasuredSection measured_;
    std::vector<std::pair<CharacteristicSpec, core::Result<double>>> known_;
};

}  // namespace cmm::acquisition
