// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>

#include "bench/bench.hpp"
#include "bench/peer_table.hpp"
#include "bench/peers/problem.hpp"
#include "core/rng.hpp"
#include "fitting/bspline_pieces.hpp"
#include "fitting/closed_curve.hpp"
#include "fitting/least_squares.hpp"
#include "fitting/offset.hpp"
#include "fitting/offset_spline.hpp"
#include "fitting/smoothing.hpp"
#include "support/airfoil.hpp"

namespace cmm::bench {
namespace {

using fitting::Vec2;
namespace fs = std::filesystem;

constexpr double sigma_mm = 1e-3;
constexpr std::size_t fit_points = 1000, fixed_spans = 80, curve_spans = 120, query_points = 100'000;

/// Points of a closed curve by cumulative chords, and breaks on every n-th of them.
struct Columns {
    std::vector<double> t, x, y, breaks;
    fitting::PointColumns view() const { return {t, x, y}; }
};
Columns columns(const std::vector<Vec2>& points, std::size_t spans) {
    Columns c;
    c.t = fitting::chord_parameters(points, true);
    for (const Vec2& p : points) {
        c.x.push_back(p.x());
        c.y.push_back(p.y());
    }
    for (std::size_t k = 0; k < spans; ++k)
        c.breaks.push_back(c.t[k * points.size() / spans]);
    c.breaks.push_back(c.t.back());
    c.t.pop_back();
    return c;
}

struct Problem {
    fitting::airfoil::Airfoil airfoil;
    std::vector<Vec2> scan = airfoil.scan(fit_points, fitting::airfoil::Airfoil::Spacing::edges, sigma_mm, 1);
    Columns noisy = columns(scan, fixed_spans);
    fitting::PiecewiseCubic curve = exact_curve();
    std::array<std::vector<Vec2>, 2> queries = asked();

    /// A curve of 120 controls on noise-free points.
    fitting::PiecewiseCubic exact_curve() const {
        const auto spacing = fitting::airfoil::Airfoil::Spacing::edges;
        const Columns c = columns(airfoil.scan(4000, spacing, 0.0, 2), curve_spans);
        return fitting::fit_fixed_knots(c.view(), c.breaks, true).value();
    }
    /// From 1.5 mm inside (across the thin edges) to 3 mm outside, every hundredth up to 60 mm away; in scan order and
    /// shuffled.
    std::array<std::vector<Vec2>, 2> asked() const {
        core::Rng rng(5);
        std::array<std::vector<Vec2>, 2> both;
        for (std::size_t i = 0; i < query_points; ++i) {
            const auto jet = curve.jet(curve.front() + curve.period() * static_cast<double>(i) / query_points);
            const double away = i % 100 == 99 ? rng.uniform(3.0, 60.0) : rng.uniform(-1.5, 3.0);
            both[0].push_back(jet.position + away * jet.right_normal());
        }
        both[1] = both[0];
        for (std::size_t i = query_points; i-- > 1;)
            std::swap(both[1][i], both[1][static_cast<std::size_t>(rng.uniform() * static_cast<double>(i + 1))]);
        return both;
    }
};
constexpr std::array<const char*, 2> orders{"scan", "random"};

std::vector<double> flat(const std::vector<Vec2>& points) {
    std::vector<double> values;
    for (const Vec2& p : points)
        values.insert(values.end(), {p.x(), p.y()});
    return values;
}

void write_problem(const Problem& problem, const std::string& folder) {
    std::vector<double> rows;
    for (std::size_t i = 0; i < problem.noisy.t.size(); ++i)
        rows.insert(rows.end(), {problem.noisy.t[i], problem.noisy.x[i], problem.noisy.y[i]});
    peers::write(folder + "/points", rows, 3);
    peers::write(folder + "/breaks", problem.noisy.breaks, 1);
    peers::write(folder + "/sigma", {sigma_mm}, 1);
    const auto spline = fitting::to_bspline(problem.curve).value().opened();
    peers::write(folder + "/curve.knots", spline.knots(), 1);
    peers::write(folder + "/curve.controls", flat(spline.controls()), 2);
    for (std::size_t k = 0; k < orders.size(); ++k)
        peers::write(folder + "/queries." + orders[k], flat(problem.queries[k]), 2);
}

std::vector<double> places(const fitting::PiecewiseCubic& curve) {
    std::vector<double> xy;
    for (int i = 0; i < peers::judged_points; ++i) {
        const Vec2 p = curve.jet(curve.front() + curve.period() * i / peers::judged_points).position;
        xy.insert(xy.end(), {p.x(), p.y()});
    }
    return xy;
}

void bench_fits(const Problem& problem, const PeerTable& table) {
    const auto judge = [&](const std::vector<double>& xy) {
        std::vector<double> errors;
        std::size_t near = 0;
        for (std::size_t i = 0; i + 1 < xy.size(); i += 2)
            errors.push_back(problem.airfoil.distance({xy[i], xy[i + 1]}, near));
        return rms_and_max(errors);
    };
    fitting::SmoothCurve smooth;
    const auto whole = peers::time_ms(51, [&] { smooth = fitting::smooth_closed(problem.scan).value(); });
    table.task("smoothing spline, 1000 points, noise 1 um, not told", "fit", whole, judge(places(smooth.curve)),
               "0.5 ms", judge);
    fitting::LeastSquaresSpline fit;
    fitting::PiecewiseCubic curve;
    const auto fixed = peers::time_ms(501, [&] {
        if (fit.set_knots(problem.noisy.breaks, true) && fit.add(problem.noisy.view()) && fit.solve())
            curve = fit.curve();
    });
    table.task("least squares, 1000 points, 80 controls", "fixed_knots", fixed, judge(places(curve)), "0.03 ms", judge);
}

void bench_closest(const Problem& problem, const PeerTable& table) {
    const fitting::ClosedCurve curve(problem.curve);
    constexpr std::array<const char*, 2> targets{"20 ms", "40 ms"};
    for (std::size_t k = 0; k < orders.size(); ++k) {
        std::vector<fitting::ClosestPoint> feet(query_points);
        const auto ours = peers::time_ms(11, [&] { curve.closest(problem.queries[k], feet); });
        std::vector<double> distances;
        for (const fitting::ClosestPoint& foot : feet)
            distances.push_back(std::abs(foot.distance_mm));
        table.task("closest of 100 000 points, 120 controls, " + std::string(orders[k]),
                   "closest_" + std::string(orders[k]), ours, "certified", targets[k],
                   [&](const std::vector<double>& theirs) { return farther_and_nearer(theirs, distances); });
    }
}

void bench_offset(const Problem& problem, const PeerTable& table) {
    const fitting::ClosedCurve curve(problem.curve);
    const auto judge = [&](const std::vector<double>& xy) {
        std::vector<double> errors;
        for (std::size_t i = 0; i + 1 < xy.size(); i += 2)
            errors.push_back(std::abs(curve.closest({xy[i], xy[i + 1]}).distance_mm) - peers::offset_mm);
        return rms_and_max(errors);
    };
    fitting::OffsetSpline spline;
    const auto ours = peers::time_ms(
        101, [&] { spline = fitting::offset_spline(problem.curve, peers::offset_mm, peers::offset_tolerance_mm); });
    table.task("offset by 0.5 mm as a spline to 0.1 um", "offset_spline", ours, judge(places(spline.curve)), "0.1 ms",
               judge);
    std::vector<double> xy;
    const auto exact = peers::time_ms(
        101, [&] { xy.resize(fitting::offset_curve(problem.curve, peers::offset_mm, 2000).points.size()); });
    table.task("offset contour of " + std::to_string(xy.size()) + " exact points", "-", exact, "exact", "0.05 ms",
               judge);
}

}  // namespace

void bench_peers() {
    const fs::path folder = fs::temp_directory_path() / "cmmlive-bench-peers";
    fs::remove_all(folder);
    fs::create_directories(folder);
    const Problem problem;
    write_problem(problem, folder.string());
    const std::vector<Peer> found = run_peers(folder.string(), "fitpack.py", "");
    const PeerTable table(found, folder.string());
    bench_fits(problem, table);
    bench_closest(problem, table);
    bench_offset(problem, table);
    fs::remove_all(folder);
}

}  // namespace cmm::bench
