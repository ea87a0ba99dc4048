// SPDX-License-Identifier: Apache-2.0
#include "acquisition/unit.hpp"

#include "core/text.hpp"
#include "core/units.hpp"

namespace cmm::acquisition {
namespace {

constexpr int worded_digits = 3, angle_digits = 4, share_digits = 4, curvature_digits = 5;

}  // namespace

std::string_view to_string(Unit unit) noexcept {
    switch (unit) {
        case Unit::mm:
            return "mm";
        case Unit::rad:
            return "rad";
        case Unit::mm2:
            return "mm2";
        case Unit::per_mm:
            return "1/mm";
        case Unit::share:
        case Unit::count:
            return "1";
    }
    return "";
}

std::string_view column_suffix(Unit unit) noexcept {
    switch (unit) {
        case Unit::mm:
            return "_mm";
        case Unit::rad:
            return "_deg";
        case Unit::mm2:
            return "_mm2";
        case Unit::per_mm:
            return "_per_mm";
        case Unit::share:
        case Unit::count:
            break;
    }
    return "";
}

std::string worded(double value, Unit unit) {
    switch (unit) {
        case Unit::mm:
            return core::fixed(value, worded_digits) + " mm";
        case Unit::rad:
            return core::fixed(core::deg_from_rad(value), angle_digits) + " deg";
        case Unit::mm2:
            return core::fixed(value, worded_digits) + " mm2";
        case Unit::per_mm:
            return core::fixed(value, curvature_digits) + " 1/mm";
        case Unit::share:
            return core::fixed(value, share_digits);
        case Unit::count:
            return core::fixed(value, 0);
    }
    return {};
}

}  // namespace cmm::acquisition
