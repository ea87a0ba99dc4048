// SPDX-License-Identifier: Apache-2.0
#include "tests/cad/elliptic_body.hpp"

#include <BRepBuilderAPI_MakeEdge.hxx>
#include <BRepBuilderAPI_MakeFace.hxx>
#include <BRepBuilderAPI_MakeSolid.hxx>
#include <BRepBuilderAPI_MakeWire.hxx>
#include <BRepBuilderAPI_Sewing.hxx>
#include <BRepBuilderAPI_Transform.hxx>
#include <BRepFill.hxx>
#include <BRepLib.hxx>
#include <BRep_Builder.hxx>
#include <BRep_Tool.hxx>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <GeomConvert.hxx>
#include <Geom_BSplineCurve.hxx>
#include <Geom_Circle.hxx>
#include <Interface_Static.hxx>
#include <Message.hxx>
#include <Message_Messenger.hxx>
#include <STEPControl_Controller.hxx>
#include <STEPControl_Writer.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Compound.hxx>
#include <cmath>
#include <stdexcept>

namespace cmm::cad::test {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

Vector3d mix(const Vector3d& a, const Vector3d& b, double share) {
    return a + share * (b - a);
}

/// The unit circle as a rational B-spline, its controls moved: circles and their affine images share their weights.
TopoDS_Edge edge_of(const Ellipse& ellipse) {
    const Handle(Geom_BSplineCurve) curve =
        GeomConvert::CurveToBSplineCurve(new Geom_Circle(gp_Ax2(gp_Pnt(0, 0, 0), gp_Dir(0, 0, 1)), 1.0));
    for (int i = 1; i <= curve->NbPoles(); ++i) {
        const gp_Pnt pole = curve->Pole(i);
        const Vector3d moved = ellipse.centre_mm + pole.X() * ellipse.along_mm + pole.Y() * ellipse.across_mm;
        curve->SetPole(i, gp_Pnt(moved.x(), moved.y(), moved.z()));
    }
    return BRepBuilderAPI_MakeEdge(curve);
}

TopoDS_Face wall_between(const Ellipse& low, const Ellipse& high) {
    return BRepFill::Face(edge_of(low), edge_of(high));
}

TopoDS_Face cap_of(const Ellipse& ellipse) {
    return BRepBuilderAPI_MakeFace(BRepBuilderAPI_MakeWire(edge_of(ellipse)).Wire(), true);
}

TopoDS_Shape solid_of(const EllipticBody& body) {
    BRepBuilderAPI_Sewing sewing(1e-6);
    sewing.Add(wall_between(body.bottom, body.top));
    sewing.Add(cap_of(body.bottom));
    sewing.Add(cap_of(body.top));
    sewing.Perform();
    TopExp_Explorer shell(sewing.SewedShape(), TopAbs_SHELL);
    if (!shell.More()) throw std::runtime_error("the body does not close");
    TopoDS_Solid solid = BRepBuilderAPI_MakeSolid(TopoDS::Shell(shell.Current()));
    BRepLib::OrientClosedSolid(solid);
    return solid;
}

TopoDS_Shape content_of(const EllipticBody& body, Content content) {
    TopoDS_Compound all;
    BRep_Builder builder;
    builder.MakeCompound(all);
    const double middle_mm = 0.5 * (body.bottom.centre_mm.z() + body.top.centre_mm.z());
    Ellipse above = body.at(middle_mm);
    switch (content) {
        case Content::solid:
            return solid_of(body);
        case Content::two_solids: {
            gp_Trsf aside;
            aside.SetTranslation(gp_Vec(0.0, 100.0, 0.0));
            builder.Add(all, solid_of(body));
            builder.Add(all, BRepBuilderAPI_Transform(solid_of(body), aside, true).Shape());
            break;
        }
        case Content::stacked_faces:
            builder.Add(all, wall_between(body.bottom, above));
            builder.Add(all, wall_between(above, body.top));
            break;
        case Content::gaping_faces: {
            // Half of the wall: all that a plane cuts has two ends.
            TopoDS_Face wall = wall_between(body.bottom, body.top);
            double u0 = 0.0, u1 = 0.0, v0 = 0.0, v1 = 0.0;
            const Handle(Geom_Surface) surface = BRep_Tool::Surface(wall);
            surface->Bounds(u0, u1, v0, v1);
            builder.Add(all, BRepBuilderAPI_MakeFace(surface, u0, 0.5 * (u0 + u1), v0, v1, 1e-6).Face());
            break;
        }
    }
    return all;
}

}  // namespace

Ellipse EllipticBody::at(double z_mm) const {
    const double share = (z_mm - bottom.centre_mm.z()) / (top.centre_mm.z() - bottom.centre_mm.z());
    return {mix(bottom.centre_mm, top.centre_mm, share), mix(bottom.along_mm, top.along_mm, share),
            mix(bottom.across_mm, top.across_mm, share)};
}

double EllipticBody::off_mm(const Vector2d& point, double z_mm) const {
    const Ellipse e = at(z_mm);
    Eigen::Matrix2d axes;
    axes << e.along_mm.head<2>(), e.across_mm.head<2>();
    const Vector2d unit = axes.inverse() * (point - e.centre_mm.head<2>());
    // f = |unit|^2 - 1; its gradient by the point is 2 axes^-T unit.
    return (unit.squaredNorm() - 1.0) / (2.0 * (axes.inverse().transpose() * unit).norm());
}

double EllipticBody::lean_rad(double z_mm, double t) const {
    const Ellipse e = at(z_mm);
    const auto place = [t](const Ellipse& ellipse) {
        return Vector3d(ellipse.centre_mm + std::cos(t) * ellipse.along_mm + std::sin(t) * ellipse.across_mm);
    };
    const Vector3d round = -std::sin(t) * e.along_mm + std::cos(t) * e.across_mm;
    return std::asin(round.cross(place(top) - place(bottom)).normalized().z());
}

void write_step_file(const std::string& file, const EllipticBody& body, Content content, const char* unit) {
    Message::DefaultMessenger()->ChangePrinters().Clear();
    STEPControl_Controller::Init();
    Interface_Static::SetCVal("write.step.unit", unit);  // read when a writer is made
    STEPControl_Writer writer;
    writer.Transfer(content_of(body, content), STEPControl_AsIs);
    if (writer.Write(file.c_str()) != IFSelect_RetDone) throw std::runtime_error(file + " cannot be written");
}

}  // namespace cmm::cad::test
