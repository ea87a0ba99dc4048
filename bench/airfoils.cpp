// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "bench/bench.hpp"
#include "fitting/section.hpp"
#include "fitting/smoothing.hpp"
#include "support/airfoil.hpp"

namespace cmm::bench {
namespace {

using fitting::airfoil::Airfoil;
using Spacing = Airfoil::Spacing;

constexpr std::uint64_t scans = 100;
constexpr int judged_places = 4000;
constexpr double ball_radius_mm = 1.0;

struct Asked {
    std::size_t points;
    double sigma_mm;
    std::string um;
};
const std::array<Asked, 5> asked{{{1000, 0.0, "0.02 rms, 0.25 largest"},
                                  {1000, 1e-3, "0.20, 1.3"},
                                  {1000, 3e-3, "0.50, 3.2"},
                                  {400, 1e-3, "0.45, 3.5"},
                                  {2000, 1e-3, "0.15, 1.2"}}};

/// Root mean square of all places, largest error of a scan on average and of all; um.
class Errors {
  public:
    void add(const Airfoil& airfoil, const std::vector<fitting::Vec2>& places) {
        double squares = 0.0, largest = 0.0;
        std::size_t near = 0;
        for (const auto& place : places) {
            const double off_um = 1e3 * airfoil.distance(place, near);
            squares += off_um * off_um;
            largest = std::max(largest, std::abs(off_um));
        }
        ++count_;
        squares_ += squares / static_cast<double>(places.size());
        largest_sum_ += largest;
        largest_ = std::max(largest_, largest);
    }
    Spread spread() const { return {std::sqrt(squares_ / count_), largest_sum_ / count_, largest_}; }

  private:
    int count_ = 0;
    double squares_ = 0.0, largest_sum_ = 0.0, largest_ = 0.0;
};

std::vector<fitting::Vec2> places_on(const fitting::PiecewiseCubic& curve) {
    std::vector<fitting::Vec2> places;
    for (int i = 0; i < judged_places; ++i)
        places.push_back(curve.jet(curve.front() + curve.period() * i / judged_places).position);
    return places;
}

/// Empty where it is not evaluable.
std::vector<fitting::Vec2> contour_of(const std::vector<fitting::Vec2>& centres) {
    fitting::SectionOptions options;
    options.ball_radius_mm = ball_radius_mm;
    const auto fit = fitting::fit_section(centres, {}, options);
    std::vector<fitting::Vec2> places;
    if (!fit) return places;
    for (const auto& point : fit->contour)
        places.push_back(point.position_mm);
    return places;
}

using Form = Airfoil (*)(double offset_mm);

void report(const std::string& name, Form form, Spacing spacing) {
    const Airfoil part = form(0.0), centres = form(ball_radius_mm);
    for (const auto& [points, sigma_mm, um] : asked) {
        Errors curve, centre_curve, contour;
        std::size_t open = 0;
        for (std::uint64_t seed = 100; seed < 100 + scans; ++seed) {
            curve.add(part,
                      places_on(fitting::smooth_closed(part.scan(points, spacing, sigma_mm, seed)).value().curve));
            const auto scan = centres.scan(points, spacing, sigma_mm, seed);
            centre_curve.add(centres, places_on(fitting::smooth_closed(scan).value().curve));
            const auto places = contour_of(scan);
            if (places.empty())
                ++open;
            else
                contour.add(part, places);
        }
        const std::string noise = std::to_string(static_cast<int>(std::lround(1e3 * sigma_mm)));
        print(name + ", " + std::to_string(points) + " points, " + noise + " um", curve.spread(), "um", um);
        print("  its ball centres", centre_curve.spread(), "um", um);
        print("  the contour from these", contour.spread(), "um", std::to_string(open) + " scans open");
    }
}

}  // namespace

void bench_airfoils() {
    const std::array<std::pair<Spacing, std::string>, 3> spacings{
        {{Spacing::cosine, "closer to the edges"}, {Spacing::edges, "12 % on each edge"}, {Spacing::even, "even"}}};
    for (const auto& [spacing, how] : spacings) {
        report(
            "envelope, " + how, [](double offset_mm) { return Airfoil(offset_mm); }, spacing);
        report("NACA 65, " + how, &Airfoil::naca_65, spacing);
    }
}

}  // namespace cmm::bench
