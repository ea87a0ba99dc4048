// SPDX-License-Identifier: Apache-2.0
#include "cad/plane_cut.hpp"

#include <BRepAlgoAPI_Section.hxx>
#include <BRep_Tool.hxx>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <GCPnts_TangentialDeflection.hxx>
#include <Geom2d_Curve.hxx>
#include <GeomAdaptor_Curve.hxx>
#include <Geom_Curve.hxx>
#include <Geom_Surface.hxx>
#include <ShapeAnalysis_Surface.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Face.hxx>
#include <algorithm>
#include <array>
#include <cmath>
#include <gp_Pln.hxx>
#include <limits>
#include <utility>

#include "core/text.hpp"

namespace cmm::cad {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// Faces of one solid, as CAD systems write them, meet within this.
constexpr double gap_mm = 0.01;
constexpr double turn_rad = 0.02;     // between two coarse parameters at most
constexpr double bulge_mm = 1e-3;     // likewise, between chord and curve
constexpr double settled_mm = 1e-10;  // Newton's method: a step of less ends it
constexpr int most_steps = 12;
// What the intersection may be off its surface before it counts as another place.
constexpr double farthest_mm = 0.05;

// Where faces meet at the height of the plane, or the part ends, it is cut beside, and the points are then put to the
// height asked for. Edges have tolerances of up to a micrometre.
constexpr std::array asides_mm{0.0, 1e-5, -1e-5, 1e-3, -1e-3};

Vector3d vector_from(const gp_XYZ& p) {
    return {p.X(), p.Y(), p.Z()};
}

/// The cut of one face, walked from `from` to `to` (which may be the smaller).
struct Piece {
    Handle(Geom_Curve) curve;
    Handle(Geom2d_Curve) trace;  // the same on the surface; may be absent
    Handle(Geom_Surface) surface;
    double from = 0.0, to = 0.0;
    std::vector<double> inner;  // coarse parameters from `from` on, without `to`

    Vector2d end(double t) const { return vector_from(curve->Value(t).XYZ()).head<2>(); }
    void turn_round() {
        std::swap(from, to);
        inner.push_back(from);
        std::reverse(inner.begin(), inner.end());
        inner.pop_back();
    }
};

class CurveOnFaces final : public SectionCurve {
  public:
    CurveOnFaces(std::vector<Piece> pieces, double z_mm) : pieces_(std::move(pieces)), z_(z_mm) {
        for (std::size_t i = 0; i < pieces_.size(); ++i) {
            const auto& piece = pieces_[i];
            for (const double t : piece.inner)
                coarse_.push_back(static_cast<double>(i) + (t - piece.from) / (piece.to - piece.from));
        }
    }

    double period() const override { return static_cast<double>(pieces_.size()); }
    const std::vector<double>& coarse() const override { return coarse_; }

    Point at(double t) const override {
        const auto [piece, parameter] = place_of(t);
        return on_surface(*piece, parameter);
    }

    std::optional<Foot> closest(const Vector3d& point_mm, double t) const override {
        const auto [piece, parameter] = place_of(t);
        gp_Pnt2d uv = start_on(*piece, parameter, piece->curve->Value(parameter));
        for (int step = 0; step < most_steps; ++step) {
            gp_Pnt at;
            gp_Vec by_u, by_v, by_uu, by_vv, by_uv;
            piece->surface->D2(uv.X(), uv.Y(), at, by_u, by_v, by_uu, by_vv, by_uv);
            const Vector3d position = vector_from(at.XYZ()), off = position - point_mm;
            const Vector3d du = vector_from(by_u.XYZ()), dv = vector_from(by_v.XYZ());
            const Vector2d gradient(off.dot(du), off.dot(dv));
            const double mixed = du.dot(dv) + off.dot(vector_from(by_uv.XYZ()));
            Eigen::Matrix2d slopes;
            slopes << du.squaredNorm() + off.dot(vector_from(by_uu.XYZ())), mixed, mixed,
                dv.squaredNorm() + off.dot(vector_from(by_vv.XYZ()));
            const double determinant = slopes.determinant();
            if (!(determinant > 1e-12 * du.squaredNorm() * dv.squaredNorm())) return std::nullopt;
            const Vector2d change = slopes.inverse() * gradient;
            if ((change.x() * du + change.y() * dv).norm() < settled_mm)
                return Foot{position, du.cross(dv).normalized()};
            uv.SetCoord(uv.X() - change.x(), uv.Y() - change.y());
        }
        return std::nullopt;
    }

    double area() const {
        double twice = 0.0;
        Vector2d before = at(coarse_.back()).position_mm;
        const Vector2d origin = before;
        for (const double t : coarse_) {
            const Vector2d here = at(t).position_mm;
            const Vector2d a = before - origin, b = here - origin;
            twice += a.x() * b.y() - a.y() * b.x();
            before = here;
        }
        return std::abs(0.5 * twice);
    }

  private:
    std::pair<const Piece*, double> place_of(double t) const {
        const double round = t - std::floor(t / period()) * period();
        const auto index = std::min(static_cast<std::size_t>(round), pieces_.size() - 1);
        const auto& piece = pieces_[index];
        const double share = round - static_cast<double>(index);
        return {&piece, piece.from + share * (piece.to - piece.from)};
    }

    static gp_Pnt2d start_on(const Piece& piece, double parameter, const gp_Pnt& near) {
        return piece.trace.IsNull() ? ShapeAnalysis_Surface(piece.surface).ValueOfUV(near, gap_mm)
                                    : piece.trace->Value(parameter);
    }

    /// Newton's method for S(u, v) at the height and, across the curve, at the place of the intersection.
    Point on_surface(const Piece& piece, double parameter) const {
        gp_Pnt near;
        gp_Vec along;
        piece.curve->D1(parameter, near, along);
        const Vector3d place = vector_from(near.XYZ());
        Vector3d direction(along.X(), along.Y(), 0.0);
        const double length = direction.norm();
        direction = length > 0.0 ? Vector3d(direction / length) : Vector3d(Vector3d::UnitX());
        gp_Pnt2d uv = start_on(piece, parameter, near);
        Vector3d position = place, du, dv;
        for (int step = 0; step < most_steps; ++step) {
            gp_Pnt at;
            gp_Vec by_u, by_v;
            piece.surface->D1(uv.X(), uv.Y(), at, by_u, by_v);
            position = vector_from(at.XYZ());
            du = vector_from(by_u.XYZ());
            dv = vector_from(by_v.XYZ());
            const Vector2d off(position.z() - z_, (position - place).dot(direction));
            Eigen::Matrix2d slopes;
            slopes << du.z(), dv.z(), du.dot(direction), dv.dot(direction);
            const double determinant = slopes.determinant();
            if (off.norm() < settled_mm || std::abs(determinant) < 1e-12 * du.norm() * dv.norm()) break;
            const Vector2d change = slopes.inverse() * off;
            uv.SetCoord(uv.X() - change.x(), uv.Y() - change.y());
        }
        if (!((position - place).norm() < farthest_mm)) position = place;
        const Vector3d normal = du.cross(dv).normalized();
        return {position.head<2>(), Vector3d::UnitZ() - normal.z() * normal};
    }

    std::vector<Piece> pieces_;
    double z_;
    std::vector<double> coarse_;
};

/// The cuts of all faces; none where the plane runs along an edge between faces, which is a cut of neither.
std::vector<Piece> pieces_of(const TopoDS_Shape& shape, double z_mm) {
    BRepAlgoAPI_Section cut(shape, gp_Pln(gp_Pnt(0.0, 0.0, z_mm), gp_Dir(0.0, 0.0, 1.0)), false);
    cut.ComputePCurveOn1(true);
    cut.Approximation(true);
    cut.SetNonDestructive(true);
    cut.Build();
    std::vector<Piece> pieces;
    for (TopExp_Explorer edges(cut.Shape(), TopAbs_EDGE); edges.More(); edges.Next()) {
        const TopoDS_Edge edge = TopoDS::Edge(edges.Current());
        Piece piece;
        piece.curve = BRep_Tool::Curve(edge, piece.from, piece.to);
        TopoDS_Shape face;
        if (piece.curve.IsNull()) continue;
        if (!cut.HasAncestorFaceOn1(edge, face)) return {};
        piece.surface = BRep_Tool::Surface(TopoDS::Face(face));
        double first = 0.0, last = 0.0;
        piece.trace = BRep_Tool::CurveOnSurface(edge, TopoDS::Face(face), first, last);
        const GCPnts_TangentialDeflection shown(GeomAdaptor_Curve(piece.curve, piece.from, piece.to), turn_rad,
                                                bulge_mm);
        for (int i = 1; i < shown.NbPoints(); ++i)
            piece.inner.push_back(shown.Parameter(i));
        pieces.push_back(std::move(piece));
    }
    return pieces;
}

/// Takes pieces that follow each other out of the heap, until they are back where they began. Errors: input_invalid.
core::Result<std::vector<Piece>> take_loop(std::vector<Piece>& heap) {
    std::vector<Piece> loop{std::move(heap.back())};
    heap.pop_back();
    const Vector2d start = loop.front().end(loop.front().from);
    for (;;) {
        const Vector2d here = loop.back().end(loop.back().to);
        const double home_mm = (start - here).norm();
        double best_mm = std::numeric_limits<double>::max();
        std::size_t best = 0;
        bool reversed = false;
        for (std::size_t i = 0; i < heap.size(); ++i) {
            for (const bool backwards : {false, true}) {
                const double far_mm = (heap[i].end(backwards ? heap[i].to : heap[i].from) - here).norm();
                if (far_mm >= best_mm) continue;
                best_mm = far_mm;
                best = i;
                reversed = backwards;
            }
        }
        if (home_mm <= gap_mm && home_mm <= best_mm) return loop;
        if (best_mm > gap_mm) {
            return core::fail(core::ErrorCode::input_invalid, "the part is open near x = " + core::fixed(here.x(), 3) +
                                                                  " mm, y = " + core::fixed(here.y(), 3) + " mm");
        }
        loop.push_back(std::move(heap[best]));
        heap.erase(heap.begin() + static_cast<std::ptrdiff_t>(best));
        if (reversed) loop.back().turn_round();
    }
}

}  // namespace

core::Result<std::unique_ptr<SectionCurve>> cut_at(const TopoDS_Shape& shape, double z_mm) {
    const std::string where = "cut at z = " + core::fixed(z_mm, 3) + " mm: ";
    std::vector<Piece> heap;
    for (const double aside_mm : asides_mm) {
        heap = pieces_of(shape, z_mm + aside_mm);
        if (!heap.empty()) break;
    }
    std::unique_ptr<CurveOnFaces> largest;
    double largest_area = 0.0;
    while (!heap.empty()) {
        auto loop = take_loop(heap);
        if (!loop) return core::fail(loop.error().code, where + loop.error().message);
        auto curve = std::make_unique<CurveOnFaces>(std::move(*loop), z_mm);
        const double area = curve->area();
        if (area <= largest_area) continue;
        largest_area = area;
        largest = std::move(curve);
    }
    if (largest == nullptr)
        return core::fail(core::ErrorCode::input_invalid, where + "no closed contour; choose another height");
    return largest;
}

}  // namespace cmm::cad
