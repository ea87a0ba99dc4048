// SPDX-License-Identifier: Apache-2.0
#include "cad/step_part.hpp"

#include <BRepBndLib.hxx>
#include <BRepBuilderAPI_Transform.hxx>
#include <BRep_Builder.hxx>
#include <Bnd_Box.hxx>
#include <Interface_Static.hxx>
#include <STEPControl_Controller.hxx>
#include <STEPControl_Reader.hxx>
#include <Standard_Failure.hxx>
#include <StepRepr_RepresentationItem.hxx>
#include <TCollection_HAsciiString.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS_Compound.hxx>
#include <Transfer_TransientProcess.hxx>
#include <XSControl_TransferReader.hxx>
#include <XSControl_WorkSession.hxx>
#include <algorithm>
#include <filesystem>

#include "cad/occt.hpp"
#include "cad/plane_cut.hpp"

namespace cmm::cad {
namespace {

using core::ErrorCode;
using core::fail;

struct Body {
    std::string name;
    TopoDS_Shape shape;
};

std::string name_of(const STEPControl_Reader& reader, const TopoDS_Shape& shape) {
    const auto entity = reader.WS()->TransferReader()->EntityFromShapeResult(shape, 1);
    const auto item = Handle(StepRepr_RepresentationItem)::DownCast(entity);
    return item.IsNull() || item->Name().IsNull() ? std::string() : std::string(item->Name()->ToCString());
}

/// The solids, or all faces as one where there are none.
std::vector<Body> bodies_of(const STEPControl_Reader& reader, const TopoDS_Shape& all) {
    std::vector<Body> bodies;
    for (TopExp_Explorer solids(all, TopAbs_SOLID); solids.More(); solids.Next())
        bodies.push_back({name_of(reader, solids.Current()), solids.Current()});
    if (!bodies.empty()) return bodies;
    TopoDS_Compound faces;
    BRep_Builder builder;
    builder.MakeCompound(faces);
    bool any = false;
    for (TopExp_Explorer face(all, TopAbs_FACE); face.More(); face.Next(), any = true)
        builder.Add(faces, face.Current());
    if (any) bodies.push_back({"", faces});
    return bodies;
}

std::string list_of(const std::vector<Body>& bodies) {
    std::string text;
    for (std::size_t i = 0; i < bodies.size(); ++i) {
        const auto& name = bodies[i].name;
        text += (text.empty() ? "" : ", ") + std::to_string(i + 1) + (name.empty() ? "" : " \"" + name + "\"");
    }
    return text;
}

core::Result<TopoDS_Shape> choose(const std::vector<Body>& bodies, const std::string& wanted) {
    if (wanted.empty()) {
        if (bodies.size() == 1) return bodies.front().shape;
        return fail(ErrorCode::input_invalid, "holds " + std::to_string(bodies.size()) +
                                                  " solids; choose one by [nominal] solid: " + list_of(bodies));
    }
    std::vector<TopoDS_Shape> found;
    for (std::size_t i = 0; i < bodies.size(); ++i) {
        if (bodies[i].name == wanted || std::to_string(i + 1) == wanted) found.push_back(bodies[i].shape);
    }
    if (found.size() == 1) return found.front();
    return fail(ErrorCode::input_invalid, std::string("has ") + (found.empty() ? "no solid" : "several solids") +
                                              " \"" + wanted + "\"; choose by number: " + list_of(bodies));
}

core::Result<TopoDS_Shape> load(const std::string& file, const std::string& body) {
    STEPControl_Controller::Init();
    Interface_Static::SetCVal("xstep.cascade.unit", "MM");
    STEPControl_Reader reader;
    if (reader.ReadFile(file.c_str()) != IFSelect_RetDone)
        return fail(ErrorCode::input_invalid, "is not a STEP file that can be read (ISO 10303-21)");
    reader.TransferRoots();
    const TopoDS_Shape all = reader.OneShape();
    const auto bodies = all.IsNull() ? std::vector<Body>() : bodies_of(reader, all);
    if (bodies.empty()) return fail(ErrorCode::input_invalid, "holds neither a solid nor a face");
    return choose(bodies, body);
}

/// The cyclic exchange of axes that makes this one +z.
TopoDS_Shape turned(const TopoDS_Shape& shape, int axis) {
    if (axis == 2) return shape;
    gp_Trsf turn;
    if (axis == 1) {
        turn.SetValues(0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0);
    } else {
        turn.SetValues(0, 1, 0, 0, 0, 0, 1, 0, 1, 0, 0, 0);
    }
    return BRepBuilderAPI_Transform(shape, turn, true).Shape();
}

class ShapePart final : public StepPart {
  public:
    explicit ShapePart(TopoDS_Shape shape) : shape_(std::move(shape)) {
        Bnd_Box box;
        BRepBndLib::AddOptimal(shape_, box, false, false);
        z_low_ = box.CornerMin().Z();
        z_high_ = box.CornerMax().Z();
    }
    double z_low_mm() const override { return z_low_; }
    double z_high_mm() const override { return z_high_; }
    core::Result<std::unique_ptr<SectionCurve>> cut(double z_mm) const override {
        const auto in_turn = alone_with_occt();
        try {
            return cut_at(shape_, z_mm);
        } catch (const Standard_Failure& failure) {
            return fail(ErrorCode::input_invalid, std::string("the part cannot be cut: ") + failure.GetMessageString());
        }
    }

  private:
    TopoDS_Shape shape_;
    double z_low_ = 0.0, z_high_ = 0.0;
};

}  // namespace

core::Result<std::shared_ptr<const StepPart>> read_step(const std::string& file, const std::string& body,
                                                        int span_axis) {
    std::error_code code;
    const auto size = std::filesystem::file_size(file, code);
    if (code) return fail(ErrorCode::input_missing, file + ": cannot be read: " + code.message());
    if (size == 0) return fail(ErrorCode::input_invalid, file + ": is empty");
    const auto in_turn = alone_with_occt();
    try {
        const auto shape = load(file, body);
        if (!shape) return fail(shape.error().code, file + ": " + shape.error().message);
        return std::make_shared<const ShapePart>(turned(*shape, span_axis));
    } catch (const Standard_Failure& failure) {
        return fail(ErrorCode::input_invalid, file + ": cannot be read: " + failure.GetMessageString());
    }
}

}  // namespace cmm::cad
