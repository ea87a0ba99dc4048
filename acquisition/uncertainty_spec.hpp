// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>

#include "core/config.hpp"
#include "drivers/machine_errors.hpp"
#include "fitting/error_fields.hpp"

namespace cmm::acquisition {

/// What becomes of an expansion of the part that is known because its temperature is.
enum class ExpansionCorrection : std::uint8_t {
    none,        ///< nothing: it is added to the uncertainty
    applied,     ///< points and ball are carried to 20 degrees before the section is fitted
    by_machine,  ///< the controller has done it
};
std::string_view to_string(ExpansionCorrection correction) noexcept;

/// The table [uncertainty] of a part file, with what is known of the machine (docs/theory.md, section 16). A value.
struct UncertaintySpec {
    drivers::MachineErrors stated;   ///< by the part file
    drivers::MachineErrors machine;  ///< by the machine file, or kept in the run file
    double part_temperature_c = 20.0;
    double temperature_standard_k = 0.0;
    double expansion_per_k = 0.0, expansion_standard_per_k = 0.0;
    ExpansionCorrection correction = ExpansionCorrection::none;
    Eigen::Vector3d fixed_at_mm = Eigen::Vector3d::Zero();  ///< of the part, where it is held: it expands from there

    /// What the part file states goes before the machine's own figures.
    drivers::MachineErrors figures() const { return stated.or_else(machine); }
    /// By so much the part is larger than at 20 degrees, mm per mm.
    double growth() const;
    /// Standard uncertainties: a largest permissible error E counts as one that is nowhere within +-E more likely
    /// (ISO 14253-2, JCGM 100 4.3.7): E/sqrt(3).
    fitting::SystematicErrors errors() const;
};

UncertaintySpec read_uncertainty(const core::ConfigTable& table);

/// "E0 1.9 um + L/300; P_Form 1.9 um; part at 21.3 C (u 0.2 K), 11.5 um/(m K): corrected"; empty where nothing is said.
std::string uncertainty_words(const UncertaintySpec& spec);

}  // namespace cmm::acquisition
