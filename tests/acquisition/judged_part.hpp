// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "acquisition/evaluation.hpp"
#include "tests/acquisition/synthetic_blade.hpp"

/// Parts whose sections are judged, for the tests of what goes out.
namespace cmm::acquisition {

inline SectionResult section_at(std::size_t index, double thicker_mm, bool with_nominal = true) {
    const synthetic::Shape shape;
    const synthetic::Section blade(shape);
    auto fit = synthetic::fit_of(blade, shape, [&](const auto& point) {
        return 0.003 * std::sin(point.arc_length_mm) + (point.zone == fitting::Zone::pressure ? thicker_mm : 0.0);
    });
    SectionResult raw;
    raw.index = index;
    raw.z_mm = 10.0 * static_cast<double>(index + 1);
    raw.points = synthetic::points_of(fit, 1.0, raw.z_mm, 1 + 400 * index, 100, index + 1);
    EvaluationOptions options;
    options.profile_mm = 0.10;
    options.edge_profile_mm = 0.06;
    const auto nominal = synthetic::reference(blade, 1.0);
    return evaluate_section(std::move(raw), std::move(fit), with_nominal ? &nominal : nullptr, options);
}

inline PartResult part_of(std::vector<SectionResult> sections) {
    PartResult part;
    part.part_name = "rotor <1> & \"co\"";
    part.part_serial = "S-7";
    part.started_utc = "2025-03-04T09:12:31Z";
    part.machine = "simulator";
    part.run_id = "run-9";
    part.software_version = "cmmlive 0.1.0";
    part.ball_radius_mm = 1.0;
    part.has_nominal = true;
    part.sections = std::move(sections);
    return part;
}

/// An angle with nominal and limits, rad.
inline Characteristic stagger_of(const std::string& method, double upper_rad) {
    Characteristic angle;
    angle.name = "stagger";
    angle.method = method;
    angle.value = 0.5;
    angle.u95 = 0.001;
    angle.unit = Unit::rad;
    angle.nominal = 0.49;
    angle.lower = 0.4;
    angle.upper = upper_rad;
    return angle;
}

/// Adds what needs several sections: of the part, of one of its sections, and one that is not evaluable.
inline void add_of_part(PartResult& part) {
    const auto one = [](const char* name, Unit unit, std::optional<double> value) {
        Characteristic c;
        c.name = name;
        c.method = "a method of several sections";
        c.unit = unit;
        c.value = value;
        c.nominal = 0.0;
        c.lower = -0.05;
        c.upper = 0.05;
        c.decision = value ? Decision::accept : Decision::not_evaluable;
        if (value) c.u95 = 0.004;
        return c;
    };
    part.characteristics = {{one("lean_x", Unit::mm, 0.0123), {}},
                            {one("relative_twist", Unit::rad, -0.02), part.sections.back().index},
                            {one("bow_y", Unit::mm, {}), part.sections.front().index}};
}

inline SectionResult open_section(std::size_t index) {
    auto good = section_at(index, 0.0);
    const auto nominal = synthetic::reference(synthetic::Section({}), 1.0);
    SectionResult raw;
    raw.index = index;
    raw.z_mm = good.z_mm;
    raw.points = std::move(good.points);
    EvaluationOptions options;
    options.profile_mm = 0.10;
    return evaluate_section(std::move(raw), core::fail(core::ErrorCode::fit_not_evaluable, "gap of 3.2 mm"), &nominal,
                            options);
}

}  // namespace cmm::acquisition
