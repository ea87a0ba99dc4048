// SPDX-License-Identifier: Apache-2.0
#include "cad/spline_shape.hpp"

#include <BRepBuilderAPI_MakeEdge.hxx>
#include <BRepBuilderAPI_MakeFace.hxx>
#include <BRepBuilderAPI_MakeSolid.hxx>
#include <BRepBuilderAPI_MakeWire.hxx>
#include <BRepBuilderAPI_Sewing.hxx>
#include <BRepCheck_Analyzer.hxx>
#include <BRepLib.hxx>
#include <Eigen/Geometry>
#include <Geom_BSplineSurface.hxx>
#include <TColStd_Array1OfInteger.hxx>
#include <TColStd_Array1OfReal.hxx>
#include <TColgp_Array2OfPnt.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Face.hxx>
#include <TopoDS_Shell.hxx>
#include <TopoDS_Solid.hxx>
#include <algorithm>
#include <gp_Pln.hxx>

#include "core/text.hpp"
#include "fitting/bspline.hpp"

namespace cmm::cad {
namespace {

using core::ErrorCode;
using core::fail;
using Curve = fitting::BSpline<3>;
using Eigen::Vector3d;

constexpr int degree = 3;
constexpr double flat_mm = 1e-4;     // what an end may be off its plane
constexpr double sewn_mm = 1e-5;     // root and tip are the caps' own edges
constexpr double least_face = 1e-6;  // of the parameters

/// Distinct values and how often each comes, as Open CASCADE wants knots.
struct Knots {
    TColStd_Array1OfReal values;
    TColStd_Array1OfInteger times;
};

Knots knots_of(const std::vector<double>& flat) {
    std::vector<double> values;
    std::vector<int> times;
    for (const double knot : flat) {
        if (values.empty() || knot > values.back()) {
            values.push_back(knot);
            times.push_back(0);
        }
        ++times.back();
    }
    const int n = static_cast<int>(values.size());
    Knots knots{TColStd_Array1OfReal(1, n), TColStd_Array1OfInteger(1, n)};
    for (int i = 1; i <= n; ++i) {
        knots.values(i) = values[static_cast<std::size_t>(i - 1)];
        knots.times(i) = times[static_cast<std::size_t>(i - 1)];
    }
    return knots;
}

/// Each curve clamped at both ends: a closed one cut open. Errors: fit_not_evaluable.
core::Result<std::vector<Curve>> clamped(const std::vector<std::vector<Vector3d>>& rows,
                                         const std::vector<double>& knots, bool closed) {
    std::vector<Curve> curves;
    for (const auto& row : rows) {
        auto curve = Curve::make(degree, knots, row, closed);
        if (!curve) return tl::unexpected(std::move(curve.error()));
        curves.push_back(curve->opened());
    }
    return curves;
}

core::Result<Handle(Geom_BSplineSurface)> surface_of(const SplineNet& net) {
    if (net.count_u == 0 || net.controls.empty() || net.controls.size() % net.count_u != 0)
        return fail(ErrorCode::fit_not_evaluable, "the controls of the surface are no whole number of rows");
    std::vector<std::vector<Vector3d>> rows(net.controls.size() / net.count_u);
    for (std::size_t k = 0; k < net.controls.size(); ++k)
        rows[k / net.count_u].push_back(net.controls[k]);
    const auto round = clamped(rows, net.knots_u, net.closed_u);
    if (!round) return tl::unexpected(round.error());
    std::vector<std::vector<Vector3d>> columns(round->front().controls().size());
    for (const auto& curve : *round) {
        for (std::size_t i = 0; i < columns.size(); ++i)
            columns[i].push_back(curve.controls()[i]);
    }
    const auto along = clamped(columns, net.knots_v, false);
    if (!along) return tl::unexpected(along.error());

    TColgp_Array2OfPnt poles(1, static_cast<int>(along->size()), 1, static_cast<int>(along->front().controls().size()));
    for (int i = 1; i <= poles.ColLength(); ++i) {
        for (int j = 1; j <= poles.RowLength(); ++j) {
            const auto& p = (*along)[static_cast<std::size_t>(i - 1)].controls()[static_cast<std::size_t>(j - 1)];
            poles(i, j) = gp_Pnt(p.x(), p.y(), p.z());
        }
    }
    const Knots u = knots_of(round->front().knots()), v = knots_of(along->front().knots());
    return Handle(Geom_BSplineSurface)(
        new Geom_BSplineSurface(poles, u.values, v.values, u.times, v.times, degree, degree));
}

/// The flat face within the surface's end. Errors: fit_not_evaluable.
core::Result<TopoDS_Face> cap_of(const Handle(Geom_BSplineSurface) & surface, int end) {
    std::vector<Vector3d> ring;
    for (int i = 1; i <= surface->NbUPoles(); ++i) {
        const gp_XYZ pole = surface->Pole(i, end).XYZ();
        ring.emplace_back(pole.X(), pole.Y(), pole.Z());
    }
    Vector3d normal = Vector3d::Zero(), middle = Vector3d::Zero();
    for (std::size_t i = 0; i < ring.size(); ++i) {
        normal += (ring[i] - ring[0]).cross(ring[(i + 1) % ring.size()] - ring[0]);
        middle += ring[i] / static_cast<double>(ring.size());
    }
    if (normal.norm() <= 0.0) return fail(ErrorCode::fit_not_evaluable, "an end of the surface encloses nothing");
    normal.normalize();
    double off_mm = 0.0;
    for (const auto& point : ring)
        off_mm = std::max(off_mm, std::abs((point - middle).dot(normal)));
    if (off_mm > flat_mm)
        return fail(ErrorCode::fit_not_evaluable,
                    "an end of the surface is not plane (by " + core::length_text(off_mm) + "): it has no flat cap");
    const gp_Pln plane(gp_Pnt(middle.x(), middle.y(), middle.z()), gp_Dir(normal.x(), normal.y(), normal.z()));
    double u0 = 0.0, u1 = 0.0, v0 = 0.0, v1 = 0.0;
    surface->Bounds(u0, u1, v0, v1);
    const TopoDS_Edge edge = BRepBuilderAPI_MakeEdge(surface->VIso(end == 1 ? v0 : v1));
    return BRepBuilderAPI_MakeFace(plane, BRepBuilderAPI_MakeWire(edge).Wire(), true).Face();
}

core::Result<TopoDS_Shape> solid_of(const Handle(Geom_BSplineSurface) & surface, const TopoDS_Face& wall) {
    BRepBuilderAPI_Sewing sewing(sewn_mm);
    sewing.Add(wall);
    for (const int end : {1, surface->NbVPoles()}) {
        auto cap = cap_of(surface, end);
        if (!cap) return tl::unexpected(std::move(cap.error()));
        sewing.Add(*cap);
    }
    sewing.Perform();
    TopExp_Explorer shells(sewing.SewedShape(), TopAbs_SHELL);
    if (!shells.More() || sewing.NbFreeEdges() > 0)
        return fail(ErrorCode::fit_not_evaluable, "root, tip and sides do not close to a solid");
    TopoDS_Solid solid = BRepBuilderAPI_MakeSolid(TopoDS::Shell(shells.Current()));
    if (!BRepLib::OrientClosedSolid(solid))
        return fail(ErrorCode::fit_not_evaluable, "root, tip and sides do not close to a solid");
    return solid;
}

struct Interval {
    double from, to;
};

/// What these holes leave of the way round at v.
std::vector<Interval> measured_at(double v, const std::vector<NetHole>& holes, const Interval& round) {
    std::vector<Interval> missing;
    for (const NetHole& hole : holes) {
        if (!(hole.v0 < v && v < hole.v1)) continue;
        if (hole.u0 < hole.u1) {
            missing.push_back({hole.u0, hole.u1});
        } else {
            missing.push_back({round.from, hole.u1});
            missing.push_back({hole.u0, round.to});
        }
    }
    std::sort(missing.begin(), missing.end(), [](const Interval& a, const Interval& b) { return a.from < b.from; });
    const double least = least_face * (round.to - round.from);
    std::vector<Interval> left;
    double from = round.from;
    for (const Interval& gap : missing) {
        if (gap.from - from > least) left.push_back({from, gap.from});
        from = std::max(from, gap.to);
    }
    if (round.to - from > least) left.push_back({from, round.to});
    return left;
}

/// Faces around the holes, layer by layer from one height at which a hole begins or ends to the next.
core::Result<TopoDS_Shape> shell_around(const Handle(Geom_BSplineSurface) & surface,
                                        const std::vector<NetHole>& holes) {
    Interval round{}, height{};
    surface->Bounds(round.from, round.to, height.from, height.to);
    std::vector<double> levels{height.from, height.to};
    for (const NetHole& hole : holes)
        for (const double v : {hole.v0, hole.v1})
            if (v > height.from && v < height.to) levels.push_back(v);
    std::sort(levels.begin(), levels.end());
    BRepBuilderAPI_Sewing sewing(sewn_mm);
    bool any = false;
    for (std::size_t k = 1; k < levels.size(); ++k) {
        const Interval layer{levels[k - 1], levels[k]};
        if (layer.to - layer.from <= least_face * (height.to - height.from)) continue;
        for (const Interval& part : measured_at(0.5 * (layer.from + layer.to), holes, round)) {
            sewing.Add(BRepBuilderAPI_MakeFace(surface, part.from, part.to, layer.from, layer.to, sewn_mm).Face());
            any = true;
        }
    }
    if (!any) return fail(ErrorCode::fit_not_evaluable, "nothing of the surface was measured");
    sewing.Perform();
    return sewing.SewedShape();
}

}  // namespace

core::Result<TopoDS_Shape> shape_of(const SplineNet& net, BodyForm form) {
    if (form == BodyForm::solid && !net.closed_u)
        return fail(ErrorCode::fit_not_evaluable, "an open surface encloses no solid");
    if (form == BodyForm::solid && !net.holes.empty())
        return fail(ErrorCode::fit_not_evaluable, "a surface with holes encloses no solid");
    const auto surface = surface_of(net);
    if (!surface) return tl::unexpected(surface.error());
    TopoDS_Shape shape = BRepBuilderAPI_MakeFace(*surface, sewn_mm).Face();
    if (form == BodyForm::solid) {
        auto solid = solid_of(*surface, TopoDS::Face(shape));
        if (!solid) return solid;
        shape = *solid;
    } else if (!net.holes.empty()) {
        auto shell = shell_around(*surface, net.holes);
        if (!shell) return shell;
        shape = *shell;
    }
    if (!BRepCheck_Analyzer(shape).IsValid())
        return fail(ErrorCode::fit_not_evaluable, "Open CASCADE's checker does not call the body valid");
    return shape;
}

}  // namespace cmm::cad
