# SPDX-License-Identifier: Apache-2.0
"""FITPACK (through scipy) on the files of the folder given: see problem.hpp for the protocol."""
import os
import sys
import time

os.environ["OMP_NUM_THREADS"] = os.environ["OPENBLAS_NUM_THREADS"] = "1"
import numpy
import scipy
from scipy.interpolate import make_lsq_spline, splev, splprep

JUDGED_POINTS = 4000
folder = sys.argv[1]
print("version scipy", scipy.__version__)
t, x, y = numpy.loadtxt(folder + "/points", unpack=True)
breaks = numpy.loadtxt(folder + "/breaks")
sigma = float(numpy.loadtxt(folder + "/sigma"))
# A periodic spline wants the first point again at the end of the period.
t, x, y = numpy.append(t, breaks[-1]), numpy.append(x, x[0]), numpy.append(y, y[0])


def measure(task, repeats, work):
    times = []
    for _ in range(repeats):
        start = time.thread_time_ns()
        result = work()
        times.append((time.thread_time_ns() - start) * 1e-6)
    times.sort()
    print(task, times[0], times[len(times) // 2], times[-1])
    return result


def write(task, points):
    numpy.savetxt(folder + "/fitpack." + task, numpy.transpose(points), fmt="%.17g")


judged = breaks[0] + (breaks[-1] - breaks[0]) * numpy.arange(JUDGED_POINTS) / JUDGED_POINTS
# Smoothing, told the noise: the squared residuals may add up to n sigma^2.
tck, _ = measure("fit", 21, lambda: splprep([x, y], u=t, s=len(x) * sigma**2, per=1))
write("fit", splev(judged, tck))
# Periodic: three more knots beyond either end, a period away.
period = breaks[-1] - breaks[0]
knots = numpy.concatenate([breaks[-4:-1] - period, breaks, breaks[1:4] + period])
tck, _ = measure("fixed_knots", 51, lambda: splprep([x, y], u=t, task=-1, t=knots.copy(), per=1))
write("fixed_knots", splev(judged, tck))
# The same count of knots, clamped instead of periodic.
clamped = numpy.concatenate([[breaks[0]] * 3, breaks, [breaks[-1]] * 3])
points = numpy.column_stack([x, y])
spline = measure("fixed_knots_open", 51, lambda: make_lsq_spline(t, points, clamped))
write("fixed_knots_open", spline(judged).T)
