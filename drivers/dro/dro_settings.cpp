// SPDX-License-Identifier: Apache-2.0
#include "drivers/dro/dro_settings.hpp"

#include "drivers/dro/line_format.hpp"

namespace cmm::drivers::dro {
namespace {

constexpr double dro_mm_per_inch = 25.4;
constexpr double inch_count = 1e-5;  // 0.254 um; of millimetres 0.1 um
constexpr std::int64_t most_decimals = 7;

}  // namespace

DroSettings read_dro_settings(const core::ConfigTable& table) {
    DroSettings settings;
    settings.format = table.text("format", settings.format);
    settings.integers = table.word("numbers", "decimal", {"decimal", "integer"}) == "integer";
    const bool inches = table.word("unit", "mm", {"mm", "inch"}) == "inch";
    settings.unit_mm = inches ? dro_mm_per_inch : 1.0;
    // What a count of an integer is worth cannot be guessed.
    settings.count = settings.integers ? table.required_number("count", {1e-7, 1.0})
                                       : table.number("count", inches ? inch_count : settings.count, {1e-7, 1.0});
    if (table.has("decimals"))
        settings.decimals = static_cast<int>(table.integer("decimals", 0, {1.0, static_cast<double>(most_decimals)}));
    settings.decimal_comma = table.boolean("decimal_comma", false);
    settings.point_tags = table.text("point_tags", "");
    settings.end = table.text("end", "");
    settings.request = table.text("request", "");
    settings.request_every_ms = table.number("request_every_ms", 0.0, {0.0, 60'000.0});
    if (settings.integers && settings.decimals) table.complain("decimals", "integers have none");
    if (settings.integers && settings.decimal_comma) table.complain("decimal_comma", "integers have none");
    if (settings.request_every_ms > 0.0 && settings.request.empty())
        table.complain("request_every_ms", "needs a request");
    if (const auto format = LineFormat::compile(settings); !format) table.complain("format", format.error().message);
    return settings;
}

}  // namespace cmm::drivers::dro
