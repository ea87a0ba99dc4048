// SPDX-License-Identifier: Apache-2.0
/// Parts of blades, compensated by what their own sections say of the lean, against exact truth.
#include "fitting/lean_by_sections.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <iostream>
#include <string>
#include <vector>

#include "fitting/nominal.hpp"
#include "support/twisted_blade.hpp"

namespace cmm::fitting {
namespace {

using Missing = std::function<bool(double t)>;  // by the parameter of the outline: LE, pressure side, TE, suction side

/// Sections of a twisted blade without what is missing, each with the exact section as its nominal.
struct PartialBlade {
    families::TwistedBlade blade;
    families::BladeRows rows;
    std::vector<NominalSection> nominals;
    std::vector<SectionFit> fits;
    std::vector<SectionInPlane> sections;
    SectionOptions options;

    PartialBlade(families::Family family, std::size_t count, double noise_mm, const Missing& missing)
        : blade(family, 3) {
        families::ScanOptions scanning;
        scanning.sigma_mm = noise_mm;
        scanning.bad_share = noise_mm > 0.0 ? 0.015 : 0.0;
        rows = families::scan_rows(blade, count, 2.0, blade.height() - 2.0, scanning);
        options.ball_radius_mm = 1.0;
        for (std::size_t k = 0; k < count; ++k) {
            const auto truth = blade.section(rows.heights[k]);
            std::vector<Vec2> centres, outline;
            for (const auto& p : rows.rows[k])
                if (!missing(truth.closest(p.head<2>()).t)) centres.push_back(p.head<2>());
            constexpr int places = 1200;
            for (int i = 0; i < places; ++i)
                outline.push_back(blade.at(4.0 * i / places, rows.heights[k]).position.head<2>());
            const auto form = blade.outline(rows.heights[k]);
            nominals.push_back(analyse_nominal(outline, {form.le().nose, form.te().nose}).value());
            SectionOptions own = options;
            own.le_hint = form.le().nose;
            own.te_hint = form.te().nose;
            own.nominal = &nominals.back().curve();
            auto fit = fit_section(centres, {}, own);
            EXPECT_TRUE(fit) << fit.error().text();
            fits.push_back(fit ? std::move(*fit) : SectionFit{});
        }
        for (std::size_t k = 0; k < count; ++k)
            sections.push_back({rows.heights[k], &fits[k]});
    }
};

struct Errors {
    double squares = 0.0, largest_um = 0.0;
    std::size_t count = 0, outside = 0;

    /// Of what was measured, on the sides or at the edges.
    void add(const SectionFit& fit, const families::TwistedBlade::Section& truth, bool sides) {
        for (const ContourPoint& p : fit.contour) {
            if (!p.measured || (p.zone == Zone::suction || p.zone == Zone::pressure) != sides) continue;
            const double off = std::abs(truth.closest(p.position_mm).distance);
            squares += off * off;
            largest_um = std::max(largest_um, 1e3 * off);
            outside += off > p.u95_mm ? 1U : 0U;
            ++count;
        }
    }
    double rms_um() const { return 1e3 * std::sqrt(squares / static_cast<double>(std::max<std::size_t>(count, 1))); }
    double outside_share() const {
        return static_cast<double>(outside) / static_cast<double>(std::max<std::size_t>(count, 1));
    }
    std::string text() const {
        return std::to_string(rms_um()) + ", " + std::to_string(largest_um) + " um, beyond U95 " +
               std::to_string(100.0 * outside_share()) + " %";
    }
};

/// Sums over all sections of a part.
struct PartErrors {
    Errors flat, sides, edges;
    double sure = 0.0;  // share of the measured places whose lean is known to 3 um

    explicit PartErrors(const PartialBlade& part) {
        std::size_t measured = 0, well_known = 0;
        for (std::size_t k = 0; k < part.sections.size(); ++k) {
            const auto section = compensate_by_sections(part.sections, k, part.options);
            if (!section) {
                ADD_FAILURE() << section.error().text();
                continue;
            }
            const auto truth = part.blade.section(part.rows.heights[k]);
            flat.add(part.fits[k], truth, true);
            sides.add(section->fit, truth, true);
            edges.add(section->fit, truth, false);
            for (const ContourPoint& p : section->fit.contour) {
                measured += p.measured ? 1U : 0U;
                well_known += p.measured && p.lean_rad && p.bound_mm < 3e-3 ? 1U : 0U;
            }
        }
        sure = static_cast<double>(well_known) / static_cast<double>(measured);
    }
};

/// A blade of which one side alone, or all but the TE, was measured in every section: the sections tell each other the
/// lean as far as they lie beside each other. Of the fan, which twists by 55 degrees, the end of a side has nothing
/// beside it in the last section, and its U95 says so.
TEST(LeanBySections, PartsOfBladesAreNearTheTruth) {
    const std::pair<const char*, Missing> cases[] = {
        {"pressure side alone", [](double t) { return t < 1.0 || t > 2.0; }},
        {"no TE", [](double t) { return t > 1.9 && t < 3.1; }}};
    for (const auto family : families::all_families)
        for (const auto& [name, missing] : cases) {
            const PartialBlade part(family, 25, 1e-3, missing);
            const PartErrors errors(part);
            SCOPED_TRACE(part.blade.name() + ", " + name);
            std::cout << part.blade.name() << ", " << name << ": lean known of " << 100.0 * errors.sure
                      << " %; 2-D offset " << errors.flat.text() << "; sides " << errors.sides.text() << "; edges "
                      << errors.edges.text() << '\n';
            const bool fan = family == families::Family::fan;
            EXPECT_GT(errors.sure, fan ? 0.8 : 0.93);
            EXPECT_LT(errors.sides.rms_um(), fan ? 0.25 * errors.flat.rms_um() : 0.4);
            EXPECT_LT(errors.sides.largest_um, (fan ? 0.9 : 0.3) * errors.flat.largest_um);
            EXPECT_LT(errors.sides.outside_share(), 0.06);
            EXPECT_LT(errors.edges.rms_um(), 0.6);
            EXPECT_LT(errors.edges.outside_share(), 0.07);
        }
}

TEST(LeanBySections, OneSectionAloneIsRefusedAndSoIsOneWithNothingBesideIt) {
    const auto one_half = [](double t) { return t < 3.0; };
    const PartialBlade part(families::Family::compressor, 3, 1e-3, one_half);
    const auto alone = compensate_by_sections(std::span(part.sections).first(1), 0, part.options);
    ASSERT_FALSE(alone);
    EXPECT_NE(alone.error().message.find("no other section"), std::string::npos);
    const SectionInPlane twice[] = {part.sections[0], part.sections[0]};
    EXPECT_FALSE(compensate_by_sections(twice, 0, part.options)) << "at one height";
    const PartialBlade other(families::Family::compressor, 3, 1e-3, [](double t) { return t < 1.0 || t > 2.0; });
    const SectionInPlane across[] = {part.sections[0], other.sections[1]};
    EXPECT_FALSE(compensate_by_sections(across, 0, part.options)) << "the other side is not beside it";
    auto options = part.options;
    options.ball_radius_mm = 0.0;
    EXPECT_FALSE(compensate_by_sections(part.sections, 0, options));
}

TEST(LeanBySections, TheOrderOfTheSectionsDoesNotMatter) {
    const PartialBlade part(families::Family::turbine, 6, 1e-3, [](double t) { return t > 1.9 && t < 3.1; });
    auto turned = part.sections;
    std::reverse(turned.begin(), turned.end());
    const auto one = compensate_by_sections(part.sections, 2, part.options),
               other = compensate_by_sections(turned, 3, part.options);
    ASSERT_TRUE(one && other);
    ASSERT_EQ(one->fit.contour.size(), other->fit.contour.size());
    for (std::size_t i = 0; i < one->fit.contour.size(); ++i)
        EXPECT_LT((one->fit.contour[i].position_mm - other->fit.contour[i].position_mm).norm(), 1e-9);
}

}  // namespace
}  // namespace cmm::fitting
