// SPDX-License-Identifier: Apache-2.0
// Reads every source of the layers and fails on an include that points upward, on a third-party header that the layer
// may not know, and on a second home of a heavy library.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <vector>

namespace {

namespace fs = std::filesystem;

const std::map<std::string, std::set<std::string>> allowed{
    {"core", {"core"}},
    {"fitting", {"core", "fitting"}},
    {"drivers", {"core", "drivers"}},
    {"sim", {"core", "sim"}},
    {"cad", {"core", "fitting", "cad"}},
    {"pdf", {"core", "pdf"}},
    {"acquisition", {"core", "fitting", "drivers", "cad", "pdf", "acquisition"}},
    {"web", {"core", "fitting", "drivers", "acquisition", "web"}},
    {"cell", {"core", "cell"}},
    {"app", {"core", "fitting", "drivers", "cad", "acquisition", "web", "cell", "sim", "app"}},
};

// Layers whose third-party world is closed: only these beside the standard library and POSIX.
const std::map<std::string, std::vector<std::string>> third_party{
    {"fitting", {"Eigen/"}},
    {"core", {"Eigen/", "tl/expected.hpp", "toml++/toml.h"}},
};
const std::set<std::string> foreign_prefixes{"boost/",   "sqlite3.h",       "zstd.h",  "nlohmann/", "modbus/",
                                             "modbus.h", "libserialport.h", "toml++/", "CLI/",      "fmt/",
                                             "spdlog/",  "Eigen/",          "tl/"};

struct Include {
    std::string file, layer, target;
    int line;
};

std::vector<Include> includes() {
    std::vector<Include> found;
    const std::regex pattern(R"(^\s*#\s*include\s*[<"]([^">]+)[">])");
    for (const auto& [layer, ignored] : allowed) {
        if (!fs::exists(layer)) continue;
        for (const auto& entry : fs::recursive_directory_iterator(layer)) {
            const auto extension = entry.path().extension();
            if (extension != ".hpp" && extension != ".cpp") continue;
            std::ifstream in(entry.path());
            std::string line;
            for (int number = 1; std::getline(in, line); ++number) {
                std::smatch match;
                if (std::regex_search(line, match, pattern)) found.push_back({entry.path(), layer, match[1], number});
            }
        }
    }
    return found;
}

TEST(IncludeGraph, NothingPointsUpward) {
    const auto all = includes();
    ASSERT_GT(all.size(), 100U) << "run from the project's root";
    for (const auto& include : all) {
        const auto slash = include.target.find('/');
        if (slash == std::string::npos) continue;
        const std::string first = include.target.substr(0, slash);
        if (!allowed.contains(first)) continue;
        EXPECT_TRUE(allowed.at(include.layer).contains(first))
            << include.file << ":" << include.line << " includes " << include.target;
    }
}

TEST(IncludeGraph, EverySourceIncludesItsOwnHeaderFirst) {
    std::string before;
    for (const auto& include : includes()) {
        const bool first = include.file != before;
        before = include.file;
        const std::string own = fs::path(include.file).replace_extension(".hpp");
        if (!first || !include.file.ends_with(".cpp") || !fs::exists(own)) continue;
        EXPECT_EQ(include.target, own) << include.file << ":" << include.line << ": only so does " << own
                                       << " prove that it compiles alone";
    }
}

TEST(IncludeGraph, ClosedLayersKnowOnlyTheirLibraries) {
    for (const auto& include : includes()) {
        const auto rule = third_party.find(include.layer);
        if (rule == third_party.end()) continue;
        for (const auto& prefix : foreign_prefixes) {
            if (!include.target.starts_with(prefix)) continue;
            bool permitted = false;
            for (const auto& ok : rule->second)
                permitted = permitted || include.target.starts_with(ok);
            EXPECT_TRUE(permitted) << include.file << ":" << include.line << " includes " << include.target;
        }
    }
}

TEST(IncludeGraph, HeavyLibrariesStayOutOfPublicHeadersAndHaveOneHome) {
    std::map<std::string, std::set<std::string>> homes;
    for (const auto& include : includes()) {
        const bool header = include.file.ends_with(".hpp");
        for (const char* heavy :
             {"toml++/toml.h", "sqlite3.h", "modbus/modbus.h", "modbus.h", "zstd.h", "nlohmann/json.hpp"}) {
            if (include.target != heavy) continue;
            EXPECT_FALSE(header) << include.file << " shows " << heavy << " to its users";
            homes[heavy].insert(include.file);
        }
    }
    EXPECT_LE(homes["toml++/toml.h"].size(), 1U);
    EXPECT_LE(homes["modbus/modbus.h"].size() + homes["modbus.h"].size(), 1U);
    EXPECT_LE(homes["sqlite3.h"].size(), 1U);
}

TEST(IncludeGraph, OpenCascadeStaysBehindTheHeadersOfItsLayer) {
    const auto all = includes();
    std::set<std::string> inner;  // headers that show it
    std::size_t seen = 0;
    for (const auto& include : all) {
        if (!include.target.ends_with(".hxx")) continue;
        ++seen;
        EXPECT_EQ(include.layer, "cad") << include.file << ":" << include.line << " includes " << include.target;
        if (include.file.ends_with(".hpp")) inner.insert(include.file);
    }
    EXPECT_GT(seen, 0U);
    for (const auto& include : all) {
        if (!inner.contains(include.target)) continue;
        EXPECT_EQ(include.layer, "cad") << include.file << ":" << include.line << " includes " << include.target;
        EXPECT_TRUE(include.file.ends_with(".cpp")) << include.file << " shows " << include.target << " to its users";
    }
}

}  // namespace
