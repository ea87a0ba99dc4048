// SPDX-License-Identifier: Apache-2.0
#include "acquisition/six_point_spec.hpp"

#include <string>

namespace cmm::acquisition {
namespace {

using Eigen::Vector3d;

std::optional<Vector3d> read_vector(const core::ConfigTable& table, std::string_view key) {
    const auto values = table.numbers(key);
    if (!table.has(key)) return std::nullopt;
    if (values.size() != 3) {
        table.complain(key, "must be three numbers [x, y, z]");
        return std::nullopt;
    }
    return Vector3d(values[0], values[1], values[2]);
}

DatumPlace read_place(const core::ConfigTable& table, std::string_view at_key, std::string_view direction_key) {
    DatumPlace place;
    if (const auto at = read_vector(table, at_key))
        place.at_mm = *at;
    else if (!table.has(at_key))
        table.complain(at_key, "is missing: the place on the part, [x, y, z]");
    place.normal = read_vector(table, direction_key);
    if (!place.normal) return place;
    if (place.normal->norm() > 0.0)
        place.normal->normalize();
    else
        table.complain(direction_key, "must not be zero: it points out of the material");
    return place;
}

DatumSpec read_datum(const core::ConfigTable& table) {
    DatumSpec datum{read_place(table, "at_mm", "direction"), std::nullopt};
    if (table.has("opposite_mm") || table.has("opposite_direction"))
        datum.opposite = read_place(table, "opposite_mm", "opposite_direction");
    return datum;
}

fitting::DatumPoint point_of(const DatumSpec& datum) {
    fitting::DatumPoint point{datum.at_mm, datum.normal.value_or(Vector3d::Zero())};
    if (datum.opposite) point.opposite = {datum.opposite->at_mm, datum.opposite->normal.value_or(Vector3d::Zero())};
    return point;
}

}  // namespace

std::optional<SixPointSpec> read_six_points(const core::ConfigTable& alignment, bool wanted) {
    const auto points = alignment.tables("point");
    SixPointSpec spec;
    auto& options = spec.options;
    options.residual_mm = alignment.number("residual_mm", options.residual_mm, {1e-6, 1.0});
    options.moved_mm = alignment.number("moved_mm", options.moved_mm, {1e-6, 10.0});
    options.most_rounds = static_cast<int>(alignment.integer("most_rounds", options.most_rounds, {2, 100}));
    options.touch_standard_mm = alignment.number("touch_standard_mm", options.touch_standard_mm, {1e-6, 1.0});
    spec.largest_condition = alignment.number("largest_condition", spec.largest_condition, {1.0, 1e6});
    spec.approach_mm = alignment.number("approach_mm", spec.approach_mm, {0.01, 1000.0});
    spec.search_mm = alignment.number("search_mm", spec.search_mm, {0.01, 1000.0});
    if (points.empty()) {
        if (wanted) alignment.complain("point", "is missing: six [[alignment.point]] with at_mm and direction");
        for (const char* key : {"residual_mm", "moved_mm", "most_rounds", "touch_standard_mm", "largest_condition",
                                "approach_mm", "search_mm"})
            if (alignment.has(key)) alignment.complain(key, "needs [[alignment.point]]");
        return std::nullopt;
    }
    bool all = true;
    fitting::SixPoints known;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const auto datum = read_datum(points[i]);
        if (i >= known.size()) continue;
        spec.places[i] = datum;
        known[i] = point_of(datum);
        all = all && datum.normal && (!datum.opposite || datum.opposite->normal);
    }
    if (points.size() != fitting::datum_points) {
        alignment.complain("point", "six are needed, one for each way that a part can move; there are " +
                                        std::to_string(points.size()));
        return std::nullopt;
    }
    if (!all) return spec;
    if (const auto held = fitting::require_hold(known, spec.largest_condition); !held)
        alignment.complain("point", held.error().message);
    return spec;
}

}  // namespace cmm::acquisition
