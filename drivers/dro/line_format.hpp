// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "core/error.hpp"
#include "drivers/dro/dro_settings.hpp"

namespace cmm::drivers::dro {

/// What a line says.
struct LineContent {
    enum class Kind : std::uint8_t {
        point,
        no_point,  ///< readable, but its tag says that nobody took a point
        end,       ///< the section ends here
        garbled,
    };
    Kind kind = Kind::garbled;
    std::array<std::int32_t, 3> counts{};  ///< x, y, z of a point
    std::string why;                       ///< of a garbled line
};

/// A format string made ready: text stands for itself, a blank for any number of blanks and tabs, {x} {y} {z} for the
/// axes, {w} for a number of no interest (a fourth axis, a point number), {tag} for one character. A line fits wholly
/// or is garbled; nothing is guessed. A value.
class LineFormat {
  public:
    /// Errors: config_invalid (an axis absent or twice, unknown field, two fields with nothing between them).
    static core::Result<LineFormat> compile(const DroSettings& settings);
    /// `line` comes without its end.
    LineContent read(std::string_view line) const;
    /// Whether a line begins with text, so that the tail of one does not fit.
    bool begins_with_text() const;

  private:
    struct Token {
        enum class Kind : std::uint8_t { text, blank, number, tag };
        Kind kind = Kind::text;
        char text = 0;
        int axis = -1;  ///< 0, 1, 2; -1: of no interest
    };
    LineFormat() = default;
    core::Status take_field(std::string_view name);
    core::Status check() const;
    bool take_number(std::string_view& rest, int axis, LineContent& content) const;

    DroSettings settings_;
    std::vector<Token> tokens_;
};

}  // namespace cmm::drivers::dro
