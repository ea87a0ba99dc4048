# SPDX-License-Identifier: Apache-2.0
# Opens the STEP file that CMMLIVE_STEP names in FreeCAD without a window, as a user would, and says what it sees.
import os

import FreeCAD
import Import

# Gauss's rule of four: areas are polynomials of degree six between two knots of a cubic.
NODES = tuple(
    (sign * at, weight)
    for at, weight in ((0.3399810435848563, 0.6521451548625461), (0.8611363115940526, 0.3478548451374538))
    for sign in (-1, 1)
)


def area_mm2(curve):
    low, high, n = curve.FirstParameter, curve.LastParameter, 8000
    p = [curve.value(low + (high - low) * k / n) for k in range(n)]
    return abs(sum(p[i - 1].x * p[i].y - p[i].x * p[i - 1].y for i in range(n))) / 2


def volume_mm3(solid):
    """From the areas its level curves bound: solid.Volume takes few places a face (4 % off), slices are 28 um off."""
    airfoil = max(solid.Faces, key=lambda face: face.Area)
    knots = airfoil.Surface.getVKnots()
    total = 0.0
    for low, high in zip(knots, knots[1:]):
        half = (high - low) / 2
        for node, weight in NODES:
            level = low + half * (1 + node)
            curve = airfoil.Surface.vIso(level)
            if max(abs(curve.value(u).z - level) for u in (0.0, 10.0, 30.0, 50.0)) > 1e-9:
                raise ValueError("a level curve is not in the plane z = %.9g" % level)
            total += weight * half * area_mm2(curve)
    return total


document = FreeCAD.newDocument("blade")
Import.insert(os.environ["CMMLIVE_STEP"], document.Name)
shapes = [o.Shape for o in document.Objects if hasattr(o, "Shape")]
solids = [solid for shape in shapes for solid in shape.Solids]
print("\nsolids", len(solids))
for solid in solids:
    box = solid.BoundBox
    print("valid", solid.isValid(), "closed", solid.isClosed(), "from_mm %.6f to_mm %.6f" % (box.ZMin, box.ZMax))
    print("volume_mm3 %.9g" % volume_mm3(solid))
