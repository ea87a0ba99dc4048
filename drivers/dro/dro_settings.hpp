// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "core/config.hpp"

namespace cmm::drivers::dro {

/// How a digital readout prints its points: the [dro] table of a machine file (docs/dro.md). A plain value.
struct DroSettings {
    std::string format = "X{x},Y{y},Z{z}";
    bool integers = false;        ///< numbers are counts without a decimal point
    double unit_mm = 1.0;         ///< of the numbers: 1 or 25.4
    double count = 1e-4;          ///< size of a count in that unit; of decimal numbers: what they are rounded to
    std::optional<int> decimals;  ///< every number has so many places, else its line is garbled
    bool decimal_comma = false;
    std::string point_tags;         ///< with {tag}: lines with one of these characters are points, others are none
    std::string end;                ///< a line that ends the section; empty: none
    std::string request;            ///< asks the device for a point; empty: it sends by itself
    double request_every_ms = 0.0;  ///< 0: only when a person asks for a point

    double lsb_mm() const { return count * unit_mm; }
};

/// Errors are left in the table (ConfigTable::complain), a bad format among them.
DroSettings read_dro_settings(const core::ConfigTable& table);

}  // namespace cmm::drivers::dro
