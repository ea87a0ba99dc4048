// SPDX-License-Identifier: Apache-2.0
// The layer without Open CASCADE.
#include "cad/spline_body.hpp"
#include "cad/step_part.hpp"

namespace cmm::cad {
namespace {

tl::unexpected<core::Error> without_cad(const std::string& what) {
    return core::fail(core::ErrorCode::config_invalid,
                      what +
                          ": this cmmlive was built without Open CASCADE, which CAD files need; install "
                          "libocct-data-exchange-dev and build again");
}

}  // namespace

core::Result<std::shared_ptr<const StepPart>> read_step(const std::string& file, const std::string& /*body*/,
                                                        int /*span_axis*/) {
    return without_cad(file + " cannot be read");
}

core::Status write_step(const SplineNet& /*net*/, const StepOptions& /*options*/, const std::string& file) {
    return without_cad(file + " cannot be written");
}

core::Status write_stl(const SplineNet& /*net*/, double /*deflection_mm*/, const std::string& file) {
    return without_cad(file + " cannot be written");
}

}  // namespace cmm::cad
