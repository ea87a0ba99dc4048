// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cctype>
#include <cmath>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "acquisition/exports.hpp"
#include "acquisition/part_frame.hpp"
#include "acquisition/profile.hpp"
#include "core/text.hpp"
#include "core/units.hpp"
#include "fitting/vec2.hpp"

namespace cmm::acquisition {
namespace {

using Eigen::Vector2d;

constexpr int dmis_decimals = 6;
constexpr std::size_t longest_dmis_line = 80;
constexpr std::size_t longest_dmis_label = 64;

std::string dmis_number(double value) {
    return core::fixed(value, dmis_decimals);
}

/// Letters, digits and '_'; others become '_'.
std::string dmis_label(std::string_view name) {
    std::string label;
    for (const char c : name.substr(0, longest_dmis_label)) {
        const auto byte = static_cast<unsigned char>(c);
        label += std::isalnum(byte) != 0 && byte < 0x80 ? static_cast<char>(std::toupper(byte)) : '_';
    }
    return label;
}

/// In apostrophes, printable ASCII; an apostrophe within becomes a grave accent.
std::string dmis_text(std::string_view text) {
    std::string out = "'";
    for (const char c : text)
        out += c == '\'' ? '`' : static_cast<unsigned char>(c) < 0x20 || static_cast<unsigned char>(c) > 0x7e ? '?' : c;
    return out + "'";
}

/// Statements and remarks on lines of at most 80 characters: '$' at the end of a line means that the next one goes on,
/// each line of a remark begins like one. A longer text in apostrophes is not broken.
class DmisText {
  public:
    void statement(std::string_view text) {
        while (text.size() > longest_dmis_line) {
            // At a comma, and not within a text.
            std::size_t cut = 0;
            bool quoted = false;
            for (std::size_t i = 0; i < text.size() && (cut == 0 || i < longest_dmis_line - 1); ++i) {
                if (text[i] == '\'') quoted = !quoted;
                if (text[i] == ',' && !quoted) cut = i + 1;
            }
            if (cut == 0 || cut == text.size()) break;
            text_.append(text.substr(0, cut));
            text_ += "$\r\n";
            text.remove_prefix(cut);
        }
        text_.append(text);
        text_ += "\r\n";
    }
    void remark(const std::string& text) {
        const auto quoted = dmis_text(text);
        std::string_view left = std::string_view(quoted).substr(1, quoted.size() - 2);
        const std::size_t room = longest_dmis_line - remark_mark.size();
        while (left.size() > room) {
            const std::size_t blank = left.rfind(' ', room);
            const bool at_blank = blank != std::string_view::npos && blank > 0;
            remark_line(left.substr(0, at_blank ? blank : room));
            left.remove_prefix(at_blank ? blank + 1 : room);
        }
        remark_line(left);
    }
    std::string finish() && { return std::move(text_); }

  private:
    static constexpr std::string_view remark_mark = "$$ ";
    void remark_line(std::string_view text) {
        text_ += remark_mark;
        text_ += text;
        text_ += "\r\n";
    }

    std::string text_;
};

std::string with_commas(std::initializer_list<double> numbers) {
    std::string text;
    for (const double number : numbers)
        text += "," + dmis_number(number);
    return text;
}

/// Of an angle in degrees, as UNITS says.
double in_dmis_unit(const Characteristic& one, double number) {
    return one.unit == Unit::rad ? core::deg_from_rad(number) : number;
}

std::string decision_remark(const Characteristic& one) {
    std::string text = one.name + ": " + std::string(to_string(one.decision));
    if (one.value) text += ", " + dmis_number(in_dmis_unit(one, *one.value));
    if (one.u95) text += ", U95 " + dmis_number(in_dmis_unit(one, *one.u95));
    text += ", " + one.method;
    if (one.decision == Decision::not_evaluable) text += ": " + one.note;
    return text;
}

/// Extreme deviations of a zone; none where nothing is compared.
struct Deviations {
    double lowest = 0.0, highest = 0.0;
};
std::optional<Deviations> deviations_of(const SectionResult& section, fitting::Zone zone) {
    std::optional<Deviations> found;
    for (std::size_t i = 0; i < section.deviation_mm.size(); ++i) {
        const auto& d = section.deviation_mm[i];
        if (!d || section.fit->contour[i].zone != zone) continue;
        if (!found) found = Deviations{*d, *d};
        found->lowest = std::min(found->lowest, *d);
        found->highest = std::max(found->highest, *d);
    }
    return found;
}

/// Of the area within; it does not depend on where the points are dense.
Vector2d centre_of_area(const std::vector<Vector2d>& outline) {
    double doubled = 0.0;
    Vector2d first = Vector2d::Zero();
    for (std::size_t i = 0; i < outline.size(); ++i) {
        const Vector2d a = outline[i] - outline[0], b = outline[(i + 1) % outline.size()] - outline[0];
        const double triangle = fitting::cross(a, b);
        doubled += triangle;
        first += triangle / 3.0 * (a + b);
    }
    return outline[0] + first / doubled;
}

class DmisDocument {
  public:
    explicit DmisDocument(const PartResult& part) : part_(part) {}

    std::string text() && {
        out_.statement("FILNAM/" + dmis_text(part_.run_id) + ",05.2");
        date();
        out_.statement("UNITS/MM,ANGDEC");
        out_.statement("PN(PART)=PARTID/" + dmis_text(part_.part_name));
        if (!part_.part_serial.empty()) out_.statement("PS(PART)=PARTSN/" + dmis_text(part_.part_serial));
        out_.statement("DV(MACHINE)=DMEID/" + dmis_text(part_.machine));
        out_.statement("DS(PROGRAM)=DMESWI/" + dmis_text(part_.software_version));
        out_.remark("decision rule: " + part_.decision_rule);
        if (part_.part_frame) out_.remark("part frame: " + part_frame_words(*part_.part_frame));
        if (const auto* alignment = part_.alignment()) out_.remark("alignment: " + frame_words(alignment->spec));
        for (const auto& section : part_.sections)
            add(section);
        for (const auto& [one, index] : part_.characteristics)
            tolerance(one, dmis_label(one.name) + (index ? "_" + std::to_string(*index) : ""), nullptr);
        out_.statement("ENDFIL");
        return std::move(out_).finish();
    }

  private:
    /// "2026-11-23T09:11:36Z"
    void date() {
        const auto& utc = part_.started_utc;
        if (utc.size() != 20 || utc[4] != '-' || utc[10] != 'T') return;
        out_.statement("DATE=" + utc.substr(0, 4) + "/" + utc.substr(5, 2) + "/" + utc.substr(8, 2));
        out_.statement("TIME=" + utc.substr(11, 8));
    }

    void add(const SectionResult& section) {
        const std::string number = std::to_string(section.index);
        if (!section.has_contour()) {
            out_.remark("section " + number + " z " + core::fixed(section.z_mm, 3) + ": " + section.why);
        } else {
            std::vector<Vector2d> contour;
            for (const auto& point : section.fit->contour)
                contour.push_back(point.position_mm);
            const auto curve = [&](const char* kind, const Vector2d& at) {
                out_.statement(std::string(kind) + "(SECT_" + number + ")=FEAT/GCURVE,CART" +
                               with_commas({at.x(), at.y(), section.z_mm, 0.0, 0.0, 1.0}));
            };
            if (!section.nominal_contour.empty()) curve("F", centre_of_area(section.nominal_contour));
            if (section.gaps().empty())
                curve("FA", centre_of_area(contour));
            else
                out_.remark("section " + number + ": a part of it was not measured, hence it has no middle");
            edge("LE_" + number, section.fit->le, section.z_mm);
            edge("TE_" + number, section.fit->te, section.z_mm);
        }
        for (const auto& one : section.characteristics)
            tolerance(one, dmis_label(one.name) + "_" + number, &section);
    }

    void edge(const std::string& label, const fitting::EdgeFit& edge, double z_mm) {
        if (!edge.valid) return;
        out_.statement(
            "FA(" + label + ")=FEAT/CIRCLE,OUTER,CART" +
            with_commas({edge.centre_mm.x(), edge.centre_mm.y(), z_mm, 0.0, 0.0, 1.0, 2.0 * edge.radius_mm}));
    }

    /// DMIS knows in and out: what is not accepted is out, a remark says whether it is rejected or undecided.
    void tolerance(const Characteristic& one, const std::string& label, const SectionResult* section) {
        out_.remark(decision_remark(one));
        if (!one.has_limits() || !one.value || one.decision == Decision::not_evaluable) return;
        const std::string state = one.decision == Decision::accept ? ",INTOL" : ",OUTOL";
        for (const auto& zone : profile_zones) {
            if (section == nullptr || one.name != zone.name) continue;
            const auto found = deviations_of(*section, zone.zone);
            if (!found) return;
            out_.statement("T(" + label + ")=TOL/PROFL" + with_commas({-0.5 * *one.upper, 0.5 * *one.upper}));
            out_.statement("TA(" + label + ")=TOL/PROFL" + with_commas({found->lowest, found->highest}) + state);
            return;
        }
        const double nominal = in_dmis_unit(one, one.nominal.value_or(0.0));
        const auto from_nominal = [&](const std::optional<double>& limit) {
            return limit ? dmis_number(in_dmis_unit(one, *limit) - nominal) : std::string();
        };
        const std::string limits = "," + from_nominal(one.lower) + "," + from_nominal(one.upper);
        const std::string deviation = "," + dmis_number(in_dmis_unit(one, *one.value) - nominal) + state;
        if (one.name == "le_radius" || one.name == "te_radius") {
            out_.statement("T(" + label + ")=TOL/RAD" + limits);
            out_.statement("TA(" + label + ")=TOL/RAD" + deviation);
            return;
        }
        out_.statement("T(" + label + ")=TOL/USETOL," + dmis_text(one.name) + limits + "," + dmis_number(nominal));
        out_.statement("TA(" + label + ")=TOL/USETOL," + dmis_text(one.name) + deviation);
    }

    const PartResult& part_;
    DmisText out_;
};

}  // namespace

std::string dmis_output(const PartResult& part) {
    return DmisDocument(part).text();
}

core::Status export_dmis(const PartResult& part, const std::string& file) {
    return core::write_file(file, dmis_output(part));
}

}  // namespace cmm::acquisition
