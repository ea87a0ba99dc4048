// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <concepts>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

/// JSON text for the event stream, written on the way of a sample: no document tree. Whole documents (result.json) are
/// made by the JSON library.
namespace cmm::acquisition {

/// Quoted and escaped; bytes that are not UTF-8 become U+FFFD.
std::string json_string(std::string_view text);

/// The fields of an object, without the braces: `JsonFields().add("section", 3).add("z_mm", 40.0, 4).text()`.
class JsonFields {
  public:
    JsonFields& add(std::string_view key, std::string_view value);
    JsonFields& add(std::string_view key, const char* value) { return add(key, std::string_view(value)); }
    JsonFields& add(std::string_view key, double value, int digits);
    /// null when empty or not finite.
    JsonFields& add(std::string_view key, const std::optional<double>& value, int digits);
    template <std::integral Integer>
    JsonFields& add(std::string_view key, Integer value) {
        if constexpr (std::same_as<Integer, bool>) {
            return raw(key, value ? "true" : "false");
        } else {
            return raw(key, std::to_string(value));
        }
    }
    /// A value that is JSON already.
    JsonFields& raw(std::string_view key, std::string_view json);
    const std::string& text() const { return text_; }

  private:
    std::string text_;
};

}  // namespace cmm::acquisition
