// SPDX-License-Identifier: Apache-2.0
#include "acquisition/decision_rule.hpp"

#include <array>
#include <utility>

#include "core/text.hpp"
#include "fitting/statistics.hpp"

namespace cmm::acquisition {
namespace {

constexpr std::array<std::pair<DecisionMethod, std::string_view>, 4> method_names{
    {{DecisionMethod::iso_14253_1, "iso_14253_1"},
     {DecisionMethod::simple, "simple"},
     {DecisionMethod::stringent, "stringent"},
     {DecisionMethod::relaxed, "relaxed"}}};

/// U95 is this many standard uncertainties where the noise is well known; where it is not, Student's factors of both
/// are larger, that of U95 by more.
double interval_deviate() {
    static const double deviate = fitting::upper_deviate(0.025);
    return deviate;
}

}  // namespace

std::string_view to_string(DecisionMethod method) noexcept {
    return method_names[static_cast<std::size_t>(method)].second;
}

std::optional<DecisionMethod> decision_method_from(std::string_view name) {
    for (const auto& [method, its_name] : method_names)
        if (its_name == name) return method;
    return std::nullopt;
}

double DecisionRule::deviate() const {
    return fitting::upper_deviate(risk_of_look());
}

GuardBands DecisionRule::guards(double u95) const {
    const double g = deviate() / interval_deviate() * u95;
    return {g, g};
}

Decision DecisionRule::decide(double value, const GuardBands& guard, std::optional<double> lower,
                              std::optional<double> upper) const {
    if (!lower && !upper) return Decision::reported;
    const auto inside = [&](double g) { return (!upper || value + g <= *upper) && (!lower || value - g >= *lower); };
    const auto outside = [&](double g) { return (upper && value - g > *upper) || (lower && value + g < *lower); };
    switch (method) {
        case DecisionMethod::simple:
            return inside(0.0) ? Decision::accept : Decision::reject;
        case DecisionMethod::stringent:
            return inside(guard.accept) ? Decision::accept : Decision::reject;
        case DecisionMethod::relaxed:
            return outside(guard.reject) ? Decision::reject : Decision::accept;
        case DecisionMethod::iso_14253_1:
            break;
    }
    if (outside(guard.reject)) return Decision::reject;
    return inside(guard.accept) ? Decision::accept : Decision::undecided;
}

std::string DecisionRule::worded() const {
    std::string text;
    switch (method) {
        case DecisionMethod::iso_14253_1:
            text = "ISO 14253-1: accept if value + g <= limit, reject if value - g > limit, otherwise undecided";
            break;
        case DecisionMethod::simple:
            return "ASME B89.7.3.1, simple acceptance and rejection: accept if value <= limit, otherwise reject; no "
                   "guard band";
        case DecisionMethod::stringent:
            text =
                "ASME B89.7.3.1, stringent acceptance, relaxed rejection: accept if value + g <= limit, otherwise "
                "reject";
            break;
        case DecisionMethod::relaxed:
            text =
                "ASME B89.7.3.1, relaxed acceptance, stringent rejection: reject if value - g > limit, otherwise "
                "accept";
            break;
    }
    text += "; g = " + core::fixed(deviate() / interval_deviate(), 3) + " U95 (risk " + core::fixed(100.0 * risk, 0) +
            " %, one-sided";
    if (looks > 1)
        text += "; " + core::fixed(100.0 * risk_of_look(), 2) + " % for each of up to " + std::to_string(looks) +
                " looks at a characteristic";
    return text + "); of a profile by the places of its zone";
}

}  // namespace cmm::acquisition
