// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>

/// Inside: millimetres, radians, seconds. Everything else is converted where it comes in or goes out, by these.
namespace cmm::core {

constexpr double mm_from_um(double um) noexcept {
    return um * 1e-3;
}
constexpr double um_from_mm(double mm) noexcept {
    return mm * 1e3;
}
constexpr double mm_from_cm(double cm) noexcept {
    return cm * 10.0;
}
constexpr double rad_from_deg(double deg) noexcept {
    return deg * std::numbers::pi / 180.0;
}
constexpr double deg_from_rad(double rad) noexcept {
    return rad * 180.0 / std::numbers::pi;
}

/// Nearest count; the caller has checked the range.
inline std::int32_t counts_from_mm(double mm, double lsb_mm) noexcept {
    return static_cast<std::int32_t>(std::llround(mm / lsb_mm));
}

}  // namespace cmm::core
