// SPDX-License-Identifier: Apache-2.0
#include <Geom2dAPI_ProjectPointOnCurve.hxx>
#include <Geom2dConvert_ApproxCurve.hxx>
#include <Geom2d_BSplineCurve.hxx>
#include <Geom2d_OffsetCurve.hxx>
#include <GeomAPI_PointsToBSpline.hxx>
#include <GeomAPI_ProjectPointOnCurve.hxx>
#include <Geom_BSplineCurve.hxx>
#include <Standard_Version.hxx>
#include <TColStd_Array1OfInteger.hxx>
#include <TColStd_Array1OfReal.hxx>
#include <TColgp_Array1OfPnt.hxx>
#include <TColgp_Array1OfPnt2d.hxx>

#include "bench/peers/problem.hpp"

using namespace cmm::bench::peers;

namespace {

// The whole would take three seconds.
constexpr std::size_t projected = 2000;

void fit(const std::string& folder) {
    const auto columns = numbers(folder + "/points");
    const int n = static_cast<int>(columns.size() / 3);
    TColgp_Array1OfPnt points(1, n + 1);
    for (int i = 0; i <= n; ++i) {
        const auto at = static_cast<std::size_t>(3 * (i % n));
        points.SetValue(i + 1, gp_Pnt(columns[at + 1], columns[at + 2], 0.0));
    }
    Handle(Geom_BSplineCurve) spline;
    report("fit",
           time_ms(5, [&] { spline = GeomAPI_PointsToBSpline(points, 3, 3, GeomAbs_C2, fit_tolerance_mm).Curve(); }));
    std::vector<double> out;
    const double from = spline->FirstParameter(), to = spline->LastParameter();
    for (int i = 0; i < judged_points; ++i) {
        const gp_Pnt p = spline->Value(from + (to - from) * i / judged_points);
        out.push_back(p.X());
        out.push_back(p.Y());
    }
    write(folder + "/occt.fit", out, 2);
}

Handle(Geom2d_BSplineCurve) spline_of(const Curve& source) {
    std::vector<double> values;
    std::vector<int> times;
    for (const double knot : source.knots) {
        if (values.empty() || knot > values.back()) {
            values.push_back(knot);
            times.push_back(0);
        }
        ++times.back();
    }
    TColgp_Array1OfPnt2d poles(1, static_cast<int>(source.count()));
    for (int i = 1; i <= poles.Length(); ++i)
        poles.SetValue(i, gp_Pnt2d(source.controls[static_cast<std::size_t>(2 * i - 2)],
                                   source.controls[static_cast<std::size_t>(2 * i - 1)]));
    TColStd_Array1OfReal knots(1, static_cast<int>(values.size()));
    TColStd_Array1OfInteger multiplicities(1, knots.Length());
    for (int i = 1; i <= knots.Length(); ++i) {
        knots.SetValue(i, values[static_cast<std::size_t>(i - 1)]);
        multiplicities.SetValue(i, times[static_cast<std::size_t>(i - 1)]);
    }
    return new Geom2d_BSplineCurve(poles, knots, multiplicities, 3);
}

void project(const std::string& folder, const std::string& order, const Handle(Geom2d_BSplineCurve) & spline) {
    const auto queries = numbers(folder + "/queries." + order);
    std::vector<double> distances(projected);
    Geom2dAPI_ProjectPointOnCurve projection;
    report("closest_" + order,
           time_ms(3,
                   [&] {
                       for (std::size_t i = 0; i < projected; ++i) {
                           projection.Init(gp_Pnt2d(queries[2 * i], queries[2 * i + 1]), spline);
                           distances[i] = projection.NbPoints() > 0 ? projection.LowerDistance() : 1e300;
                       }
                   }),
           static_cast<double>(projected) / (0.5 * static_cast<double>(queries.size())));
    write(folder + "/occt.closest_" + order, distances, 1);
}

void offset(const std::string& folder, const Handle(Geom2d_BSplineCurve) & spline) {
    Handle(Geom2d_BSplineCurve) result;
    report("offset_spline", time_ms(21, [&] {
               const Handle(Geom2d_OffsetCurve) parallel = new Geom2d_OffsetCurve(spline, offset_mm);
               result = Geom2dConvert_ApproxCurve(parallel, offset_tolerance_mm, GeomAbs_C2, 2000, 5).Curve();
           }));
    std::vector<double> out;
    const double from = result->FirstParameter(), to = result->LastParameter();
    for (int i = 0; i < judged_points; ++i) {
        const gp_Pnt2d p = result->Value(from + (to - from) * i / judged_points);
        out.push_back(p.X());
        out.push_back(p.Y());
    }
    write(folder + "/occt.offset_spline", out, 2);
}

}  // namespace

int main(int, char** arguments) {
    const std::string folder = arguments[1];
    std::printf("version Open CASCADE %s\n", OCC_VERSION_COMPLETE);
    fit(folder);
    const Handle(Geom2d_BSplineCurve) spline = spline_of(curve(folder));
    project(folder, "scan", spline);
    project(folder, "random", spline);
    offset(folder, spline);
    return 0;
}
