// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/gauge_anova.hpp"
#include "acquisition/section_result.hpp"
#include "core/error.hpp"

namespace cmm::acquisition {

/// One measurement of one part, with the names of its characteristics as in listed_characteristic.hpp.
struct StudyRun {
    std::string part, appraiser;  ///< which one lay on the machine, and who or what measured it
    std::string run_id, started_utc, part_name, plan;
    std::vector<Characteristic> characteristics;
};
/// `plan`: the same text for all runs whose paths are the same.
StudyRun study_run(const PartResult& result, const std::string& plan, const std::string& part,
                   const std::string& appraiser);

/// A value with its places in GaugeStudy::parts and ::appraisers.
struct StudyValue {
    std::size_t part = 0, appraiser = 0;
    double value = 0.0;
};

/// What a study says about one characteristic. Numbers in `unit`.
struct StudyCharacteristic {
    std::string name, method;
    Unit unit = Unit::mm;
    std::optional<double> tolerance;  ///< width: upper less lower limit; of a profile the width of its zone
    std::vector<StudyValue> values;   ///< that were used, in the order of time
    std::size_t missing = 0;          ///< runs without a value
    std::size_t left_out = 0;         ///< values that the balanced design has no place for, the latest ones
    std::size_t trials = 0;
    std::optional<GaugeComponents> components;
    std::string why;                 ///< no components because
    std::optional<double> declared;  ///< standard uncertainty that the single runs state (U95/2), root mean square

    /// Repeatability in units of the declared uncertainty; none where either is not known.
    std::optional<double> observed_to_declared() const;
};

/// Gauge repeatability and reproducibility over the runs of one part program.
struct GaugeStudy {
    std::string part_name;
    std::vector<std::string> parts, appraisers;  ///< in the order in which they first appear
    std::size_t runs = 0, fewest = 0, most = 0;  ///< runs of a part by an appraiser
    std::vector<StudyCharacteristic> characteristics;
};

/// Every part has to be measured twice at least by every appraiser. A characteristic is evaluated by as many values of
/// every part and appraiser as each of them has, the earliest ones, two at least; not where runs differ in its method
/// or tolerance. Errors: input_invalid (no run, a run twice, another part program, a part or appraiser without a name,
/// a part that an appraiser did not measure twice).
core::Result<GaugeStudy> make_gauge_study(std::vector<StudyRun> runs);

/// The table for a terminal: micrometres and degrees.
std::string study_text(const GaugeStudy& study);
/// A row for each characteristic; lengths in millimetres, angles in degrees.
std::string study_csv(const GaugeStudy& study);
/// Numbers in the unit of the characteristic; angles in radians, as in result.json.
std::string study_json(const GaugeStudy& study);
/// One file, nothing from outside: tables, and a picture for each characteristic.
std::string study_html(const GaugeStudy& study);

/// The values by part, and what they are off the mean of their part by appraiser. Empty without values.
std::string study_figure(const GaugeStudy& study, const StudyCharacteristic& one);

}  // namespace cmm::acquisition
