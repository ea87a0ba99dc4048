// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <TopoDS_Shape.hxx>

#include "cad/spline_body.hpp"

namespace cmm::cad {

/// The body as Open CASCADE has it; checked. For the sources of this layer; it may throw Standard_Failure. Errors:
/// fit_not_evaluable as for write_step.
core::Result<TopoDS_Shape> shape_of(const SplineNet& net, BodyForm form);

}  // namespace cmm::cad
