// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "acquisition/contour_sampling.hpp"
#include "acquisition/nominal_kinds.hpp"
#include "cad/step_part.hpp"

namespace cmm::acquisition {
namespace {

/// The faces that a cut runs over.
class CutFaces final : public NominalSurface {
  public:
    CutFaces(std::shared_ptr<const cad::SectionCurve> curve, std::vector<double> parameters,
             std::vector<Eigen::Vector2d> positions)
        : curve_(std::move(curve)), parameters_(std::move(parameters)), positions_(std::move(positions)) {}

    std::optional<Foot> closest(const Eigen::Vector3d& point_mm, const Eigen::Vector2d& near_mm) const override {
        const auto nearer = [&](const auto& a, const auto& b) {
            return (a - near_mm).squaredNorm() < (b - near_mm).squaredNorm();
        };
        const auto place = std::min_element(positions_.begin(), positions_.end(), nearer) - positions_.begin();
        const auto foot = curve_->closest(point_mm, parameters_[static_cast<std::size_t>(place)]);
        if (!foot) return std::nullopt;
        return Foot{foot->position_mm, foot->normal};
    }

  private:
    std::shared_ptr<const cad::SectionCurve> curve_;
    std::vector<double> parameters_;
    std::vector<Eigen::Vector2d> positions_;
};

class StepNominal final : public Nominal {
  public:
    explicit StepNominal(std::shared_ptr<const cad::StepPart> part) : part_(std::move(part)) {}

    core::Result<NominalContour> cut(double z_mm) const override {
        if (auto status = require_height(z_mm, z_low_mm(), z_high_mm()); !status) return tl::unexpected(status.error());
        auto cut = part_->cut(z_mm);
        if (!cut) return tl::unexpected(cut.error());
        const std::shared_ptr<const cad::SectionCurve> curve = std::move(*cut);
        auto parameters =
            dense_parameters([&](double t) { return curve->at(t).position_mm; }, curve->coarse(), curve->period());
        std::vector<CutPoint> points;
        std::vector<Eigen::Vector2d> positions;
        points.reserve(parameters.size());
        for (const double t : parameters) {
            const auto point = curve->at(t);
            points.push_back({point.position_mm, point.spanwise});
            positions.push_back(point.position_mm);
        }
        auto contour = contour_from(z_mm, points);
        contour.surface = std::make_shared<const CutFaces>(curve, std::move(parameters), std::move(positions));
        return contour;
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
