// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "bench/pictures/pictures.hpp"
#include "core/text.hpp"
#include "core/units.hpp"
#include "fitting/edge_fit.hpp"
#include "fitting/offset.hpp"
#include "fitting/smoothing.hpp"
#include "support/airfoil.hpp"

namespace cmm::pictures {
namespace {

using core::um_from_mm;

constexpr std::size_t points = 800;
constexpr std::uint64_t seed = 2;
constexpr double noise_mm = 1e-3, ball_mm = 1.0;
constexpr double near_mm = 6.0;
constexpr double shown_um = 6.0, shown_deg = 100.0;

struct Edge {
    std::vector<Vector2d> scan, contour;
    fitting::SmoothCurve smooth;
    fitting::EdgeFit le;
    Vector2d nose_normal = Vector2d::UnitX();
    std::vector<fitting::Jet> joints;  ///< of the centres' curve, beside the edge
};

core::Result<Edge> fit(std::uint64_t scan_seed) {
    Edge edge;
    const fitting::airfoil::Airfoil truth(ball_mm);
    edge.scan = truth.scan(points, fitting::airfoil::Airfoil::Spacing::edges, noise_mm, scan_seed);
    auto smooth = fitting::smooth_closed(edge.scan);
    if (!smooth) return tl::unexpected(smooth.error());
    edge.smooth = std::move(*smooth);
    const auto part = fitting::offset_inwards(edge.smooth.curve, ball_mm, 2400).points;
    const auto found = fitting::find_edges(part, {}, {});
    if (!found) return tl::unexpected(found.error());
    const fitting::Noise noise{edge.smooth.sigma_mm, static_cast<double>(points) - edge.smooth.freedom};
    edge.le = fitting::EdgeFitter({edge.smooth, edge.scan, part, ball_mm, noise}).run(found->le, found->te, {}).fit;
    edge.nose_normal = part[found->le.nose].normal;
    for (const auto& p : part)
        edge.contour.push_back(p.position);
    for (const auto& joint : edge.smooth.joints)
        if (const auto at = edge.smooth.curve.jet(joint.t); (at.position - edge.le.centre_mm).norm() < near_mm)
            edge.joints.push_back(at);
    return edge;
}

double turned_deg(const Vector2d& from, const Vector2d& to) {
    return fitting::turn_angle(from, to) * 180.0 / std::numbers::pi;
}

void draw_plane(svg::Picture& picture, const svg::PlotFrame& frame, const Edge& edge) {
    frame.draw_axes(picture, "x in mm", "y in mm", 8, 6);
    picture.clip(frame.corner(), frame.size());
    const auto& fit = edge.le;
    picture.circle("arc", frame.px(fit.centre_mm), fit.radius_mm * frame.scale_x());
    picture.path("measured", svg::polyline(frame.px(edge.contour), true));
    std::vector<Vector2d> near;
    for (const Vector2d& p : edge.scan)
        if ((p - fit.centre_mm).norm() < near_mm) near.push_back(frame.px(p));
    picture.path("dot", svg::dots(near));
    for (const auto& joint : edge.joints) {
        const Vector2d inwards = -joint.right_normal();
        picture.line("centre", frame.px(joint.position - 0.25 * inwards), frame.px(joint.position + 1.5 * inwards));
    }
    picture.unclip();
    picture.text("strong on", frame.px(fit.centre_mm) + Vector2d(60.0, 4.0), svg::Anchor::start,
                 "r " + core::fixed(fit.radius_mm, 4) + " \u00b1 " + core::fixed(fit.radius_u95_mm, 4) + " mm");
}

}  // namespace

std::string edge_fit() {
    const auto edge = fit(seed);
    if (!edge || edge->le.model != fitting::EdgeModel::arc || edge->joints.size() != 2) return {};
    svg::Picture picture(width_px, 590, "a leading edge: its points, the arc they support, and the joints");
    const Vector2d& centre = edge->le.centre_mm;
    draw_plane(picture,
               svg::PlotFrame::equal({left_px, 12}, {width_px - left_px - right_px, 310}, centre - Vector2d(1.9, 1.9),
                                     centre + Vector2d(1.9, 1.9)),
               *edge);
    const auto frame = frame_at(400, 150, {-shown_deg, -shown_um}, {shown_deg, shown_um});
    std::array<double, 2> ends{};
    for (std::size_t k = 0; k < ends.size(); ++k)
        ends[k] = frame.px({turned_deg(edge->nose_normal, edge->joints[k].right_normal()), 0.0}).x();
    const auto [from, to] = std::minmax(ends[0], ends[1]);
    picture.box("zone", {from, frame.corner().y()}, {to - from, frame.size().y()});
    frame.draw_axes(picture, "direction of the normal from the nose, degrees (between the joints: shaded)",
                    "off in \u00b5m", 12, 6);
    std::vector<Vector2d> off_arc, off_free;
    for (std::size_t i = 0; i < points; ++i) {
        const Vector2d normal =
            edge->smooth.curve.jet(edge->smooth.curve.wrap(edge->smooth.parameter[i])).right_normal();
        const double angle = turned_deg(edge->nose_normal, normal);
        if (std::abs(angle) > shown_deg || (edge->scan[i] - centre).norm() > 10.0) continue;
        off_arc.push_back(
            frame.px({angle, um_from_mm((edge->scan[i] - centre).norm() - edge->le.radius_mm - ball_mm)}));
        off_free.push_back(frame.px({angle, um_from_mm(edge->smooth.residual[i])}));
    }
    picture.clip(frame.corner(), frame.size());
    picture.path("nominal", svg::crosses(off_free, 2.0));
    picture.path("dot", svg::dots(off_arc));
    picture.unclip();
    picture.text("strong", {left_px, frame.corner().y() - 8}, svg::Anchor::start,
                 "what the points leave off the arc (dots) and off the free form (crosses)");
    return picture.finish();
}

}  // namespace cmm::pictures
