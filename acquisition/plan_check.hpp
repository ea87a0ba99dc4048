// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "acquisition/plan.hpp"

namespace cmm::acquisition {

enum class Severity : std::uint8_t { note, warning, error };
std::string_view to_string(Severity severity) noexcept;

/// What the check of a plan found; an error must stop the run before anything moves.
struct Finding {
    Severity severity = Severity::note;
    std::string text;
};

/// Checks travel limits (when the machine is known), that travel does not cut the part, the shank against the sections
/// above the ball, concave places, the sample clock, and estimates the duration. `by_touches`: of a measurement by
/// single touches, the ways between them instead of the clock.
///
/// The shank check takes a stylus that hangs straight down. A head that inclines the stylus, or a star stylus, keeps
/// the shank free of a leaning blade, and a part file cannot tell which is mounted: a touching shank is a warning, with
/// height and depth.
std::vector<Finding> check_plan(const Plan& plan, const PartFile& part, const Nominal* nominal,
                                const drivers::Capabilities* capabilities = nullptr, bool by_touches = false);
/// plan_invalid with the errors among the findings.
core::Status require_sound(const std::vector<Finding>& findings);

}  // namespace cmm::acquisition
