// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "fitting/compensation_method.hpp"
#include "fitting/surface_section.hpp"
#include "support/twisted_blade.hpp"

/// The methods of compensation side by side on one scanned blade, their contours against its exact sections.
namespace cmm::fitting::families {

/// Signed distances of contours to the truth in their planes, mm.
struct MethodErrors {
    std::vector<double> sides, edges;
    std::size_t sections = 0, refused = 0;
    std::size_t set_aside = 0;  ///< contacts
};

/// Places of one contour: height over the unrolled blade and error, for pictures.
struct ContourErrors {
    std::vector<double> arc_length_mm, error_mm;
};

class ComparedBlade {
  public:
    /// 600 points a section, ball 1 mm; with noise 1 um along the normal and 1.5 % bad points.
    ComparedBlade(Family family, std::uint64_t seed, std::size_t sections, bool noisy);

    /// The nominal of point_distance: the true blade turned by this about the origin and shifted.
    static constexpr double nominal_turn_rad = 0.1 * 3.14159265358979323846 / 180.0;
    static constexpr double nominal_shift_mm = 0.05;

    const std::string& name() const { return blade_.name(); }
    /// Of all sections, the first and the last too; every `step`th point of each contour.
    MethodErrors errors(CompensationMethod method, std::size_t step = 5) const;
    /// Of one section. Errors: those of the method.
    core::Result<SectionFit> section(CompensationMethod method, std::size_t row,
                                     std::size_t* set_aside = nullptr) const;
    ContourErrors along(const SectionFit& fit, std::size_t row) const;

  private:
    Vec3 nominal_normal(const Vec2& centre, std::size_t row) const;

    TwistedBlade blade_;
    BladeRows rows_;
    SectionOptions options_;
    std::vector<SectionFit> flat_;
    SurfaceCompensation surface_;
};

}  // namespace cmm::fitting::families
