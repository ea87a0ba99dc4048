// SPDX-License-Identifier: Apache-2.0
#include "core/config.hpp"

#include <toml++/toml.h>

#include <algorithm>
#include <filesystem>
#include <set>
#include <utility>

#include "core/text.hpp"

namespace cmm::core {

struct ConfigTable::Document {
    std::string name;
    toml::table root;
    std::set<std::string> known;  // dotted names asked for
    std::optional<Error> first_error;
};

namespace {

const toml::table* as_table(const void* node) {
    return static_cast<const toml::table*>(node);
}

std::string dotted(const std::string& path, std::string_view key) {
    return path.empty() ? std::string(key) : path + "." + std::string(key);
}

std::string element(const std::string& name, std::size_t index) {
    return name + "[" + std::to_string(index) + "]";
}

std::string position(const std::string& name, const toml::source_region& source) {
    return name + ":" + std::to_string(source.begin.line) + ":" + std::to_string(source.begin.column);
}

std::string range_text(Bounds bounds) {
    const bool low = bounds.low > std::numeric_limits<double>::lowest();
    const bool high = bounds.high < std::numeric_limits<double>::max();
    const auto number = [](double v) {
        std::string text = fixed(v, 6);
        text.erase(text.find_last_not_of('0') + 1);
        if (text.ends_with('.')) text.pop_back();
        return text;
    };
    if (low && high) return "from " + number(bounds.low) + " to " + number(bounds.high);
    return low ? "at least " + number(bounds.low) : "at most " + number(bounds.high);
}

bool is_ascii(char byte) noexcept {
    return static_cast<unsigned char>(byte) < 0x80;
}

/// The text with `?`, which means nothing outside strings and comments, for each letter outside ASCII.
std::string with_marks_for_letters(std::string_view text) {
    constexpr std::string_view byte_order_mark = "\xEF\xBB\xBF";
    if (text.starts_with(byte_order_mark)) text.remove_prefix(byte_order_mark.size());
    std::string masked;
    masked.reserve(text.size());
    for (const char byte : text) {
        const bool in_a_letter = (static_cast<unsigned char>(byte) & 0xC0) == 0x80;
        if (!in_a_letter) masked += is_ascii(byte) ? byte : '?';
    }
    return masked;
}

Result<toml::table> parsed(std::string_view text, const std::string& name, std::string_view remark = {}) {
    try {
        return toml::parse(text, name);
    } catch (const toml::parse_error& error) {
        return fail(ErrorCode::config_syntax,
                    position(name, error.source()) + ": " + std::string(error.description()).append(remark));
    }
}

/// TOML 1.0 has letters outside ASCII in strings and comments only; at some that stand elsewhere toml++ 3.3 and 3.4 end
/// in undefined behaviour. A text that has any is therefore parsed with marks in their places first.
Result<toml::table> parsed_safely(std::string_view text, const std::string& name) {
    if (!std::all_of(text.begin(), text.end(), is_ascii)) {
        auto masked = parsed(with_marks_for_letters(text), name,
                             " (? may be a letter outside ASCII, which only strings and comments may have)");
        if (!masked) return masked;
    }
    return parsed(text, name);
}

}  // namespace

ConfigTable::ConfigTable(std::shared_ptr<Document> document, const void* node, std::string path)
    : document_(std::move(document)), node_(node), path_(std::move(path)) {}

Result<ConfigTable> ConfigTable::load(const std::string& path) {
    auto content = read_file(path);
    if (!content) return tl::unexpected(content.error());
    return parse(*content, path);
}

Result<ConfigTable> ConfigTable::parse(std::string_view text, const std::string& name) {
    auto root = parsed_safely(text, name);
    if (!root) return tl::unexpected(root.error());
    auto document = std::make_shared<Document>();
    document->name = name;
    document->root = std::move(*root);
    const void* node = &document->root;
    return ConfigTable(std::move(document), node, "");
}

const void* ConfigTable::find(std::string_view key) const {
    document_->known.insert(dotted(path_, key));
    if (node_ == nullptr) return nullptr;
    return as_table(node_)->get(key);
}

ConfigTable ConfigTable::table(std::string_view key) const {
    const auto* node = static_cast<const toml::node*>(find(key));
    const toml::table* sub = node == nullptr ? nullptr : node->as_table();
    if (node != nullptr && sub == nullptr) complain(key, "must be a table [" + dotted(path_, key) + "]");
    return ConfigTable(document_, sub, dotted(path_, key));
}

std::vector<ConfigTable> ConfigTable::tables(std::string_view key) const {
    const auto* node = static_cast<const toml::node*>(find(key));
    std::vector<ConfigTable> found;
    if (node == nullptr) return found;
    const auto* array = node->as_array();
    const bool only_tables = array != nullptr && array->is_homogeneous(toml::node_type::table);
    if (!only_tables) complain(key, "must be a list of tables [[" + dotted(path_, key) + "]]");
    for (std::size_t i = 0; only_tables && i < array->size(); ++i)
        found.push_back(ConfigTable(document_, array->get(i)->as_table(), element(dotted(path_, key), i)));
    return found;
}

bool ConfigTable::has(std::string_view key) const {
    return node_ != nullptr && as_table(node_)->contains(key);
}

bool ConfigTable::has_table(std::string_view key) const {
    return has(key) && as_table(node_)->get(key)->is_table();
}

bool ConfigTable::is_list(std::string_view key) const {
    return has(key) && as_table(node_)->get(key)->is_array();
}

double ConfigTable::number(std::string_view key, double fallback, Bounds bounds) const {
    const auto* node = static_cast<const toml::node*>(find(key));
    if (node == nullptr) return fallback;
    const auto value = node->value<double>();
    if (!value || !node->is_number() || !std::isfinite(*value)) {
        complain(key, "must be a number");
        return fallback;
    }
    if (*value < bounds.low || *value > bounds.high) complain(key, "must be " + range_text(bounds));
    return *value;
}

double ConfigTable::required_number(std::string_view key, Bounds bounds) const {
    if (!has(key)) complain(key, "is missing");
    return number(key, 0.0, bounds);
}

std::int64_t ConfigTable::integer(std::string_view key, std::int64_t fallback, Bounds bounds) const {
    const auto* node = static_cast<const toml::node*>(find(key));
    if (node == nullptr) return fallback;
    const auto* value = node->as_integer();
    if (value == nullptr) {
        complain(key, "must be a whole number");
        return fallback;
    }
    const auto as_double = static_cast<double>(value->get());
    if (as_double < bounds.low || as_double > bounds.high) complain(key, "must be " + range_text(bounds));
    return value->get();
}

std::int64_t ConfigTable::required_integer(std::string_view key, Bounds bounds) const {
    if (!has(key)) complain(key, "is missing");
    return integer(key, 0, bounds);
}

bool ConfigTable::boolean(std::string_view key, bool fallback) const {
    const auto* node = static_cast<const toml::node*>(find(key));
    if (node == nullptr) return fallback;
    if (!node->is_boolean()) complain(key, "must be true or false");
    return node->value_or(fallback);
}

std::string ConfigTable::text(std::string_view key, std::string_view fallback) const {
    const auto* node = static_cast<const toml::node*>(find(key));
    if (node == nullptr) return std::string(fallback);
    if (!node->is_string()) complain(key, "must be a text in quotes");
    return node->value_or(std::string(fallback));
}

std::string ConfigTable::required_text(std::string_view key) const {
    if (!has(key)) complain(key, "is missing");
    return text(key, "");
}

std::string ConfigTable::word(std::string_view key, std::string_view fallback,
                              const std::vector<std::string_view>& words) const {
    std::string value = text(key, fallback);
    for (const auto candidate : words) {
        if (value == candidate) return value;
    }
    std::string list;
    for (const auto candidate : words)
        list += (list.empty() ? "\"" : ", \"") + std::string(candidate) + "\"";
    complain(key, "must be one of " + list + ", not \"" + value + "\"");
    return std::string(fallback);
}

std::vector<double> ConfigTable::numbers(std::string_view key) const {
    const auto* node = static_cast<const toml::node*>(find(key));
    std::vector<double> values;
    if (node == nullptr) return values;
    const auto* array = node->as_array();
    if (array == nullptr) complain(key, "must be a list of numbers");
    for (std::size_t i = 0; array != nullptr && i < array->size(); ++i) {
        const auto* item = array->get(i);
        const auto value = item->value<double>();
        if (!value || !item->is_number() || !std::isfinite(*value)) {
            complain(key, "must hold numbers only");
            break;
        }
        values.push_back(*value);
    }
    return values;
}

std::vector<std::string> ConfigTable::texts(std::string_view key) const {
    const auto* node = static_cast<const toml::node*>(find(key));
    std::vector<std::string> values;
    if (node == nullptr) return values;
    const auto* array = node->as_array();
    if (array == nullptr) complain(key, "must be a list of texts");
    for (std::size_t i = 0; array != nullptr && i < array->size(); ++i) {
        const auto value = array->get(i)->value<std::string>();
        if (!value) {
            complain(key, "must hold texts only");
            break;
        }
        values.push_back(*value);
    }
    return values;
}

void ConfigTable::ignore(std::string_view key) const {
    document_->known.insert(dotted(path_, key) + ".*");
}

void ConfigTable::ignore_rest() const {
    if (node_ == nullptr) return;
    for (const auto& [key, node] : *as_table(node_))
        ignore(key.str());
}

void ConfigTable::complain(std::string_view key, std::string_view what) const {
    if (document_->first_error) return;
    document_->first_error = Error{ErrorCode::config_invalid,
                                   where(key) + ": " + dotted(path_, key) + " " + std::string(what),
                                   {},
                                   Motion::not_concerned};
}

std::string ConfigTable::where(std::string_view key) const {
    if (node_ == nullptr) return document_->name;
    const auto* table = as_table(node_);
    for (const auto& [name, node] : *table) {
        if (name.str() == key) return position(document_->name, name.source());
    }
    return table->source().begin.line == 0 ? document_->name : position(document_->name, table->source());
}

const std::set<std::string>& ConfigTable::known() const {
    return document_->known;
}

const std::string& ConfigTable::file() const {
    return document_->name;
}

std::string ConfigTable::resolve(const std::string& name) const {
    const std::filesystem::path path(name);
    if (path.is_absolute()) return name;
    return (std::filesystem::path(document_->name).parent_path() / path).lexically_normal().string();
}

namespace {

std::vector<std::pair<const toml::key*, const toml::node*>> in_order_of_the_file(const toml::table& table) {
    std::vector<std::pair<const toml::key*, const toml::node*>> entries;
    for (const auto& [key, node] : table)
        entries.emplace_back(&key, &node);
    std::sort(entries.begin(), entries.end(),
              [](const auto& a, const auto& b) { return a.first->source().begin < b.first->source().begin; });
    return entries;
}

/// The first key below `table` that is not in `known`, with its place and the nearest known sibling.
std::optional<std::string> unknown_key(const std::string& name, const toml::table& table, const std::string& path,
                                       const std::set<std::string>& known) {
    for (const auto& [key, node] : in_order_of_the_file(table)) {
        const std::string full = dotted(path, key->str());
        if (known.contains(full + ".*")) continue;
        if (!known.contains(full)) {
            std::vector<std::string_view> siblings;
            const std::string prefix = path.empty() ? "" : path + ".";
            for (const auto& candidate : known) {
                if (candidate.starts_with(prefix) && candidate.find('.', prefix.size()) == std::string::npos) {
                    siblings.push_back(std::string_view(candidate).substr(prefix.size()));
                }
            }
            std::string text = position(name, key->source()) + ": unknown key " + full;
            if (const auto best = nearest_word(key->str(), siblings)) text += "; did you mean \"" + *best + "\"?";
            return text;
        }
        if (const auto* sub = node->as_table()) {
            if (auto found = unknown_key(name, *sub, full, known)) return found;
        }
        const auto* array = node->as_array();
        for (std::size_t i = 0; array != nullptr && i < array->size(); ++i) {
            const auto* sub = array->get(i)->as_table();
            if (sub == nullptr) continue;
            if (auto found = unknown_key(name, *sub, element(full, i), known)) return found;
        }
    }
    return std::nullopt;
}

}  // namespace

Status ConfigTable::finish() const {
    // An unknown key is reported first: a misspelt required key then points at the misspelling, not at its absence.
    if (const auto text = unknown_key(document_->name, document_->root, "", document_->known)) {
        return fail(ErrorCode::config_invalid, *text);
    }
    if (document_->first_error) return tl::unexpected(*document_->first_error);
    return {};
}

}  // namespace cmm::core
