// SPDX-License-Identifier: Apache-2.0
#include <Extrema_GenLocateExtPS.hxx>
#include <Extrema_POnSurf.hxx>
#include <GeomAPI_PointsToBSpline.hxx>
#include <GeomAPI_PointsToBSplineSurface.hxx>
#include <GeomAPI_ProjectPointOnSurf.hxx>
#include <GeomAdaptor_Surface.hxx>
#include <GeomFill_AppSurf.hxx>
#include <GeomFill_Line.hxx>
#include <GeomFill_SectionGenerator.hxx>
#include <Geom_BSplineCurve.hxx>
#include <Geom_BSplineSurface.hxx>
#include <Standard_Version.hxx>
#include <TColStd_Array1OfInteger.hxx>
#include <TColStd_Array1OfReal.hxx>
#include <TColgp_Array1OfPnt.hxx>
#include <TColgp_Array2OfPnt.hxx>
#include <algorithm>
#include <cmath>

#include "bench/peers/problem.hpp"

using namespace cmm::bench::peers;

namespace {

constexpr int judged_u = 200, judged_v = 20;
constexpr std::size_t cold_points = 200;
constexpr int least_degree = 3, most_degree = 3;

void write_points(const std::string& file, const Handle(Geom_BSplineSurface) & surface) {
    double u0, u1, v0, v1;
    surface->Bounds(u0, u1, v0, v1);
    std::vector<double> out;
    for (int j = 0; j < judged_v; ++j)
        for (int i = 0; i < judged_u; ++i) {
            const gp_Pnt p =
                surface->Value(u0 + (u1 - u0) * (i + 0.5) / judged_u, v0 + (v1 - v0) * (j + 0.5) / judged_v);
            out.insert(out.end(), {p.X(), p.Y(), p.Z()});
        }
    write(file, out, 3);
}

/// Each begins at its first point after the LE nose, u = 0.
std::vector<std::vector<gp_Pnt>> rows(const std::string& folder) {
    std::vector<std::vector<std::pair<double, gp_Pnt>>> sorted;
    const auto values = numbers(folder + "/surface.rows");
    for (std::size_t i = 0; i + 4 < values.size(); i += 5) {
        sorted.resize(static_cast<std::size_t>(values[i]) + 1);
        sorted.back().push_back({values[i + 1], gp_Pnt(values[i + 3], values[i + 4], values[i + 2])});
    }
    std::vector<std::vector<gp_Pnt>> result;
    for (auto& row : sorted) {
        std::sort(row.begin(), row.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
        result.emplace_back();
        for (const auto& point : row)
            result.back().push_back(point.second);
        result.back().push_back(row.front().second);
    }
    return result;
}

/// The way from sections to a surface: each row a curve, all on common knots, approximated across.
void sections(const std::string& folder, const std::vector<std::vector<gp_Pnt>>& all) {
    Handle(Geom_BSplineSurface) surface;
    const Times times = time_ms(1, [&] {
        GeomFill_SectionGenerator generator;
        for (const auto& row : all) {
            TColgp_Array1OfPnt points(1, static_cast<int>(row.size()));
            for (int i = 1; i <= points.Length(); ++i)
                points.SetValue(i, row[static_cast<std::size_t>(i - 1)]);
            generator.AddCurve(GeomAPI_PointsToBSpline(points, 3, 3, GeomAbs_C2, fit_tolerance_mm).Curve());
        }
        generator.Perform(1e-9);
        const Handle(GeomFill_Line) line = new GeomFill_Line(static_cast<int>(all.size()));
        GeomFill_AppSurf fit(least_degree, most_degree, fit_tolerance_mm, fit_tolerance_mm, 0);
        fit.SetContinuity(GeomAbs_C2);
        fit.Perform(line, generator, false);
        if (fit.IsDone())
            surface = new Geom_BSplineSurface(fit.SurfPoles(), fit.SurfWeights(), fit.SurfUKnots(), fit.SurfVKnots(),
                                              fit.SurfUMults(), fit.SurfVMults(), fit.UDegree(), fit.VDegree());
    });
    if (surface.IsNull()) return;
    report("surface_by_sections", times);
    write_points(folder + "/occt.surface_by_sections", surface);
}

/// It wants a grid: the rows' curves at common places.
void grid(const std::string& folder) {
    const auto values = numbers(folder + "/surface.grid");
    const auto columns = static_cast<int>(numbers(folder + "/surface.breaks_u").size());
    TColgp_Array2OfPnt points(1, columns, 1, static_cast<int>(values.size()) / 3 / columns);
    for (int k = 0; k < points.RowLength(); ++k)
        for (int i = 0; i < columns; ++i) {
            const double* p = &values[static_cast<std::size_t>(3 * (k * columns + i))];
            points.SetValue(i + 1, k + 1, gp_Pnt(p[0], p[1], p[2]));
        }
    Handle(Geom_BSplineSurface) surface;
    const Times times = time_ms(
        1, [&] { surface = GeomAPI_PointsToBSplineSurface(points, 3, 3, GeomAbs_C2, fit_tolerance_mm).Surface(); });
    report("surface_by_grid", times);
    write_points(folder + "/occt.surface_by_grid", surface);
}

Handle(Geom_BSplineSurface) given(const std::string& folder) {
    const auto axis = [&](const char* name, std::vector<double>& knots, std::vector<int>& times) {
        for (const double knot : numbers(folder + name)) {
            if (knots.empty() || knot > knots.back()) {
                knots.push_back(knot);
                times.push_back(0);
            }
            ++times.back();
        }
        int count = -4;
        for (const int t : times)
            count += t;
        return count;
    };
    std::vector<double> u, v;
    std::vector<int> times_u, times_v;
    const int m = axis("/surface.knots_u", u, times_u), n = axis("/surface.knots_v", v, times_v);
    const auto controls = numbers(folder + "/surface.controls");
    TColgp_Array2OfPnt poles(1, m, 1, n);
    for (int j = 0; j < n; ++j)
        for (int i = 0; i < m; ++i) {
            const double* c = &controls[static_cast<std::size_t>(3 * (j * m + i))];
            poles.SetValue(i + 1, j + 1, gp_Pnt(c[0], c[1], c[2]));
        }
    const TColStd_Array1OfReal knots_u(u.front(), 1, static_cast<int>(u.size())),
        knots_v(v.front(), 1, static_cast<int>(v.size()));
    const TColStd_Array1OfInteger mults_u(times_u.front(), 1, static_cast<int>(u.size())),
        mults_v(times_v.front(), 1, static_cast<int>(v.size()));
    return new Geom_BSplineSurface(poles, knots_u, knots_v, mults_u, mults_v, 3, 3);
}

void project(const std::string& folder, const std::string& order, const Handle(Geom_BSplineSurface) & surface) {
    const auto queries = numbers(folder + "/queries." + order);
    const auto query = [&](std::size_t i) { return gp_Pnt(queries[3 * i], queries[3 * i + 1], queries[3 * i + 2]); };
    std::vector<double> distances(queries.size() / 3);
    const GeomAdaptor_Surface adaptor(surface);
    double u0, u1, v0, v1;
    surface->Bounds(u0, u1, v0, v1);
    report("closest_" + order + "_warm", time_ms(3, [&] {
               Extrema_GenLocateExtPS search(adaptor, 1e-9, 1e-9);
               double u = 0.5 * (u0 + u1), v = 0.5 * (v0 + v1);
               for (std::size_t i = 0; i < distances.size(); ++i) {
                   distances[i] = 1e300;
                   search.Perform(query(i), u, v);
                   if (!search.IsDone()) continue;
                   search.Point().Parameter(u, v);
                   distances[i] = std::sqrt(search.SquareDistance());
               }
           }));
    write(folder + "/occt.closest_" + order + "_warm", distances, 1);
    distances.resize(cold_points);
    GeomAPI_ProjectPointOnSurf projection;
    report("closest_" + order + "_cold",
           time_ms(1,
                   [&] {
                       projection.Init(surface, u0, u1, v0, v1, Extrema_ExtAlgo_Grad);
                       for (std::size_t i = 0; i < cold_points; ++i) {
                           projection.Perform(query(i));
                           distances[i] = projection.NbPoints() > 0 ? projection.LowerDistance() : 1e300;
                       }
                   }),
           static_cast<double>(cold_points) / (static_cast<double>(queries.size()) / 3.0));
    write(folder + "/occt.closest_" + order + "_cold", distances, 1);
}

}  // namespace

int main(int, char** arguments) {
    const std::string folder = arguments[1];
    std::printf("version Open CASCADE %s\n", OCC_VERSION_COMPLETE);
    grid(folder);
    sections(folder, rows(folder));
    const Handle(Geom_BSplineSurface) surface = given(folder);
    project(folder, "scan", surface);
    project(folder, "random", surface);
    return 0;
}
