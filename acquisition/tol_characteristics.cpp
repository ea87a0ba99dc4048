// SPDX-License-Identifier: Apache-2.0
#include "acquisition/tol_characteristics.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace cmm::acquisition {
namespace {

using Kind = CharacteristicKind;

constexpr double same_height_of_section_mm = 1e-3;

tl::unexpected<core::Error> wrong_at(const std::string& place, const std::string& what) {
    return core::fail(core::ErrorCode::input_invalid, place + what);
}

bool is_same_requirement(const CharacteristicSpec& a, const CharacteristicSpec& b) {
    return a.kind == b.kind && a.label == b.label && a.distance_mm == b.distance_mm && a.near_mm == b.near_mm &&
           a.far_mm == b.far_mm && a.nominal == b.nominal && a.below == b.below && a.above == b.above &&
           a.root == b.root && a.tip == b.tip && a.reference_section == b.reference_section &&
           a.fit_zones == b.fit_zones && a.le_change_mm == b.le_change_mm && a.te_change_mm == b.te_change_mm;
}

class TolSections {
  public:
    TolSections(const TolFile& tol, const NomFile* nom, std::span<const double> heights)
        : tol_(tol), nom_(nom), heights_(heights) {}

    core::Result<std::vector<CharacteristicSpec>> all() {
        if (auto status = check_names(); !status) return tl::unexpected(status.error());
        for (std::size_t i = 0; i < heights_.size(); ++i)
            if (auto status = add_section(i); !status) return tl::unexpected(status.error());
        for (auto& spec : specs_)
            if (spec.sections.size() == heights_.size()) spec.sections.clear();
        return std::move(specs_);
    }

  private:
    const NomSection* named(const std::string& name) const {
        if (nom_ == nullptr) return nullptr;
        const auto found = std::find_if(nom_->sections.begin(), nom_->sections.end(),
                                        [&](const NomSection& section) { return section.name == name; });
        return found == nom_->sections.end() ? nullptr : &*found;
    }
    const NomSection* at(std::size_t index) const {
        if (nom_ == nullptr) return nullptr;
        const auto found = std::find_if(nom_->sections.begin(), nom_->sections.end(), [&](const NomSection& section) {
            return std::abs(section.z_mm - heights_[index]) <= same_height_of_section_mm;
        });
        return found == nom_->sections.end() ? nullptr : &*found;
    }

    core::Status require_name(const std::string& name, const std::string& place) const {
        if (named(name) != nullptr) return {};
        if (nom_ == nullptr) return wrong_at(place, "sections have names only with a nominal of kind \"nom\"");
        std::string names;
        for (const auto& section : nom_->sections)
            names += (names.empty() ? "" : ", ") + section.name;
        return wrong_at(place, "the nominal has no section '" + name + "'; it has " + names);
    }

    core::Status check_names() const {
        if (nom_ != nullptr && tol_.sections && *tol_.sections != nom_->sections.size())
            return wrong_at(tol_.place, "NUM_SECT says " + std::to_string(*tol_.sections) +
                                            " sections, the nominal file has " + std::to_string(nom_->sections.size()));
        for (const auto& block : tol_.blocks) {
            if (!block.section.empty())
                if (auto status = require_name(block.section, block.place); !status) return status;
            for (const auto& entry : block.entries)
                if (!entry.section.empty())
                    if (auto status = require_name(entry.section, entry.place); !status) return status;
        }
        return {};
    }

    /// What holds for a section: the lines of its own, and those for all that it does not say itself.
    std::vector<const TolEntry*> entries_of(const std::string& name) const {
        std::vector<const TolEntry*> entries;
        for (const auto& block : tol_.blocks) {
            if (!block.section.empty() && block.section != name) continue;
            for (const auto& entry : block.entries) {
                const auto same = std::find_if(entries.begin(), entries.end(),
                                               [&](const TolEntry* known) { return known->keyword == entry.keyword; });
                if (same == entries.end())
                    entries.push_back(&entry);
                else
                    *same = &entry;
            }
        }
        return entries;
    }

    core::Status add_section(std::size_t index) {
        const NomSection* section = at(index);
        const auto entries = entries_of(section != nullptr ? section->name : "");
        for (const TolEntry* entry : entries) {
            if (entry->word != TolWord::calculation) continue;
            auto spec = spec_of(*entry, entries, section);
            if (!spec) return tl::unexpected(spec.error());
            if (auto status = add(std::move(*spec), *entry, index); !status) return status;
        }
        return {};
    }

    core::Status add(CharacteristicSpec spec, const TolEntry& entry, std::size_t index) {
        for (auto& known : specs_) {
            if (is_same_requirement(known, spec) && !known.is_of(index)) {
                known.sections.push_back(index);
                return {};
            }
            if (known.label == spec.label && known.is_of(index))
                return wrong_at(entry.place, entry.keyword + " asks for " + spec.label + " a second time");
        }
        spec.sections = {index};
        specs_.push_back(std::move(spec));
        return {};
    }

    core::Result<CharacteristicSpec> spec_of(const TolEntry& entry, const std::vector<const TolEntry*>& entries,
                                             const NomSection* section) const {
        CharacteristicSpec spec;
        spec.kind = *entry.kind;
        // Its default; the flavor file that may choose another is not read.
        spec.chord = fitting::ChordMethod::caliper;
        const auto find = [&](TolWord word) -> const TolEntry* {
            const auto found = std::find_if(entries.begin(), entries.end(), [&](const TolEntry* other) {
                return other->word == word && other->which == entry.which;
            });
            return found == entries.end() ? nullptr : *found;
        };
        const bool leading = spec.kind == Kind::le_thickness || spec.kind == Kind::le_angle;
        if (spec.kind == Kind::le_thickness || spec.kind == Kind::te_thickness) {
            const TolEntry* offset = find(leading ? TolWord::le_offset : TolWord::te_offset);
            if (offset != nullptr)
                spec.distance_mm = offset->numbers[0];
            else if (entry.which == 1 && section != nullptr && section->offsets_mm)
                spec.distance_mm = (*section->offsets_mm)[leading ? 0 : 1];
            else
                return wrong_at(entry.place, entry.keyword + " needs its distance from the edge: " +
                                                 (leading ? "LE_OFFSET" : "TE_OFFSET") +
                                                 (entry.which > 1 ? std::to_string(entry.which) : std::string()));
        }
        if (spec.kind == Kind::le_angle || spec.kind == Kind::te_angle) {
            const TolEntry* offsets = find(leading ? TolWord::le_angle_offsets : TolWord::te_angle_offsets);
            if (offsets == nullptr)
                return wrong_at(entry.place, entry.keyword + " needs the two distances of " +
                                                 (leading ? "LE_ANGOFFSET" : "TE_ANGOFFSET"));
            spec.near_mm = offsets->numbers[0];
            spec.far_mm = offsets->numbers[1];
        }
        if (is_profile_form(spec.kind)) {
            if (const TolEntry* change = find(TolWord::le_change)) spec.le_change_mm = change->numbers[0];
            if (const TolEntry* change = find(TolWord::te_change)) spec.te_change_mm = change->numbers[0];
        }
        if (is_of_part(spec.kind)) {
            if (auto status = end_of(find(TolWord::root_section), spec.root); !status)
                return tl::unexpected(status.error());
            if (auto status = end_of(find(TolWord::tip_section), spec.tip); !status)
                return tl::unexpected(status.error());
            if (auto status = end_of(find(TolWord::reference_section), spec.reference_section); !status)
                return tl::unexpected(status.error());
        }
        if (const TolEntry* exclude = find(TolWord::exclude); exclude != nullptr && needs_best_fit(spec.kind)) {
            if (is_of_part(spec.kind) && !exclude->of_all)
                return wrong_at(exclude->place, "EXCLUDE1 of a single section: " + entry.keyword +
                                                    " compares sections, whose best fits have to be of the same sides");
            spec.fit_zones = exclude->fit_zones;
        }
        set_requirement(entry, spec);
        spec.label = label_of(spec, spec.kind == Kind::chord ? "tangent" : "");
        return spec;
    }

    core::Status end_of(const TolEntry* entry, std::optional<std::size_t>& end) const {
        if (entry == nullptr) return {};
        const double z_mm = named(entry->section)->z_mm;
        for (std::size_t i = 0; i < heights_.size(); ++i)
            if (std::abs(heights_[i] - z_mm) <= same_height_of_section_mm) end = i;
        if (end) return {};
        return wrong_at(entry->place, "section " + entry->section + " is not among the heights that are measured");
    }

    static void set_requirement(const TolEntry& entry, CharacteristicSpec& spec) {
        const double upper = entry.numbers[0], lower = entry.numbers[1];
        if (is_zone_width(spec.kind)) {
            spec.nominal = 0.0;
            spec.above = upper;
            return;
        }
        spec.nominal = entry.nominal;
        if (entry.are_limits && !spec.nominal) spec.nominal = 0.5 * (upper + lower);
        const double from = entry.are_limits ? *spec.nominal : 0.0;
        spec.below = lower - from;
        spec.above = upper - from;
    }

    const TolFile& tol_;
    const NomFile* nom_;
    std::span<const double> heights_;
    std::vector<CharacteristicSpec> specs_;
};

}  // namespace

core::Result<std::vector<CharacteristicSpec>> characteristics_of(const TolFile& tol, const NomFile* nom,
                                                                 std::span<const double> heights_mm) {
    return TolSections(tol, nom, heights_mm).all();
}

}  // namespace cmm::acquisition
