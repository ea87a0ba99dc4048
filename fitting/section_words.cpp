// SPDX-License-Identifier: Apache-2.0
#include "fitting/section.hpp"

namespace cmm::fitting {

std::string_view to_string(Zone zone) noexcept {
    switch (zone) {
        case Zone::le:
            return "le";
        case Zone::suction:
            return "suction";
        case Zone::te:
            return "te";
        case Zone::pressure:
            return "pressure";
    }
    return "";
}

std::string_view to_string(RejectReason reason) noexcept {
    switch (reason) {
        case RejectReason::none:
            return "none";
        case RejectReason::spline_residual:
            return "spline_residual";
        case RejectReason::fit_residual:
            return "fit_residual";
        case RejectReason::no_contact:
            return "no_contact";
        case RejectReason::duplicate:
            return "duplicate";
        case RejectReason::by_operator:
            return "by_operator";
    }
    return "";
}

}  // namespace cmm::fitting
