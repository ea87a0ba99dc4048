// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "fitting/camber_line.hpp"

namespace cmm::fitting {

/// Makes a CamberLine: circles from the middle outwards, then both ends. One use.
class CamberLineBuilder {
  public:
    CamberLineBuilder(const SectionFit& fit, CamberLine& line);
    /// Errors: fit_not_evaluable.
    core::Status run();

  private:
    std::optional<InscribedCircle> first_circle() const;
    std::vector<InscribedCircle> march(const InscribedCircle& from, const Vec2& forward, const Vec2& nose,
                                       double scale_mm) const;
    core::Status continue_to(const Vec2& nose, std::size_t nose_index, double scale_mm, bool le, CamberEnd& end) const;
    core::Status fit_cubic(bool le, CamberEnd& end, double last_mm, double scale_mm) const;
    static void lay_cubic(const std::vector<Vec2>& centres, double scale_mm, CamberEnd& end);
    core::Status leave_contour(std::size_t nose_index, double scale_mm, CamberEnd& end) const;
    void join();

    const SectionFit& fit_;
    CamberLine& line_;
    const ContourGeometry& contour_;
    double chord_mm_;
};

}  // namespace cmm::fitting
