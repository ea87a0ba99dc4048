// SPDX-License-Identifier: Apache-2.0
#include "tests/acquisition/decision_subject.hpp"

#include <cmath>

#include "acquisition/ball_path.hpp"

namespace cmm::acquisition::decisions {

using fitting::families::Blade;
using fitting::families::Vec2;

SectionSetup setup_of(const Blade& blade, double over_mm) {
    constexpr int nominal_points = 6000;
    NominalContour contour;
    for (int k = 0; k < nominal_points; ++k) {
        const auto jet = blade.at(4.0 * k / nominal_points);
        contour.points.emplace_back(jet.position - over_mm * jet.normal());
    }
    fitting::NominalOptions hints;
    hints.le_hint = blade.le().nose;
    hints.te_hint = blade.te().nose;
    auto section = fitting::analyse_nominal(contour.points, hints).value();
    SectionSetup setup;
    setup.ball_radius_mm = ball_mm;
    ReferenceContour reference(contour, section.curve(), ball_mm);
    setup.nominal = SectionNominal{std::move(section), std::move(reference)};
    setup.gate.profile_mm = setup.gate.edge_profile_mm = 2.0 * half_zone_mm;
    // A drawing says what its edges are.
    const auto model = [](const fitting::families::End& end) {
        return end.along == end.across ? fitting::EdgeModel::arc : fitting::EdgeModel::ellipse;
    };
    setup.fitting.le_model = model(blade.le());
    setup.fitting.te_model = model(blade.te());
    return setup;
}

PlannedPath planned_lap(const SectionSetup& setup, std::size_t points) {
    const auto& section = setup.nominal->section;
    const auto way = ball_path(section.curve(), ball_mm);
    SamplingOptions sampling;
    sampling.pitch_mm = section.curve().length() / static_cast<double>(points);
    std::vector<BallPoint> sampled;
    // The edges take more than their length's share; the second time the number is right to a few per cent.
    for (int attempt = 0; attempt < 2; ++attempt) {
        sampled = sample_ball_path(way, section, ball_mm, sampling);
        if (attempt == 0) sampling.pitch_mm *= static_cast<double>(sampled.size()) / static_cast<double>(points);
    }
    PlannedPath lap;
    for (const auto& point : sampled) {
        drivers::PathPoint planned;
        planned.centre_mm = {point.centre_mm.x(), point.centre_mm.y(), 0.0};
        planned.normal = {point.normal.x(), point.normal.y(), 0.0};
        planned.speed_mm_s = scanning_speed_mm_s(point.step_mm, sampling.pitch_mm, ScanSpec().max_speed_mm_s);
        if (!lap.points.empty())
            lap.duration_s += (planned.centre_mm - lap.points.back().centre_mm).norm() / planned.speed_mm_s;
        lap.points.push_back(planned);
    }
    return lap;
}

double place_of(const Blade& blade, const drivers::PathPoint& point) {
    return blade.closest((point.centre_mm - ball_mm * point.normal).head<2>()).t;
}

double swelling(double t, double width) {
    const double from_top = (t - 3.5) / width;
    return std::exp(-0.5 * from_top * from_top);
}

std::vector<RecordedPoint> recorded(const std::vector<Vec2>& centres) {
    std::vector<RecordedPoint> points(centres.size());
    for (std::size_t i = 0; i < centres.size(); ++i) {
        points[i].sequence = i + 1;
        points[i].centre_mm = {centres[i].x(), centres[i].y(), 0.0};
    }
    return points;
}

}  // namespace cmm::acquisition::decisions
