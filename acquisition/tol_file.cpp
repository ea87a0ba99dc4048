// SPDX-License-Identifier: Apache-2.0
#include "acquisition/tol_file.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "acquisition/delimited_file.hpp"
#include "acquisition/keyword_file.hpp"
#include "core/text.hpp"
#include "core/units.hpp"

namespace cmm::acquisition {
namespace {

constexpr std::size_t most_of_a_kind = 10;  // LETHCK2 to LETHCK10
constexpr double largest_tolerance = 1e5;   // mm or degrees

struct KnownWord {
    std::string_view name;
    TolWord word;
    bool numbered = false;
};
constexpr std::array known_words{KnownWord{"LE_OFFSET", TolWord::le_offset, true},
                                 KnownWord{"TE_OFFSET", TolWord::te_offset, true},
                                 KnownWord{"LE_ANGOFFSET", TolWord::le_angle_offsets},
                                 KnownWord{"TE_ANGOFFSET", TolWord::te_angle_offsets},
                                 KnownWord{"LE_CHANGE", TolWord::le_change},
                                 KnownWord{"TE_CHANGE", TolWord::te_change},
                                 KnownWord{"ROOTSECT", TolWord::root_section},
                                 KnownWord{"TIPSECT", TolWord::tip_section},
                                 KnownWord{"REFSECT", TolWord::reference_section},
                                 KnownWord{"EXCLUDE1", TolWord::exclude},
                                 KnownWord{"CHORD", TolWord::calculation},
                                 KnownWord{"CHDANG", TolWord::calculation},
                                 KnownWord{"MAXTHK", TolWord::calculation},
                                 KnownWord{"LETHCK", TolWord::calculation, true},
                                 KnownWord{"TETHCK", TolWord::calculation, true},
                                 KnownWord{"LEANGLE", TolWord::calculation},
                                 KnownWord{"TEANGLE", TolWord::calculation},
                                 KnownWord{"TWIST", TolWord::calculation},
                                 KnownWord{"RELTWIST", TolWord::calculation},
                                 KnownWord{"LECONT", TolWord::calculation},
                                 KnownWord{"TECONT", TolWord::calculation},
                                 KnownWord{"CVCONT", TolWord::calculation},
                                 KnownWord{"CCCONT", TolWord::calculation},
                                 KnownWord{"BOWT", TolWord::calculation}};

/// Words of the field's help that nothing here answers to: most belong to a method or a best fit that a flavor file
/// chooses, which is not read.
struct OtherWord {
    std::string_view name, instead;
    std::size_t from = 1, to = 1;  ///< numbers that may follow it
};
constexpr std::string_view edge_arc =
    "it is the ring of points of a best fit by an edge's arc (LEARC, TEARC), which a flavor file chooses; the best fit "
    "here is of all zones but those of EXCLUDE1";
constexpr std::string_view across_camber =
    "it is the zone of the methods SQUARE and OFFSETFLAT, which a flavor file chooses; thicknesses are measured by "
    "their defaults, TIPARC and NORMAL, across the camber line";
constexpr std::string_view first_fit = "it is of a second best fit, which a flavor file says; EXCLUDE1 is evaluated";
constexpr std::string_view from_x = "angles are from +x of the part frame; write the nominal that follows from it";
constexpr std::array other_words{
    OtherWord{"LE_RADII", edge_arc},
    OtherWord{"TE_RADII", edge_arc},
    OtherWord{"LE_FLAT_SIZE", across_camber, 1, most_of_a_kind},
    OtherWord{"TE_FLAT_SIZE", across_camber, 1, most_of_a_kind},
    OtherWord{"ROOTANG", from_x},
    OtherWord{"ROOTANGSECT", from_x},
    OtherWord{"RELTWIST", "which section or datum it is relative to is in a flavor file; RELTWIST is evaluated", 2, 2},
    OtherWord{"EXCLUDE", first_fit, 2, 5}};

struct NumberedWord {
    std::string name;
    std::size_t which = 1;
};

/// LETHCK2 is the second LETHCK.
NumberedWord without_number(const std::string& keyword) {
    const auto letters = keyword.find_last_not_of("0123456789") + 1;
    const auto number = core::parse_number(std::string_view(keyword).substr(letters));
    if (!number || *number < 2.0 || *number > static_cast<double>(most_of_a_kind)) return {keyword, 1};
    return {keyword.substr(0, letters), static_cast<std::size_t>(*number)};
}

class TolReader {
  public:
    TolReader(const KeywordFile& file, std::string name, std::span<const std::string> skip, bool inches)
        : file_(file), name_(std::move(name)), skip_(skip), scale_(inches ? mm_of_inch : 1.0) {
        tol_.blocks.emplace_back();
    }

    core::Result<TolFile> read() {
        for (const KeywordLine& line : file_.lines())
            if (auto status = read(line); !status) return tl::unexpected(status.error());
        return std::move(tol_);
    }

  private:
    std::string place_of(const KeywordLine& line) const { return place(name_, line.number, line.cells.front().column); }

    core::Status read(const KeywordLine& line) {
        const std::string keyword = line.keyword();
        if (keyword == "UNITS") {
            const auto inches = file_.inches(line);
            if (!inches) return tl::unexpected(inches.error());
            if (has_numbers_) return file_.wrong(line, 0, "UNITS must stand before the first length");
            if (units_ && *units_ != *inches) return file_.wrong(line, 1, "UNITS says something else than before");
            units_ = *inches;
            scale_ = *inches ? mm_of_inch : 1.0;
            return {};
        }
        if (keyword == "NUM_SECT") {
            const auto count = file_.count(line, 1, "NUM_SECT", 1, 10000);
            if (!count) return tl::unexpected(count.error());
            tol_.sections = *count;
            tol_.place = place_of(line);
            return file_.at_most(line, 2);
        }
        if (keyword == "SECTION") {
            const auto name = section_name(line);
            if (!name) return tl::unexpected(name.error());
            tol_.blocks.push_back({*name, place_of(line), {}});
            return file_.at_most(line, 2);
        }
        if (keyword == "SETSPEC" || keyword == "SETTOL") {
            are_limits_ = keyword == "SETSPEC";
            return file_.at_most(line, 1);
        }
        return entry(line, keyword);
    }

    core::Status entry(const KeywordLine& line, const std::string& keyword) {
        if (lists_word(skip_, keyword)) return {};
        const NumberedWord numbered = without_number(keyword);
        const auto known = std::find_if(known_words.begin(), known_words.end(), [&](const KnownWord& word) {
            return word.name == (word.numbered ? numbered.name : keyword);
        });
        if (known == known_words.end()) return not_known(line, keyword);
        TolEntry entry;
        entry.word = known->word;
        entry.keyword = keyword;
        entry.which = known->numbered ? numbered.which : 1;
        entry.place = place_of(line);
        entry.of_all = tol_.blocks.size() == 1;
        core::Status status;
        if (known->word == TolWord::calculation) {
            entry.kind = characteristic_kind_from(known->name);
            status = calculation(line, entry);
        } else if (known->word == TolWord::exclude) {
            status = excluded(line, entry);
        } else if (names_section(known->word)) {
            const auto name = section_name(line);
            if (!name) return tl::unexpected(name.error());
            entry.section = *name;
            status = file_.at_most(line, 2);
        } else {
            const bool two = known->word == TolWord::le_angle_offsets || known->word == TolWord::te_angle_offsets;
            status = offsets(line, two ? 2 : 1, entry);
        }
        if (!status) return status;
        auto& entries = tol_.blocks.back().entries;
        for (const auto& other : entries)
            if (other.keyword == entry.keyword)
                return file_.wrong(line, 0, keyword + " stands twice for the same sections");
        entries.push_back(std::move(entry));
        return {};
    }

    tl::unexpected<core::Error> not_known(const KeywordLine& line, const std::string& keyword) const {
        const auto letters = keyword.find_last_not_of("0123456789") + 1;
        const double number = core::parse_number(std::string_view(keyword).substr(letters)).value_or(1.0);
        const auto other = std::find_if(other_words.begin(), other_words.end(), [&](const OtherWord& word) {
            return word.name == keyword.substr(0, letters) && number >= static_cast<double>(word.from) &&
                   number <= static_cast<double>(word.to);
        });
        if (other != other_words.end())
            return file_.wrong(line, 0,
                               keyword + " is not evaluated: " + std::string(other->instead) +
                                   "; to go on without it, name it in skip of [tolerance]");
        std::vector<std::string_view> names{"UNITS", "NUM_SECT", "SECTION", "SETSPEC", "SETTOL"};
        for (const auto& word : known_words)
            names.push_back(word.name);
        const auto near = core::nearest_word(keyword, names);
        return file_.wrong(line, 0,
                           keyword.substr(0, 40) + " is not evaluated" +
                               (near ? " (did you mean " + *near + "?)" : "") +
                               "; to go on without it, name it in skip of [tolerance]");
    }

    core::Result<std::string> section_name(const KeywordLine& line) const {
        if (line.cells.size() < 2) return file_.wrong(line, 0, line.keyword() + " needs the name of a section");
        return std::string(line.cells[1].text);
    }

    static bool names_section(TolWord word) {
        return word == TolWord::root_section || word == TolWord::tip_section || word == TolWord::reference_section;
    }

    /// Bits of the sides that are left out: convex 1, concave 2, LE 4, TE 8 ("Exclusion Zones for Bestfit").
    core::Status excluded(const KeywordLine& line, TolEntry& entry) const {
        using fitting::Zone;
        constexpr std::array by_bit{Zone::suction, Zone::pressure, Zone::le, Zone::te};
        const auto bits = file_.count(line, 1, "EXCLUDE1", 0, 15);
        if (!bits) return tl::unexpected(bits.error());
        if (*bits == 15) return file_.wrong(line, 1, "all sides are left out of the best fit: nothing is left to fit");
        for (std::size_t k = 0; k < by_bit.size(); ++k)
            entry.fit_zones[static_cast<std::size_t>(by_bit[k])] = ((*bits >> k) & 1U) == 0;
        return file_.at_most(line, 2);
    }

    core::Status offsets(const KeywordLine& line, std::size_t count, TolEntry& entry) {
        for (std::size_t k = 1; k <= count; ++k) {
            const auto value = file_.number(line, k, "the distance");
            if (!value) return tl::unexpected(value.error());
            const double mm = *value * scale_;
            if (mm < 1e-3 || mm > largest_tolerance)
                return file_.wrong(line, k, "a distance must lie between 1 um and 100 m");
            entry.numbers.push_back(mm);
        }
        has_numbers_ = true;
        if (count == 2 && entry.numbers[1] <= entry.numbers[0])
            return file_.wrong(line, 2, "the second distance must be larger than the first");
        return file_.at_most(line, 1 + count);
    }

    core::Status calculation(const KeywordLine& line, TolEntry& entry) {
        const bool angle = unit_of(*entry.kind) == Unit::rad;
        for (std::size_t k = 1; k < std::max<std::size_t>(3, line.cells.size()); ++k) {
            const char* what = are_limits_ ? "the limit" : k == 1 ? "the upper tolerance" : "the lower tolerance";
            const auto value = file_.number(line, k, k == 3 ? "the nominal" : what);
            if (!value) return tl::unexpected(value.error());
            if (std::abs(*value) > largest_tolerance) return file_.wrong(line, k, "the number is too large");
            const double number = angle ? core::rad_from_deg(*value) : *value * scale_;
            if (k == 3)
                entry.nominal = number;
            else
                entry.numbers.push_back(number);
            if (k == 3) break;
        }
        has_numbers_ = has_numbers_ || !angle;
        entry.are_limits = are_limits_;
        // Limits come in either order, the larger one is the upper.
        if (are_limits_ && entry.numbers[0] < entry.numbers[1]) std::swap(entry.numbers[0], entry.numbers[1]);
        if (auto status = file_.at_most(line, 4); !status) return status;
        if (entry.numbers[0] <= entry.numbers[1])
            return file_.wrong(line, 1,
                               are_limits_ ? "the two limits are the same"
                                           : "the upper tolerance comes first and is above the lower one, each with "
                                             "its sign: CHORD 0.05 -0.05");
        if (is_zone_width(*entry.kind) && entry.numbers[1] != 0.0)
            return file_.wrong(line, are_limits_ ? 1 : 2,
                               line.keyword() + " is the full width of a zone: its lower tolerance is 0");
        return {};
    }

    const KeywordFile& file_;
    std::string name_;
    std::span<const std::string> skip_;
    double scale_;
    std::optional<bool> units_;  // inches, where the file says so
    bool are_limits_ = false, has_numbers_ = false;
    TolFile tol_;
};

}  // namespace

core::Result<TolFile> parse_tol(std::string_view content, const std::string& name, std::span<const std::string> skip,
                                bool inches) {
    const auto file = KeywordFile::read(content, name);
    if (!file) return tl::unexpected(file.error());
    return TolReader(*file, name, skip, inches).read();
}

}  // namespace cmm::acquisition
