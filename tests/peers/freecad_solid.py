# SPDX-License-Identifier: Apache-2.0
# Opens the STEP file that CMMLIVE_STEP names in FreeCAD without a window, as a user would, and says what it sees.
import os

import FreeCAD
import Import

document = FreeCAD.newDocument("blade")
Import.insert(os.environ["CMMLIVE_STEP"], document.Name)
shapes = [o.Shape for o in document.Objects if hasattr(o, "Shape")]
solids = [solid for shape in shapes for solid in shape.Solids]
print("\nsolids", len(solids))
for solid in solids:
    box = solid.BoundBox
    print("valid", solid.isValid(), "closed", solid.isClosed(), "from_mm %.6f to_mm %.6f" % (box.ZMin, box.ZMax))
