// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cmath>
#include <optional>

#include "bench/pictures/pictures.hpp"
#include "core/text.hpp"
#include "core/units.hpp"
#include "fitting/live_spline.hpp"
#include "fitting/smoothing.hpp"
#include "support/airfoil.hpp"

namespace cmm::pictures {
namespace {

using core::um_from_mm;
using fitting::LiveSpline;

constexpr std::size_t points = 1000;
constexpr double noise_mm = 1e-3, ball_mm = 1.0;
constexpr double edge_per_mm = 0.3;  // curvature above which a place counts as edge
constexpr double shown_um = 3.2;

struct Errors {
    std::vector<double> s_mm;
    std::array<std::vector<double>, 3> um;  // newest, 16 later, closed
    std::vector<double> band_um;            // 95 % of the closed one
    std::vector<char> at_edge;
};

double rms(const std::vector<double>& values) {
    double sum = 0.0;
    for (const double v : values)
        sum += v * v;
    return std::sqrt(sum / static_cast<double>(values.size()));
}

std::optional<Errors> errors() {
    const fitting::airfoil::Airfoil truth(ball_mm);
    const auto scan = truth.scan(points, fitting::airfoil::Airfoil::Spacing::edges, noise_mm, 1);
    const auto closed = fitting::smooth_closed(scan);
    if (!closed) return std::nullopt;
    Errors out;
    out.s_mm = lengths(scan);
    std::array<std::size_t, 3> near{};
    const auto note = [&](std::size_t kind, const Vector2d& p) {
        out.um[kind].push_back(um_from_mm(truth.distance(p, near[kind])));
    };
    LiveSpline live(fitting::MaterialSide::left);
    for (std::size_t i = 0; i < points; ++i) {
        live.add(i, scan[i]);
        note(0, live.newest().valid ? live.newest().position : scan[i]);
        if (i >= LiveSpline::lag) {
            const auto behind = live.point(LiveSpline::lag);
            note(1, behind.valid ? behind.position : scan[i - LiveSpline::lag]);
        }
        const double t = closed->curve.wrap(closed->parameter[i]);
        const auto jet = closed->curve.jet(t);
        note(2, jet.position);
        out.band_um.push_back(um_from_mm(1.96 * closed->noise.sigma_mm(t)));
        out.at_edge.push_back(std::abs(jet.curvature()) > edge_per_mm);
    }
    return out;
}

/// Shades the edges.
void draw_edges(svg::Picture& picture, const svg::PlotFrame& frame, const Errors& all) {
    for (std::size_t i = 0; i < points;) {
        std::size_t end = i;
        while (end < points && all.at_edge[end] != 0)
            ++end;
        if (end > i) {
            const double from = frame.px({all.s_mm[i], 0.0}).x(), to = frame.px({all.s_mm[end - 1], 0.0}).x();
            picture.box("zone", {from, frame.corner().y()}, {std::max(1.0, to - from), frame.size().y()});
        }
        i = end + 1;
    }
}

}  // namespace

std::string live_error() {
    const auto all = errors();
    if (!all) return {};
    constexpr double height = 110, apart = 42;
    svg::Picture picture(width_px, 3 * (height + apart) + 30, "error of the live and of the closed section");
    const std::array<const char*, 3> names{"newest sample", "16 samples later", "closed section, with its 95 % band"};
    const std::array<const char*, 3> css{"nominal", "centre", "measured"};
    for (std::size_t kind = 0; kind < names.size(); ++kind) {
        const auto& um = all->um[kind];
        const auto frame = frame_at(22 + static_cast<double>(kind) * (height + apart), height, {0.0, -shown_um},
                                    {all->s_mm.back(), shown_um});
        draw_edges(picture, frame, *all);
        frame.draw_y_ticks(picture, 4);
        frame.draw_x_ticks(picture, 10);
        frame.draw_titles(picture, kind == 2 ? "way of the ball centre in mm (edges shaded)" : "",
                          kind == 1 ? "off the truth in \u00b5m" : "");
        picture.text("strong", {left_px, frame.corner().y() - 6}, svg::Anchor::start,
                     std::string(names[kind]) + ": rms " + core::fixed(rms(um), 2) + " \u00b5m");
        picture.clip(frame.corner(), frame.size());
        if (kind == 2) {
            std::vector<double> lower = all->band_um;
            for (double& v : lower)
                v = -v;
            auto outline = graph(frame, all->s_mm, all->band_um);
            const auto back = graph(frame, all->s_mm, lower);
            outline.insert(outline.end(), back.rbegin(), back.rend());
            picture.path("sure", svg::polyline(outline, true, 0.2));
        }
        picture.path(css[kind], svg::polyline(graph(frame, all->s_mm, um), false, 0.2));
        picture.unclip();
    }
    return picture.finish();
}

}  // namespace cmm::pictures
