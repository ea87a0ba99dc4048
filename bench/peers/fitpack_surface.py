# SPDX-License-Identifier: Apache-2.0
"""FITPACK's scattered least squares (surfit, through scipy) on the files of the folder given: see problem.hpp."""
import os
import sys
import time

os.environ["OMP_NUM_THREADS"] = os.environ["OPENBLAS_NUM_THREADS"] = "1"
import numpy
import scipy
from scipy.interpolate import bisplev, bisplrep

folder = sys.argv[1]
print("version scipy", scipy.__version__)
_, u, v, x, y = numpy.loadtxt(folder + "/surface.rows", unpack=True)
breaks = numpy.loadtxt(folder + "/surface.breaks_u")
spans = int(numpy.loadtxt(folder + "/surface.spans_v"))
judged_u, judged_v = (numpy.loadtxt(folder + "/surface.judged_" + name) for name in "uv")

# It knows no closed surfaces: a few spans are given twice.
period, lap = breaks[-1] - breaks[0], 4
before, after = u > breaks[-1 - lap], u < breaks[lap]
u = numpy.concatenate([u[before] - period, u, u[after] + period])
v, x, y = (numpy.concatenate([a[before], a, a[after]]) for a in (v, x, y))
ends_u = breaks[-1 - lap] - period, breaks[lap] + period
inner_u = numpy.concatenate([breaks[-lap:-1] - period, breaks, breaks[1:lap] + period])
ends_v = v.min(), v.max()


def clamped(inner, ends):
    return numpy.concatenate([[ends[0]] * 4, inner, [ends[1]] * 4])


def fit(tx, ty):
    return [
        bisplrep(u, v, values, xb=ends_u[0], xe=ends_u[1], yb=ends_v[0], ye=ends_v[1], task=-1, s=0,
                 tx=tx.copy(), ty=ty.copy(), nxest=len(tx), nyest=len(ty))
        for values in (x, y)
    ]


def measure(task, spans):
    tx, ty = clamped(inner_u, ends_u), clamped(numpy.linspace(*ends_v, spans + 1)[1:-1], ends_v)
    times = []
    for _ in range(3):
        start = time.thread_time_ns()
        splines = fit(tx, ty)
        times.append((time.thread_time_ns() - start) * 1e-6)
    times.sort()
    print(task, *times)
    columns = [bisplev(judged_u, judged_v, spline).T.ravel() for spline in splines]
    columns.append(numpy.repeat(judged_v, len(judged_u)))
    numpy.savetxt(folder + "/fitpack." + task, numpy.transpose(columns), fmt="%.17g")


# Along u the knots of ours; across as many spans as our smoothing leaves parameters, and three times as many.
measure("surface_given_knots", spans)
measure("surface_given_knots_3_x_across", 3 * spans)
