// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string_view>

#include "core/error.hpp"
#include "fitting/camber_line.hpp"

namespace cmm::fitting {

/// A number of a section, how it was found, and how it answers to errors of the contour.
struct Measure {
    std::string_view method;  ///< in capitals the keyword of the field, then what it means
    double value = 0.0;       ///< mm, rad, mm^2 or a share, as its function says
    Sensitivity slopes;
    BesideContour beside = {};  ///< what does not come from the contour
};

/// A closed fit with what its characteristics share: the contour as a curve, and the camber line, made when it is first
/// asked for. The fit must outlive it. One owner.
class MeasuredSection {
  public:
    explicit MeasuredSection(const SectionFit& fit) : fit_(&fit), contour_(fit.contour) {}
    MeasuredSection(const MeasuredSection&) = delete;
    MeasuredSection& operator=(const MeasuredSection&) = delete;

    const SectionFit& fit() const { return *fit_; }
    const ContourGeometry& contour() const { return contour_; }
    /// Errors: those of CamberLine::of.
    const core::Result<CamberLine>& camber() {
        if (!camber_) camber_.emplace(CamberLine::of(*fit_, contour_));
        return *camber_;
    }
    NumberUncertainty uncertainty(const Measure& measure) const {
        return fit_->contour_noise.of(fit_->contour, measure.slopes, measure.beside);
    }

  private:
    const SectionFit* fit_;
    ContourGeometry contour_;
    std::optional<core::Result<CamberLine>> camber_;
};

}  // namespace cmm::fitting
