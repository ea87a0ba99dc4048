// SPDX-License-Identifier: Apache-2.0
#include "cad/spline_body.hpp"

#include <APIHeaderSection_MakeHeader.hxx>
#include <BRepMesh_IncrementalMesh.hxx>
#include <BRep_Tool.hxx>
#include <Interface_Static.hxx>
#include <Poly_Triangulation.hxx>
#include <STEPControl_Controller.hxx>
#include <STEPControl_Writer.hxx>
#include <Standard_Failure.hxx>
#include <StepBasic_Product.hxx>
#include <StepData_StepModel.hxx>
#include <StepShape_ManifoldSolidBrep.hxx>
#include <TCollection_HAsciiString.hxx>
#include <TopExp_Explorer.hxx>
#include <TopLoc_Location.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Face.hxx>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>

#include "cad/occt.hpp"
#include "cad/spline_shape.hpp"
#include "core/text.hpp"

namespace cmm::cad {
namespace {

using core::ErrorCode;
using core::fail;

constexpr double triangle_turn_rad = 0.1;  // between neighbouring triangles at most

/// STEP's own letters; others would have to be coded.
std::string plain(std::string name) {
    for (char& letter : name) {
        if (letter < ' ' || letter > '~') letter = '_';
    }
    return name;
}

/// The product and the solid bear the name as it is; the library would number it.
void give_name(STEPControl_Writer& writer, const std::string& name) {
    const Handle(TCollection_HAsciiString) text = new TCollection_HAsciiString(name.c_str());
    const auto model = writer.Model();
    for (int i = 1; i <= model->NbEntities(); ++i) {
        const auto entity = model->Value(i);
        if (const auto product = Handle(StepBasic_Product)::DownCast(entity)) {
            product->SetId(text);
            product->SetName(text);
        } else if (const auto solid = Handle(StepShape_ManifoldSolidBrep)::DownCast(entity)) {
            solid->SetName(text);
        }
    }
}

void describe(STEPControl_Writer& writer, const std::string& description) {
    APIHeaderSection_MakeHeader header(writer.Model());
    header.SetDescriptionValue(1, new TCollection_HAsciiString(description.c_str()));
}

core::Status transfer(const TopoDS_Shape& shape, const StepOptions& options, const std::string& file) {
    STEPControl_Controller::Init();
    // All of them are read when the writer is made, and kept by the library.
    Interface_Static::SetCVal("write.step.unit", "MM");
    Interface_Static::SetCVal("write.step.schema", options.schema == StepSchema::ap242 ? "AP242DIS" : "AP214IS");
    STEPControl_Writer writer;
    if (writer.Transfer(shape, STEPControl_AsIs) != IFSelect_RetDone)
        return fail(ErrorCode::internal, "Open CASCADE cannot put the body into STEP");
    give_name(writer, plain(options.name));
    if (!options.description.empty()) describe(writer, plain(options.description));
    if (writer.Write(file.c_str()) != IFSelect_RetDone)
        return fail(ErrorCode::journal_io, file + ": cannot be written");
    return {};
}

void append(std::string& out, const void* data, std::size_t size) {
    out.append(static_cast<const char*>(data), size);
}

/// The triangles of all faces as binary STL: 80 bytes of header, their number, then normal, corners and two bytes each.
std::string stl_of(const TopoDS_Shape& shape) {
    static_assert(std::endian::native == std::endian::little);
    std::string body;
    std::uint32_t count = 0;
    for (TopExp_Explorer faces(shape, TopAbs_FACE); faces.More(); faces.Next()) {
        const TopoDS_Face face = TopoDS::Face(faces.Current());
        TopLoc_Location place;
        const auto mesh = BRep_Tool::Triangulation(face, place);
        if (mesh.IsNull()) continue;
        const bool reversed = face.Orientation() == TopAbs_REVERSED;
        for (int k = 1; k <= mesh->NbTriangles(); ++k, ++count) {
            std::array<int, 3> corners{};
            mesh->Triangle(k).Get(corners[0], corners[1], corners[2]);
            if (reversed) std::swap(corners[1], corners[2]);
            std::array<gp_XYZ, 3> points;
            for (std::size_t c = 0; c < points.size(); ++c)
                points.at(c) = mesh->Node(corners.at(c)).Transformed(place.Transformation()).XYZ();
            gp_XYZ normal = (points[1] - points[0]).Crossed(points[2] - points[0]);
            if (normal.Modulus() > 0.0) normal.Normalize();
            for (const auto& vector : {normal, points[0], points[1], points[2]}) {
                const std::array<float, 3> numbers{static_cast<float>(vector.X()), static_cast<float>(vector.Y()),
                                                   static_cast<float>(vector.Z())};
                append(body, numbers.data(), sizeof numbers);
            }
            body.append(2, '\0');
        }
    }
    std::string out(80, ' ');
    append(out, &count, sizeof count);
    return out + body;
}

}  // namespace

core::Status write_step(const SplineNet& net, const StepOptions& options, const std::string& file) {
    const auto in_turn = alone_with_occt();
    try {
        const auto shape = shape_of(net, options.form);
        if (!shape) return tl::unexpected(shape.error());
        return transfer(*shape, options, file);
    } catch (const Standard_Failure& failure) {
        return fail(ErrorCode::fit_not_evaluable, std::string("no body: ") + failure.GetMessageString());
    }
}

core::Status write_stl(const SplineNet& net, double deflection_mm, const std::string& file) {
    const auto in_turn = alone_with_occt();
    try {
        const auto shape = shape_of(net, BodyForm::solid);
        if (!shape) return tl::unexpected(shape.error());
        const BRepMesh_IncrementalMesh meshed(*shape, deflection_mm, false, triangle_turn_rad);
        return core::write_file(file, stl_of(*shape));
    } catch (const Standard_Failure& failure) {
        return fail(ErrorCode::fit_not_evaluable, std::string("no body: ") + failure.GetMessageString());
    }
}

}  // namespace cmm::cad
