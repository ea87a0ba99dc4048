// SPDX-License-Identifier: Apache-2.0
// `cmmlive config explain` against the readers: whatever they ask for is explained, and nothing else.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <regex>
#include <set>
#include <sstream>

#include "acquisition/characteristic_spec.hpp"
#include "acquisition/part_file.hpp"
#include "core/config.hpp"
#include "core/text.hpp"
#include "drivers/machine_file.hpp"
#include "sim/machine_file.hpp"
#include "sim/surface.hpp"
#include "tests/support/process.hpp"

namespace cmm::test {
namespace {

using Tables = std::map<std::string, std::set<std::string>>;

/// Words of each [table] and [[list]] of the text, without what stands in quotes or parentheses.
Tables explained_by_the_program() {
    std::string text = run({cmmlive(), "config", "explain"}).out;
    text = std::regex_replace(text, std::regex("\"[^\"]*\"|\\([^)]*\\)"), "");
    Tables tables;
    const std::regex table("\\[+([a-z.]+)\\]+([^\\[]*)"), word("[a-z][a-z0-9_]*\\*?");
    for (auto at = std::sregex_iterator(text.begin(), text.end(), table); at != std::sregex_iterator(); ++at) {
        const std::string body = (*at)[2];
        for (auto w = std::sregex_iterator(body.begin(), body.end(), word); w != std::sregex_iterator(); ++w)
            tables[(*at)[1]].insert(w->str());
    }
    return tables;
}

void take(const core::ConfigTable& root, Tables& known) {
    for (std::string name : root.known()) {
        name = std::regex_replace(name, std::regex("\\[[0-9]+\\]"), "");
        const auto dot = name.rfind('.');
        if (dot != std::string::npos && name.substr(dot) != ".*")
            known[name.substr(0, dot)].insert(name.substr(dot + 1));
    }
}

core::ConfigTable parsed(const std::string& text) {
    const auto root = core::ConfigTable::parse(text, "p.toml");
    EXPECT_TRUE(root) << root.error().text();
    return *root;
}

/// Everything that the readers of part files ask for, in all kinds of parts. Keys that are read only where they stand
/// are there.
Tables asked_of_part_files() {
    Tables known;
    std::string characteristics;
    for (auto k = acquisition::CharacteristicKind::chord; k <= acquisition::CharacteristicKind::generatrix;
         k = static_cast<acquisition::CharacteristicKind>(static_cast<int>(k) + 1))
        characteristics +=
            "[[characteristic]]\nname = \"" + std::string(acquisition::to_string(k)) +
            "\"\nle_change_mm = 1\nte_change_mm = 1\nwidth_mm = 1\narc_deg = 90\nreach_mm = 1\nfit_zones = [\"le\"]\n";
    characteristics += "[[characteristic]]\nname = \"chord\"\nmethod = \"BELAC\"\n";
    for (const std::string kind : {"sections", "parametric", "none", "step", "nom", "mesh"}) {
        const auto root = parsed("[nominal]\nkind = \"" + kind +
                                 "\"\n[[alignment.point]]\nopposite_mm = [0, 0, 0]\nopposite_direction = [0, 0, 1]\n" +
                                 characteristics);
        EXPECT_FALSE(acquisition::read_part_file(root)) << "a name is missing";
        take(root, known);
    }
    for (const std::string kind : {"nominal", "parametric", "sections"}) {
        const auto root = parsed("[actual]\nkind = \"" + kind + "\"\n[actual.blade]\nstagger_tip_deg = 1\n");
        EXPECT_FALSE(sim::read_part(root)) << "a name is missing";
        take(root, known);
    }
    return known;
}

Tables asked_of_machine_files() {
    const std::string limits = "limit_min_mm = [-1, -1, -1]\nlimit_max_mm = [1, 1, 1]\n";
    Tables known;
    for (const std::string url : {"modbus+tcp://a:1", "dro+serial:///dev/a", "linuxcnc://a:1"}) {
        const auto root = parsed("[link]\nurl = \"" + url + "\"\n[linuxcnc]\n" + limits);
        static_cast<void>(drivers::read_link_settings(root));
        take(root, known);
    }
    const auto root = parsed("[controller]\nhome_mm = [0, 0, 0]\n" + limits);
    EXPECT_TRUE(sim::read_machine_settings(root));
    take(root, known);
    return known;
}

/// nominal_* stands for nominal_mm, ...
bool is_among(const std::string& key, const std::set<std::string>& words) {
    return std::any_of(words.begin(), words.end(), [&](const std::string& word) {
        return word == key || (word.ends_with('*') && key.starts_with(word.substr(0, word.size() - 1)));
    });
}

void expect_the_same(const Tables& explained, const Tables& known) {
    for (const auto& [table, keys] : known) {
        ASSERT_TRUE(explained.contains(table)) << "[" << table << "] is not explained";
        for (const auto& key : keys)
            EXPECT_TRUE(is_among(key, explained.at(table))) << table << "." << key << " is not explained";
    }
    for (const auto& [table, words] : explained) {
        if (!known.contains(table)) continue;
        for (const auto& word : words) {
            if (word.find('_') == std::string::npos || word.ends_with('*')) continue;
            EXPECT_TRUE(known.at(table).contains(word)) << table << "." << word << " is no key";
        }
    }
}

TEST(ConfigExplain, ListsEveryTableAndKeyOfPartFilesAndOfMachineFiles) {
    auto explained = explained_by_the_program();
    EXPECT_TRUE(explained["actual.blade"].contains("keys")) << "those of [nominal.blade]";
    explained["actual.blade"] = explained["nominal.blade"];
    auto known = asked_of_part_files();
    known.merge(asked_of_machine_files());
    // That a list is there is a key of the table it stands in.
    known.at("alignment").erase("point");
    known.at("nominal").erase("blade");
    known.at("actual").erase("blade");
    EXPECT_GE(known.size(), 15U);
    expect_the_same(explained, known);
}

std::vector<std::string> in_code(const std::string& cell, const std::string& word) {
    std::vector<std::string> words;
    const std::regex code("`(" + word + ")`");
    for (auto at = std::sregex_iterator(cell.begin(), cell.end(), code); at != std::sregex_iterator(); ++at)
        words.push_back((*at)[1]);
    return words;
}

/// The methods that the error of another one lists; "": none may be chosen.
std::string methods_of(const std::string& name) {
    const auto part = acquisition::read_part_file(
        parsed("[part]\nname = \"p\"\n[nominal]\nkind = \"none\"\n[scan]\nheights_mm = [1]\n[[characteristic]]\n"
               "name = \"" +
               name + "\"\nmethod = \"ANY\"\n"));
    EXPECT_FALSE(part) << name;
    const std::string message = part ? "" : part.error().message, listed = " is none of ";
    EXPECT_NE(message.find("characteristic[0].method "), std::string::npos) << message;
    const auto at = message.find(listed);
    return at == std::string::npos ? "" : message.substr(at + listed.size());
}

TEST(PartFileDocument, NamesTheMethodsThatMayBeChosen) {
    const auto page = core::read_file("docs/part-file.md");
    ASSERT_TRUE(page);
    std::istringstream lines(page->substr(page->find("| name (keyword) | method |")));
    std::size_t names = 0;
    for (std::string line; std::getline(lines, line) && line.starts_with("|");) {
        const auto cells = core::split(line, '|');
        std::string methods;
        for (const auto& method : in_code(std::string(cells.at(2)), "[A-Z_]+"))
            methods += (methods.empty() ? "" : ", ") + method;
        for (const auto& name : in_code(std::string(cells.at(1)), "[a-z][a-z_]*")) {
            EXPECT_EQ(methods_of(name), methods) << name;
            ++names;
        }
    }
    EXPECT_GE(names, 20U);
}

}  // namespace
}  // namespace cmm::test
