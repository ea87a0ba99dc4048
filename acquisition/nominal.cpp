// SPDX-License-Identifier: Apache-2.0
#include "acquisition/nominal.hpp"

#include "acquisition/nom_file.hpp"
#include "acquisition/nominal_kinds.hpp"
#include "core/text.hpp"

namespace cmm::acquisition {

core::Status require_height(double z_mm, double low_mm, double high_mm) {
    constexpr double tolerance_mm = 1e-3;
    if (z_mm >= low_mm - tolerance_mm && z_mm <= high_mm + tolerance_mm) return {};
    return core::fail(core::ErrorCode::plan_invalid, "z = " + core::fixed(z_mm, 3) + " mm lies outside the nominal (" +
                                                         core::fixed(low_mm, 3) + " mm to " + core::fixed(high_mm, 3) +
                                                         " mm)");
}

Eigen::Vector3d turned_to_z(const Eigen::Vector3d& p, Span span) noexcept {
    if (span == Span::y) return {p.z(), p.x(), p.y()};
    if (span == Span::x) return {p.y(), p.z(), p.x()};
    return p;
}

fitting::NominalOptions edge_hints(const NominalSpec& spec, const NominalContour& contour) {
    fitting::NominalOptions hints;
    hints.le_hint = spec.le_hint_mm;
    if (hints.le_hint) return hints;
    hints.le_hint = contour.le_mm;
    hints.te_hint = contour.te_mm;
    return hints;
}

namespace {

core::Result<std::shared_ptr<const Nominal>> read_nominal(const NominalSpec& spec) {
    if (spec.kind == NominalKind::parametric) return parametric_nominal(spec.blade.value());
    if (spec.kind == NominalKind::mesh) {
        auto mesh = read_mesh(spec.files.at(0));
        if (!mesh) return tl::unexpected(std::move(mesh.error()).with_context("while reading the nominal"));
        return mesh_nominal(std::move(*mesh), spec.span);
    }
    if (spec.kind == NominalKind::step) return step_nominal(spec.files.at(0), spec.solid, spec.span);
    if (spec.kind == NominalKind::nom) {
        auto file = read_nom(spec.files.at(0), spec.skip);
        if (!file) return tl::unexpected(std::move(file.error()).with_context("while reading the nominal"));
        return nom_nominal(std::move(*file));
    }
    auto sections = read_points(spec.files);
    if (!sections) return tl::unexpected(std::move(sections.error()).with_context("while reading the nominal"));
    return sections_nominal(std::move(*sections), spec.span);
}

}  // namespace

core::Result<std::shared_ptr<const Nominal>> load_nominal(const NominalSpec& spec) {
    if (spec.kind == NominalKind::none) return std::shared_ptr<const Nominal>();
    auto nominal = read_nominal(spec);
    if (!nominal || spec.le_hint_mm) return nominal;
    return with_one_leading_edge(std::move(*nominal));
}

}  // namespace cmm::acquisition
