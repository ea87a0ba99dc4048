// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "core/error.hpp"

namespace cmm::core {

/// Range that a number must lie in, ends included.
struct Bounds {
    double low = std::numeric_limits<double>::lowest();
    double high = std::numeric_limits<double>::max();
};

/// A table of a TOML file, read key by key. Every read marks its key as known; the first error is kept (file, line,
/// column, what is wrong, what to do) and reading goes on with the fallback, so that a reader is a plain list of keys
/// followed by one `finish()`, which also reports a key that nobody asked for ("did you mean"). Cheap to copy; one
/// thread.
class ConfigTable {
  public:
    /// Errors: input_missing, config_syntax.
    static Result<ConfigTable> load(const std::string& path);
    static Result<ConfigTable> parse(std::string_view text, const std::string& name);

    /// A sub-table; when absent, an empty one that gives every fallback.
    ConfigTable table(std::string_view key) const;
    /// The tables of a list [[key]]; none when absent.
    std::vector<ConfigTable> tables(std::string_view key) const;
    bool has(std::string_view key) const;
    /// Whether the key holds a table: for keys that may hold either that or a plain value.
    bool has_table(std::string_view key) const;
    /// Whether the key holds a list.
    bool is_list(std::string_view key) const;

    double number(std::string_view key, double fallback, Bounds bounds = {}) const;
    double required_number(std::string_view key, Bounds bounds = {}) const;
    std::int64_t integer(std::string_view key, std::int64_t fallback, Bounds bounds = {}) const;
    std::int64_t required_integer(std::string_view key, Bounds bounds = {}) const;
    bool boolean(std::string_view key, bool fallback) const;
    std::string text(std::string_view key, std::string_view fallback) const;
    std::string required_text(std::string_view key) const;
    /// One of `words`; anything else is an error that lists them.
    std::string word(std::string_view key, std::string_view fallback, const std::vector<std::string_view>& words) const;
    std::vector<double> numbers(std::string_view key) const;
    std::vector<std::string> texts(std::string_view key) const;
    /// Leaves a whole sub-table to another reader: its keys are not reported as unknown.
    void ignore(std::string_view key) const;
    /// Leaves the rest of this table: after an unknown name or kind nobody can say which keys belong to it.
    void ignore_rest() const;

    /// Records an error at a key (or at the table when the key is absent): for checks that only the caller can make.
    void complain(std::string_view key, std::string_view what) const;
    /// The unknown key that stands first in the file, or else the first error; call on the root.
    Status finish() const;
    /// Dotted names of all keys of the whole file that were asked for so far, whether they are in it or not; elements
    /// of lists with their index.
    const std::set<std::string>& known() const;
    /// "file:line:column" of a key.
    std::string where(std::string_view key) const;
    const std::string& file() const;
    /// A file name in this file, relative to the file that names it; absolute names stay.
    std::string resolve(const std::string& name) const;

  private:
    struct Document;
    ConfigTable(std::shared_ptr<Document> document, const void* node, std::string path);
    const void* find(std::string_view key) const;
    std::shared_ptr<Document> document_;
    const void* node_ = nullptr;  // toml::table, absent: nullptr
    std::string path_;            // dotted name of this table, "" = root
};

}  // namespace cmm::core
