// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "acquisition/exports.hpp"
#include "core/text.hpp"
#include "core/units.hpp"

namespace cmm::acquisition {
namespace {

constexpr int nanometre_digits = 6;
constexpr int unit_digits = 9;

std::string cell(double value) {
    return core::fixed(value, nanometre_digits);
}
std::string cell(const std::optional<double>& value) {
    return value ? cell(*value) : std::string();
}

struct CsvColumn {
    std::string name;
    Unit unit;
};

/// Names of all characteristics in the order in which they first appear.
std::vector<CsvColumn> characteristic_columns(const PartResult& part) {
    std::vector<CsvColumn> columns;
    for (const auto& section : part.sections) {
        for (const auto& c : section.characteristics) {
            const bool known = std::any_of(columns.begin(), columns.end(),
                                           [&](const CsvColumn& column) { return column.name == c.name; });
            if (!known) columns.push_back({c.name, c.unit});
        }
    }
    return columns;
}

/// In quotes where it needs them (RFC 4180).
std::string text_cell(const std::string& text) {
    if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
    std::string quoted = "\"";
    for (const char c : text)
        quoted.append(c == '"' ? 2 : 1, c);
    return quoted + '"';
}

std::string cell(const std::optional<double>& value, Unit unit) {
    return value && unit == Unit::rad ? cell(core::deg_from_rad(*value)) : cell(value);
}

/// Of the alignment, where the part has one: at the end of a row.
constexpr const char* alignment_columns =
    ",alignment,shift_x_mm,shift_x_standard_mm,shift_y_mm,shift_y_standard_mm,turn_deg,turn_standard_deg,alignment_rms_"
    "mm,"
    "alignment_condition,alignment_rounds";

std::string alignment_cells(const Alignment& alignment) {
    std::string out = "," + std::string(to_string(alignment.state));
    if (!alignment.done()) return out + std::string(9, ',');
    const auto standard = [&](Eigen::Index k) { return alignment.standard(k); };
    const auto& motion = alignment.motion;
    for (const double value :
         {motion.shift_mm.x(), standard(0), motion.shift_mm.y(), standard(1), core::deg_from_rad(motion.turn_rad),
          core::deg_from_rad(standard(2)), alignment.rms_mm, alignment.condition})
        out += ',' + cell(value);
    return out + ',' + std::to_string(alignment.rounds);
}

void append(std::string& out, const Eigen::Vector3d& p) {
    out += cell(p.x()) + ',' + cell(p.y()) + ',' + cell(p.z());
}

}  // namespace

std::string sections_csv(const PartResult& part) {
    const auto columns = characteristic_columns(part);
    std::string out = "index,z_mm,points,rejected,closed";
    for (const auto& [name, unit] : columns) {
        const std::string suffix(column_suffix(unit));
        for (const std::string& last : {suffix, "_u95" + suffix, std::string("_decision")})
            out.append(",").append(text_cell(name + last));
    }
    const bool aligned = part.alignment() != nullptr;
    if (aligned) out += alignment_columns;
    out += '\n';
    for (const auto& section : part.sections) {
        out += std::to_string(section.index) + ',' + cell(section.z_mm) + ',' + std::to_string(section.points.size()) +
               ',' + std::to_string(section.rejected()) + ',' + (section.all_round() ? '1' : '0');
        for (const auto& column : columns) {
            const auto* c = section.find(column.name);
            out += c == nullptr ? ",,,"
                                : ',' + cell(c->value, c->unit) + ',' + cell(c->u95, c->unit) + ',' +
                                      std::string(to_string(c->decision));
        }
        if (aligned) out += alignment_cells(section.alignment);
        out += '\n';
    }
    return out;
}

std::string part_csv(const PartResult& part) {
    std::string out = "name,section,unit,value,u95,nominal,lower,upper,decision\n";
    for (const auto& [c, section] : part.characteristics) {
        const bool angle = c.unit == Unit::rad;
        out += text_cell(c.name) + ',' + (section ? std::to_string(*section) : std::string()) + ',' +
               (angle ? "deg" : std::string(to_string(c.unit)));
        for (const auto& value : {c.value, c.u95, c.nominal, c.lower, c.upper})
            out += ',' + cell(value, c.unit);
        out += ',' + std::string(to_string(c.decision)) + '\n';
    }
    return out;
}

std::string section_csv(const SectionResult& section) {
    if (!section.has_contour()) return {};
    std::string out = "x_mm,y_mm,z_mm,nx,ny,nz,zone,deviation_mm,u95_mm\n";
    const auto& contour = section.fit->contour;
    for (std::size_t i = 0; i < contour.size(); ++i) {
        const auto& point = contour[i];
        if (!point.measured) continue;  // a gap is a gap
        append(out, {point.position_mm.x(), point.position_mm.y(), section.z_mm});
        const double lean_rad = point.lean_rad.value_or(0.0);  // unknown: the normal lies in the plane
        const Eigen::Vector2d level = std::cos(lean_rad) * point.normal;
        out += ',' + core::fixed(level.x(), unit_digits) + ',' + core::fixed(level.y(), unit_digits) + ',' +
               (point.lean_rad ? core::fixed(std::sin(lean_rad), unit_digits) : "0") + ',' +
               std::string(fitting::to_string(point.zone)) + ',';
        if (i < section.deviation_mm.size() && section.deviation_mm[i]) out += cell(*section.deviation_mm[i]);
        out += ',' + cell(section.deviation_u95_mm(i)) + '\n';
    }
    return out;
}

std::string points_csv(const PartResult& part) {
    const bool again = std::any_of(part.sections.begin(), part.sections.end(),
                                   [](const SectionResult& section) { return !points_of_passes(section).empty(); });
    std::string out = again ? "section,seq,x_mm,y_mm,z_mm,flag,pass\n" : "section,seq,x_mm,y_mm,z_mm,flag\n";
    for (const auto& section : part.sections) {
        for (const auto& point : section.points) {
            out += std::to_string(section.index) + ',' + std::to_string(point.sequence) + ',';
            append(out, point.centre_mm);
            out += ',' + std::to_string(point.flags);
            if (again) out += ',' + std::to_string(point.pass);
            out += '\n';
        }
    }
    return out;
}

std::string rejected_csv(const PartResult& part) {
    std::string out = "section,seq,x_mm,y_mm,z_mm,residual_mm,reason\n";
    for (const auto& section : part.sections) {
        for (const auto& point : section.points) {
            if (point.verdict.reason == fitting::RejectReason::none) continue;
            out += std::to_string(section.index) + ',' + std::to_string(point.sequence) + ',';
            append(out, point.centre_mm);
            out += ',' + cell(point.verdict.residual_mm) + ',' + std::string(fitting::to_string(point.verdict.reason)) +
                   '\n';
        }
    }
    return out;
}

}  // namespace cmm::acquisition
