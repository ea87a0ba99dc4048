// SPDX-License-Identifier: Apache-2.0
#include "drivers/machine_errors.hpp"

#include "core/units.hpp"

namespace cmm::drivers {
namespace {

constexpr core::Bounds figure_um{0.0, 1000.0};
constexpr core::Bounds k_mm_per_um{1.0, 1e6};

/// Read in any case, so that a misspelt key is told its right name.
std::optional<double> micrometres(const core::ConfigTable& table, const char* key) {
    const double um = table.number(key, 0.0, figure_um);
    return table.has(key) ? std::optional(core::mm_from_um(um)) : std::nullopt;
}

}  // namespace

MachineErrors MachineErrors::or_else(const MachineErrors& others) const {
    MachineErrors out = *this;
    for (const auto& [name, figure] : machine_figures)
        if (!(out.*figure)) out.*figure = others.*figure;
    return out;
}

MachineErrors read_machine_errors(const core::ConfigTable& table) {
    MachineErrors errors;
    errors.length_mm = micrometres(table, "length_um");
    const double k = table.number("length_k_mm_per_um", 1.0, k_mm_per_um);
    if (table.has("length_k_mm_per_um")) errors.length_share = core::mm_from_um(1.0) / k;
    errors.probing_form_mm = micrometres(table, "probing_form_um");
    errors.probing_size_mm = micrometres(table, "probing_size_um");
    errors.ball_standard_mm = micrometres(table, "ball_radius_standard_um");
    return errors;
}

}  // namespace cmm::drivers
