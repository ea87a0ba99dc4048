// SPDX-License-Identifier: Apache-2.0
#include "support/compared_methods.hpp"

#include <Eigen/Geometry>
#include <stdexcept>

#include "fitting/contact_section.hpp"

namespace cmm::fitting::families {

ComparedBlade::ComparedBlade(Family family, std::uint64_t seed, std::size_t sections, bool noisy)
    : blade_(family, seed), surface_(1.0) {
    ScanOptions scanning;
    scanning.sigma_mm = noisy ? 1e-3 : 0.0;
    scanning.bad_share = noisy ? 0.015 : 0.0;
    rows_ = scan_rows(blade_, sections, 2, blade_.height() - 2, scanning);
    for (std::size_t k = 0; k < sections; ++k) {
        std::vector<Vec2> centres;
        for (const Vec3& p : rows_.rows[k])
            centres.push_back(p.head<2>());
        SectionOptions hinted = options_;
        hinted.le_hint = blade_.outline(rows_.heights[k]).le().nose;
        hinted.te_hint = blade_.outline(rows_.heights[k]).te().nose;
        auto fit = fit_section(centres, {}, hinted);
        if (!fit || !surface_.add(fit->centres.curve, rows_.heights[k], hinted.le_hint, hinted.te_hint))
            throw std::runtime_error(blade_.name() + ": a section is refused");
        flat_.push_back(std::move(*fit));
    }
    if (!surface_.fit()) throw std::runtime_error(blade_.name() + ": no surface");
}

Vec3 ComparedBlade::nominal_normal(const Vec2& centre, std::size_t row) const {
    const double z = rows_.heights[row];
    const Eigen::Rotation2Dd turn(nominal_turn_rad);
    const Vec2 in_blade = turn.inverse() * (centre - Vec2(nominal_shift_mm, 0.0));
    Vec3 normal = blade_.at(blade_.section(z).closest(in_blade).t, z).normal();
    normal.head<2>() = turn * Vec2(normal.head<2>());
    return normal;
}

core::Result<SectionFit> ComparedBlade::section(CompensationMethod method, std::size_t row,
                                                std::size_t* set_aside) const {
    const double z = rows_.heights[row];
    if (method == CompensationMethod::flat) return flat_[row];
    if (method == CompensationMethod::surface) {
        auto section = compensate_section(surface_, z, flat_[row], options_);
        if (!section) return tl::unexpected(section.error());
        return std::move(section->fit);
    }
    std::vector<CentreRow> rows;
    for (std::size_t k = 0; k < flat_.size(); ++k)
        rows.push_back({rows_.heights[k], flat_[k].centres.points, flat_[k].noise_sigma_mm});
    const auto nominal = [&](const Vec2& centre, const Vec2&) { return nominal_normal(centre, row); };
    const auto contacts = contacts_by(method, rows, row, options_.ball_radius_mm, nominal);
    if (!contacts) return tl::unexpected(contacts.error());
    auto section = section_of_contacts(*contacts, z, knows_lean(method), flat_[row], options_);
    if (!section) return tl::unexpected(section.error());
    if (set_aside != nullptr) *set_aside = section->set_aside;
    return std::move(section->fit);
}

MethodErrors ComparedBlade::errors(CompensationMethod method, std::size_t step) const {
    MethodErrors errors;
    for (std::size_t row = 0; row < flat_.size(); ++row) {
        std::size_t set_aside = 0;
        const auto fit = section(method, row, &set_aside);
        ++errors.sections;
        errors.set_aside += set_aside;
        if (!fit) {
            ++errors.refused;
            continue;
        }
        const auto truth = blade_.section(rows_.heights[row]);
        for (std::size_t i = 0; i < fit->contour.size(); i += step) {
            const Foot foot = truth.closest(fit->contour[i].position_mm);
            const auto part = Blade::part_of(foot.t);
            (part == Part::le || part == Part::te ? errors.edges : errors.sides).push_back(foot.distance);
        }
    }
    return errors;
}

ContourErrors ComparedBlade::along(const SectionFit& fit, std::size_t row) const {
    ContourErrors errors;
    const auto truth = blade_.section(rows_.heights[row]);
    for (const ContourPoint& point : fit.contour) {
        errors.arc_length_mm.push_back(point.arc_length_mm);
        errors.error_mm.push_back(truth.closest(point.position_mm).distance);
    }
    return errors;
}

}  // namespace cmm::fitting::families
