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
    # FreeCAD's own Volume integrates with few places a face (4 % off here); of its triangles it is exact.
    corners, triangles = solid.tessellate(0.001)
    volume = sum(corners[a].dot(corners[b].cross(corners[c])) for a, b, c in triangles) / 6.0
    print("valid", solid.isValid(), "closed", solid.isClosed(), "volume_mm3 %.9g" % volume)
