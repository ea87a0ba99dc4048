// SPDX-License-Identifier: Apache-2.0
#include "acquisition/contour_sampling.hpp"
#include "acquisition/nominal_kinds.hpp"
#include "cad/step_part.hpp"

namespace cmm::acquisition {
namespace {

class StepNominal final : public Nominal {
  public:
    explicit StepNominal(std::shared_ptr<const cad::StepPart> part) : part_(std::move(part)) {}

    core::Result<NominalContour> cut(double z_mm) const override {
        if (auto status = require_height(z_mm, z_low_mm(), z_high_mm()); !status) return tl::unexpected(status.error());
        const auto curve = part_->cut(z_mm);
        if (!curve) return tl::unexpected(curve.error());
        const auto parameters = dense_parameters([&](double t) { return (*curve)->at(t).position_mm; },
                                                 (*curve)->coarse(), (*curve)->period());
        std::vector<CutPoint> points;
        points.reserve(parameters.size());
        for (const double t : parameters) {
            const auto point = (*curve)->at(t);
            points.push_back({point.position_mm, point.spanwise});
        }
        return contour_from(z_mm, points);
    }
    double z_low_mm() const override { return part_->z_low_mm(); }
    double z_high_mm() const override { return part_->z_high_mm(); }

  private:
    std::shared_ptr<const cad::StepPart> part_;
};

}  // namespace

core::Result<std::shared_ptr<const Nominal>> step_nominal(const std::string& file, const std::string& solid,
                                                          Span span) {
    auto part = cad::read_step(file, solid, span == Span::x ? 0 : span == Span::y ? 1 : 2);
    if (!part) return tl::unexpected(std::move(part.error()).with_context("while reading the nominal"));
    return std::make_shared<const StepNominal>(std::move(*part));
}

}  // namespace cmm::acquisition
