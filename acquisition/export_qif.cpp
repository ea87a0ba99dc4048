// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "acquisition/exports.hpp"
#include "acquisition/listed_characteristic.hpp"
#include "acquisition/svg.hpp"
#include "core/text.hpp"

namespace cmm::acquisition {
namespace {

using svg::escape;

constexpr int decimals = 6;  // a nanometre, a microradian
constexpr int curvature_decimals = 9;
constexpr const char* section_normal = "0 0 1";
constexpr double coverage_factor = 2;  // of U95, as the report states it

std::string element(std::string_view name, const std::string& content) {
    return "<" + std::string(name) + ">" + content + "</" + std::string(name) + ">";
}

std::string list(std::string_view name, const std::vector<std::string>& items) {
    std::string text = "<" + std::string(name) + " n=\"" + std::to_string(items.size()) + "\">\n";
    for (const auto& item : items)
        text += item + "\n";
    return text + "</" + std::string(name) + ">\n";
}

/// Stands for the text, always the same (FNV-1a, Fowler, Noll, Vo 1991, from four different starts).
std::string persistent_id(std::string_view text) {
    std::array<std::uint32_t, 4> words{};
    for (std::uint32_t k = 0; k < words.size(); ++k) {
        words[k] = 2166136261U ^ (k * 0x9e3779b9U);
        for (const char c : text)
            words[k] = (words[k] ^ static_cast<unsigned char>(c)) * 16777619U;
    }
    char out[37];
    std::snprintf(out, sizeof out, "%08x-%04x-%04x-%04x-%04x%08x", words[0], words[1] >> 16U, words[1] & 0xffffU,
                  words[2] >> 16U, words[2] & 0xffffU, words[3]);
    return out;
}

constexpr std::string_view own_unit = "UserDefinedUnit";

/// What QIF calls the characteristic: the beginning of the names of its four elements. None: a number in a unit that
/// QIF does not have is one with a nominal and limits.
std::optional<std::string_view> kind_of(const Characteristic& one) {
    switch (one.unit) {
        case Unit::mm:
            if (one.name.starts_with("profile_") && one.upper) return "LineProfile";
            return one.name.ends_with("_radius") ? "Radius" : "UserDefinedLinear";
        case Unit::rad:
            return "UserDefinedAngular";
        case Unit::mm2:
            return "UserDefinedArea";
        case Unit::per_mm:
        case Unit::share:
        case Unit::count:
            return one.nominal && one.has_limits() ? std::optional(own_unit) : std::nullopt;
    }
    return std::nullopt;
}

/// Of units that QIF does not have: what is measured, and their name.
std::pair<const char*, const char*> own_unit_of(Unit unit) {
    if (unit == Unit::per_mm) return {"curvature", "1/mm"};
    return unit == Unit::count ? std::pair{"number of points", "points"} : std::pair{"share of a length", "1"};
}

std::string number(double value, const Characteristic& one) {
    return core::fixed(value, one.unit == Unit::per_mm ? curvature_decimals : decimals);
}

/// A unit by its name and how many of SI's it is.
std::string unit(std::string_view kind, const char* si, const char* name, const char* factor) {
    return element(kind, element("SIUnitName", si) + element("UnitName", name) +
                             element("UnitConversion", element("Factor", factor)));
}

std::string_view status_of(Decision decision) {
    switch (decision) {
        case Decision::accept:
            return "PASS";
        case Decision::reject:
            return "FAIL";
        case Decision::undecided:
            return "INDETERMINATE";
        case Decision::reported:
            return "NOT_ANALYZED";
        case Decision::not_evaluable:
            return "UNDEFINED";
    }
    return "UNDEFINED";
}

std::string inspection_status(const PartResult& part) {
    if (!part.has_requirements()) return "NOT_CALCULATED";
    const Decision verdict = part.verdict();
    return verdict == Decision::accept ? "PASS" : verdict == Decision::reject ? "FAIL" : "UNKNOWN";
}

/// One document: definitions (what is asked for, one for all sections alike), nominals and items (where), measurements.
class QifDocument {
  public:
    explicit QifDocument(const PartResult& part) : part_(part) {}

    std::string text() {
        const int standard = next_id(), rule = next_id(), component = next_id(), results = next_id();
        for (const auto& listed : all_characteristics(part_))
            add(listed.name, *listed.number, component);
        std::string body =
            element("Header", element("Application", element("Name", escape(part_.software_version)))) + "\n" +
            list("StandardsDefinitions", {iso_1101(standard), iso_14253(rule)}) +
            element("FileUnits", element("PrimaryUnits", unit("AreaUnit", "square meter", "mm2", "0.000001") +
                                                             unit("AngularUnit", "radian", "rad", "1") +
                                                             unit("LinearUnit", "meter", "mm", "0.001")) +
                                     own_units()) +
            "\n";
        if (!measurements_.empty())
            body += "<Characteristics>\n" + element("FormalStandardId", std::to_string(standard)) + "\n" +
                    list("CharacteristicDefinitions", definitions_) + list("CharacteristicNominals", nominals_) +
                    list("CharacteristicItems", items_) + "</Characteristics>\n";
        const std::string status =
            element("InspectionStatus", element("InspectionStatusEnum", inspection_status(part_)));
        std::string measured =
            "<MeasurementResults id=\"" + std::to_string(results) + "\">\n" +
            element("InspectionTraceability", element("ReportNumber", escape(part_.run_id)) + inspection_start()) +
            "\n";
        if (!measurements_.empty())
            measured += "<MeasuredCharacteristics>\n" + list("CharacteristicMeasurements", measurements_) +
                        "</MeasuredCharacteristics>\n";
        measured += status + "\n</MeasurementResults>";
        const std::string piece = "<ActualComponent id=\"" + std::to_string(component) + "\">" +
                                  element("SerialNumber", escape(part_.part_serial)) +
                                  element("Status", element("InspectionStatusEnum", inspection_status(part_))) +
                                  "</ActualComponent>";
        body += "<Results>\n" + list("MeasurementResultsSet", {measured}) +
                list("ActualComponentSets", {list("ActualComponentSet", {piece})}) + "</Results>\n";
        return "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<QIFDocument xmlns=\"http://qifstandards.org/xsd/qif3\" "
               "versionQIF=\"3.0.0\" idMax=\"" +
               std::to_string(last_id_) + "\">\n" + element("QPId", persistent_id(body)) + "\n" + body +
               "</QIFDocument>\n";
    }

  private:
    int next_id() { return ++last_id_; }

    /// Of point files nobody knows when they were measured, and a time must not be empty.
    std::string inspection_start() const {
        return part_.started_utc.empty() ? "" : element("InspectionStart", escape(part_.started_utc));
    }

    static std::string standard(int id, std::string_view designator, std::string_view title) {
        return "<Standard id=\"" + std::to_string(id) + "\">" +
               element("Organization", element("StandardsOrganizationEnum", "ISO")) +
               element("Designator", std::string(designator)) + element("Title", std::string(title)) + "</Standard>";
    }
    static std::string iso_1101(int id) { return standard(id, "ISO 1101", "Geometrical tolerancing"); }
    static std::string iso_14253(int id) {
        return standard(id, "ISO 14253-1", "Decision rules for verifying conformity or nonconformity");
    }

    static std::string open(std::string_view kind, std::string_view aspect, int id) {
        return "<" + std::string(kind) + "Characteristic" + std::string(aspect) + " id=\"" + std::to_string(id) + "\">";
    }
    static std::string close(std::string_view kind, std::string_view aspect) {
        return "</" + std::string(kind) + "Characteristic" + std::string(aspect) + ">";
    }

    std::string own_units() const {
        std::vector<std::string> units;
        for (const Unit unit : own_units_) {
            const auto [measured, name] = own_unit_of(unit);
            units.push_back(
                element("UserDefinedUnit", element("WhatIsMeasured", measured) + element("UnitName", name)));
        }
        return units.empty() ? std::string() : list("UserDefinedUnits", units);
    }

    /// With its unit where that is none of QIF's; `more`: attributes.
    static std::string value(std::string_view name, std::string_view kind, const Characteristic& one, double value,
                             const std::string& more = "") {
        const std::string unit =
            kind == own_unit ? " unitName=\"" + std::string(own_unit_of(one.unit).second) + "\"" : "";
        return "<" + std::string(name) + more + unit + ">" + number(value, one) + "</" + std::string(name) + ">";
    }

    static std::string limits(std::string_view kind, const Characteristic& one) {
        std::string text;
        if (one.upper) text += value("MaxValue", kind, one, *one.upper);
        if (one.lower) text += value("MinValue", kind, one, *one.lower);
        return text + element("DefinedAsLimit", "true");
    }

    /// The same for all sections that ask for the same.
    int definition_of(std::string_view kind, const Characteristic& one) {
        std::string text = element("Description", escape(one.method)) + element("Name", escape(one.name));
        if (kind == "LineProfile") {
            text += element("ToleranceValue", core::fixed(*one.upper, decimals));
        } else if (kind != own_unit) {
            text += one.has_limits() ? element("Tolerance", limits(kind, one)) : element("NonTolerance", "MEASURED");
            if (kind.starts_with("User")) text += element("WhatToMeasure", escape(one.name));
        }
        text += close(kind, "Definition");
        if (const auto known = known_.find(text); known != known_.end()) return known->second;
        const int id = next_id();
        definitions_.push_back(open(kind, "Definition", id) + text);
        known_.emplace(std::move(text), id);
        return id;
    }

    void add(const std::string& listed_name, const Characteristic& one, int component) {
        const auto has_kind = kind_of(one);
        if (!has_kind) return;
        const auto kind = *has_kind;
        if (kind == own_unit) own_units_.insert(one.unit);
        const int definition = definition_of(kind, one), nominal = next_id(), item = next_id(), measured = next_id();
        const std::string name = element("Name", escape(listed_name));
        nominals_.push_back(open(kind, "Nominal", nominal) +
                            element("CharacteristicDefinitionId", std::to_string(definition)) + name +
                            (one.nominal ? value("TargetValue", kind, one, *one.nominal) : "") +
                            (kind == "LineProfile" ? element("Vector", section_normal) : "") +
                            (kind == own_unit ? limits(kind, one) : "") + close(kind, "Nominal"));
        items_.push_back(open(kind, "Item", item) + name + element("CharacteristicNominalId", std::to_string(nominal)) +
                         close(kind, "Item"));
        std::string text = open(kind, "Measurement", measured);
        if (!one.note.empty()) text += element("Description", escape(one.note));
        text += element("Status", element("CharacteristicStatusEnum", std::string(status_of(one.decision)))) +
                element("CharacteristicItemId", std::to_string(item)) +
                element("ActualComponentId", std::to_string(component));
        if (one.value) {
            const std::string uncertainty =
                one.u95 ? " combinedUncertainty=\"" + number(*one.u95 / coverage_factor, one) + "\"" : "";
            text += value("Value", kind, one, *one.value, uncertainty);
        }
        measurements_.push_back(text + close(kind, "Measurement"));
    }

    const PartResult& part_;
    int last_id_ = 0;
    std::map<std::string, int> known_;
    std::set<Unit> own_units_;
    std::vector<std::string> definitions_, nominals_, items_, measurements_;
};

}  // namespace

std::string qif_xml(const PartResult& part) {
    return QifDocument(part).text();
}

core::Status export_qif(const PartResult& part, const std::string& file) {
    return core::write_file(file, qif_xml(part));
}

}  // namespace cmm::acquisition
