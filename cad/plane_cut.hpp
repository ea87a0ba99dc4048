// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <TopoDS_Shape.hxx>
#include <memory>

#include "cad/step_part.hpp"

namespace cmm::cad {

/// Cuts a shape with the plane z = z_mm: the closed curve round the largest area. For the sources of this layer, which
/// alone know Open CASCADE; it may throw Standard_Failure. Errors: those of StepPart::cut.
core::Result<std::unique_ptr<SectionCurve>> cut_at(const TopoDS_Shape& shape, double z_mm);

}  // namespace cmm::cad
