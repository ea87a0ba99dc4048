// SPDX-License-Identifier: Apache-2.0
#include "support/formed_nominal.hpp"

#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "core/rng.hpp"

namespace cmm::fitting::formed {
namespace {

constexpr std::size_t places = 6000;

/// The exact outline as a contour.
std::vector<ContourPoint> outline_of(const families::Blade& blade) {
    std::vector<ContourPoint> out(places);
    for (std::size_t k = 0; k < places; ++k) {
        const auto at = blade.at(4.0 * static_cast<double>(k) / static_cast<double>(places));
        out[k].position_mm = at.position;
        out[k].normal = at.normal();
        if (k > 0) out[k].arc_length_mm = out[k - 1].arc_length_mm + (at.position - out[k - 1].position_mm).norm();
    }
    return out;
}

/// Of a random function of the share of a length, root mean square 1.
struct Harmonics {
    std::array<double, 5> size{}, phase{};

    explicit Harmonics(std::uint64_t seed) {
        core::Rng rng = core::Rng::keyed(seed, 0xF0, 0);
        double squares = 0.0;
        for (std::size_t k = 0; k < size.size(); ++k) {
            size[k] = rng.normal();
            phase[k] = rng.uniform(0.0, 2.0 * std::numbers::pi);
            squares += 0.5 * size[k] * size[k];
        }
        for (double& each : size)
            each /= std::sqrt(squares);
    }

    double operator()(double share) const {
        double sum = 0.0;
        for (std::size_t k = 0; k < size.size(); ++k)
            sum += size[k] * std::cos(2.0 * std::numbers::pi * static_cast<double>(k + 1) * share + phase[k]);
        return sum;
    }
};

}  // namespace

ClosedCurve itself(const families::Blade& blade) {
    std::vector<Vec2> outline;
    for (const ContourPoint& point : outline_of(blade))
        outline.push_back(point.position_mm);
    return ClosedCurve::through(outline).value();
}

Nominal of_other_form(const families::Blade& blade, double form_mm, std::uint64_t seed) {
    const auto outline = outline_of(blade);
    const Harmonics form(seed);
    const double length =
        outline.back().arc_length_mm + (outline.front().position_mm - outline.back().position_mm).norm();
    std::vector<Vec2> displaced;
    for (const ContourPoint& point : outline)
        displaced.push_back(point.position_mm + form_mm * form(point.arc_length_mm / length) * point.normal);
    Nominal out{ClosedCurve::through(displaced).value(), {}};
    BestFitOptions min_max;
    min_max.objective = FitObjective::min_max;
    out.min_max = fit_to_nominal(ContourGeometry(outline), out.curve, min_max).value().motion;
    return out;
}

}  // namespace cmm::fitting::formed
