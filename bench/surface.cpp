// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "bench/bench.hpp"
#include "bench/peer_table.hpp"
#include "bench/peers/problem.hpp"
#include "bench/surface_rows.hpp"
#include "core/rng.hpp"
#include "fitting/bspline.hpp"
#include "fitting/point_deviation.hpp"
#include "fitting/row_alignment.hpp"
#include "fitting/surface_fit.hpp"
#include "fitting/surface_index.hpp"
#include "support/twisted_blade.hpp"

namespace cmm::bench {
namespace {

using fitting::SurfacePlace;
using fitting::Vec3;
using fitting::families::TwistedBlade;
namespace fs = std::filesystem;

constexpr std::size_t query_points = 100'000, scan_points = 1000;
constexpr std::size_t judged_levels = 25, judged_on_level = 200;
constexpr std::array<const char*, 2> orders{"scan", "random"};

/// Off the truth, in the points' own planes.
std::string judged(const TwistedBlade& blade, const std::vector<double>& xyz) {
    std::vector<double> errors;
    std::optional<TwistedBlade::Section> truth;
    double level = 0.0;
    for (std::size_t i = 0; i + 2 < xyz.size(); i += 3) {
        if (!truth || xyz[i + 2] != level) truth = blade.section(level = xyz[i + 2]);
        errors.push_back(truth->closest({xyz[i], xyz[i + 1]}).distance);
    }
    return rms_and_max(errors);
}

struct JudgedPlaces {
    std::vector<double> u, v;
    explicit JudgedPlaces(const fitting::Surface& surface) {
        core::Rng rng(7);
        for (std::size_t k = 0; k < judged_on_level; ++k)
            u.push_back(rng.uniform(0, surface.u().back()));
        for (std::size_t k = 0; k < judged_levels; ++k)
            v.push_back(rng.uniform(surface.v().front(), surface.v().back()));
        std::sort(u.begin(), u.end());
        std::sort(v.begin(), v.end());
    }
    std::vector<double> on(const fitting::Surface& surface) const {
        std::vector<double> xyz;
        for (const double z : v)
            for (const double at : u) {
                const Vec3 p = surface.position({at, z});
                xyz.insert(xyz.end(), {p.x(), p.y(), p.z()});
            }
        return xyz;
    }
};

/// The surface clamped in u, for programs that know no closed ones.
void write_surface(const fitting::Surface& surface, const std::string& folder) {
    std::vector<double> knots, controls;
    for (std::size_t j = 0; j < surface.v().controls(); ++j) {
        std::vector<Vec3> row;
        for (std::size_t i = 0; i < surface.u().controls(); ++i)
            row.push_back(surface.control(i, j));
        const auto open = fitting::BSpline<3>::make(3, surface.u().knots(), std::move(row), true).value().opened();
        knots = open.knots();
        for (const Vec3& c : open.controls())
            controls.insert(controls.end(), {c.x(), c.y(), c.z()});
    }
    peers::write(folder + "/surface.knots_u", knots, 1);
    peers::write(folder + "/surface.knots_v", surface.v().knots(), 1);
    peers::write(folder + "/surface.controls", controls, 3);
}

/// The rows' points, each with its row and its place on our surface: FITPACK is given these parameters and our knots.
/// The rows' curves at common places, for those that want a grid.
void write_rows(const MeasuredRows& data, const fitting::SurfaceFit& fit, const JudgedPlaces& places,
                const std::string& folder) {
    std::vector<double> values;
    const fitting::SurfaceIndex index(fit.surface);
    std::optional<SurfacePlace> hint;
    for (std::size_t k = 0; k < data.plane.size(); ++k)
        for (const fitting::Vec2& p : data.plane[k]) {
            hint = index.closest({p.x(), p.y(), data.heights[k]}, hint).place;
            values.insert(values.end(), {static_cast<double>(k), hint->u, data.heights[k], p.x(), p.y()});
        }
    peers::write(folder + "/surface.rows", values, 5);
    std::vector<double> breaks;
    for (std::size_t i = 0; i < fit.surface.u().spans(); ++i)
        breaks.push_back(fit.surface.u().low(i));
    breaks.push_back(fit.surface.u().back());
    peers::write(folder + "/surface.breaks_u", breaks, 1);
    const auto rows = data.fitted(RowCurve::by_evidence);
    const fitting::RowAlignment alignment(fitting::features_of(rows));
    std::vector<double> grid;
    for (std::size_t k = 0; k < rows.size(); ++k)
        for (const double u : breaks) {
            const fitting::Vec2 p = rows[k].at(alignment.arc_length(k, u));
            grid.insert(grid.end(), {p.x(), p.y(), data.heights[k]});
        }
    peers::write(folder + "/surface.grid", grid, 3);
    double freedom = 0.0;
    for (const double f : fit.freedom_v)
        freedom += f / static_cast<double>(fit.freedom_v.size());
    peers::write(folder + "/surface.spans_v", {std::max(1.0, std::round(freedom) - 3.0)}, 1);
    peers::write(folder + "/surface.judged_u", places.u, 1);
    peers::write(folder + "/surface.judged_v", places.v, 1);
}

/// From 1 mm inside to 3 mm outside, every hundredth up to 60 mm away; in scan order and shuffled.
std::array<std::vector<Vec3>, 2> asked(const fitting::Surface& surface) {
    core::Rng rng(5);
    std::array<std::vector<Vec3>, 2> both;
    constexpr std::size_t scans = query_points / scan_points;
    for (std::size_t i = 0; i < query_points; ++i) {
        const double along = static_cast<double>(i % scan_points) / scan_points;
        const double across = (static_cast<double>(i / scan_points) + 0.5) / scans;
        const auto jet = surface.jet({surface.u().front() + along * (surface.u().back() - surface.u().front()),
                                      surface.v().front() + across * (surface.v().back() - surface.v().front())});
        both[0].push_back(jet.position + (i % 100 == 99 ? rng.uniform(3, 60) : rng.uniform(-1, 3)) * jet.normal());
    }
    both[1] = both[0];
    for (std::size_t i = query_points; i-- > 1;)
        std::swap(both[1][i], both[1][rng.below(i + 1)]);
    return both;
}

struct TimedFit {
    peers::Times rows, layers, both;
    double memory_mb = 0.0;
    fitting::SurfaceFit fit;
};

TimedFit timed_fit(const MeasuredRows& data, RowCurve kind) {
    TimedFit result;
    {
        forget_peak_memory();
        const double before = peak_memory_mb();
        result.fit = fitting::fit_surface(data.fitted(kind)).value();
        result.memory_mb = peak_memory_mb() - before;
    }
    std::vector<fitting::SurfaceRow> rows;
    result.rows = peers::time_ms(9, [&] { rows = data.fitted(kind); });
    result.layers = peers::time_ms(9, [&] { result.fit = fitting::fit_surface(rows).value(); });
    result.both = {result.rows.low + result.layers.low, result.rows.median + result.layers.median,
                   result.rows.high + result.layers.high};
    return result;
}

void bench_warm_start(const fitting::Surface& surface, const std::vector<Vec3>& points) {
    for (const bool warm : {true, false}) {
        const std::span<const Vec3> some(points.data(), warm ? points.size() : 4000);
        fitting::SurfaceDeviation d;
        const auto times = peers::time_ms(3, [&] { d = fitting::deviation_of(surface, some, warm); });
        std::array<char, 160> text{};
        std::snprintf(text.data(), text.size(),
                      "%.2f Newton steps a point, %zu failed, %zu ended elsewhere; rms %.2f, 99 %% %.2f um",
                      static_cast<double>(d.newton_steps) / static_cast<double>(d.points), d.newton_failures,
                      d.newton_wrong, 1e3 * d.rms_mm, 1e3 * d.p99_mm);
        print_ms("deviations of " + std::to_string(d.points) + (warm ? " points, warm start" : " points, cold start"),
                 times, text.data());
    }
}

void bench_fit(const TwistedBlade& blade, const MeasuredRows& data, const TimedFit& by_evidence,
               const JudgedPlaces& places, const PeerTable& table) {
    const auto judge = [&](const std::vector<double>& xyz) { return judged(blade, xyz); };
    const std::string what = "surface through 100 rows, 40 000 points, ";
    const auto compare = [&](const std::string& how, const char* peers, const TimedFit& timed, const char* target) {
        table.task(what + how, peers, timed.both, judge(places.on(timed.fit.surface)), target, judge);
        print_ms("  of that the surface through the rows' curves", timed.layers, "");
    };
    compare("at chords", "-", timed_fit(data, RowCurve::at_chords), "20 ms");
    compare("points projected twice", "surface", timed_fit(data, RowCurve::projected), "45 ms, 0.25/2.4 um");
    compare("rows' curves as of sections", "-", by_evidence, "");
}

void bench_growth(const TwistedBlade& blade, const TimedFit& small, std::size_t small_points) {
    const MeasuredRows data(blade, 566, 400);
    const TimedFit large = timed_fit(data, RowCurve::by_evidence);
    const auto each = [](double ms, std::size_t points) { return 1e3 * ms / static_cast<double>(points); };
    print_ms("surface through 566 rows, " + std::to_string(data.points.size()) + " points, rows' curves as of sections",
             large.both, "");
    print_one("  a point, 40 000 points", each(small.both.median, small_points), "us CPU");
    print_one("  a point, 226 000 points", each(large.both.median, data.points.size()), "us CPU", "the same");
    print_one("  memory beyond the points, 40 000 points", small.memory_mb, "MB");
    print_one("  memory beyond the points, 226 000 points", large.memory_mb, "MB", "60 MB");
}

void bench_closest(const fitting::Surface& surface, const std::array<std::vector<Vec3>, 2>& queries,
                   const PeerTable& table) {
    print_ms("index of " + std::to_string(surface.u().controls() * surface.v().controls()) + " controls",
             peers::time_ms(5, [&] { const fitting::SurfaceIndex index(surface); }), "");
    const fitting::SurfaceIndex index(surface);
    for (std::size_t k = 0; k < orders.size(); ++k) {
        std::vector<fitting::SurfaceFoot> feet(query_points);
        fitting::SearchCost cost;
        const auto ours = peers::time_ms(9, [&] {
            cost = {};
            index.closest(queries[k], feet, &cost);
        });
        std::vector<double> cold, distances;
        for (std::size_t i = 0; i < query_points; ++i) {
            cold.push_back(std::sqrt(index.closest(queries[k][i]).squared));
            distances.push_back(std::sqrt(feet[i].squared));
        }
        std::array<char, 200> text{};
        std::snprintf(text.data(), text.size(), "%.2f steps a point, hints misled %zu, failed %zu; searched cold: %s",
                      static_cast<double>(cost.steps) / query_points, cost.wrong, cost.failures,
                      farther_and_nearer(cold, distances).c_str());
        table.task("closest of 100 000 points on the surface, " + std::string(orders[k]),
                   "closest_" + std::string(orders[k]), ours, text.data(), k == 0 ? "80 ms" : "200 ms",
                   [&](const std::vector<double>& theirs) { return farther_and_nearer(theirs, distances); });
    }
}

}  // namespace

void bench_surface() {
    const TwistedBlade blade(fitting::families::Family::compressor, 6);
    const MeasuredRows data(blade, 100, 400);
    const TimedFit by_evidence = timed_fit(data, RowCurve::by_evidence);
    const fitting::Surface& surface = by_evidence.fit.surface;
    const auto queries = asked(surface);
    const JudgedPlaces places(surface);

    const fs::path folder = fs::temp_directory_path() / "cmmlive-bench-surface";
    fs::remove_all(folder);
    fs::create_directories(folder);
    write_rows(data, by_evidence.fit, places, folder.string());
    write_surface(surface, folder.string());
    for (std::size_t k = 0; k < orders.size(); ++k) {
        std::vector<double> xyz;
        for (const Vec3& p : queries[k])
            xyz.insert(xyz.end(), {p.x(), p.y(), p.z()});
        peers::write(folder.string() + "/queries." + orders[k], xyz, 3);
    }
    const std::vector<Peer> found = run_peers(folder.string(), "fitpack_surface.py", "_surface");
    const PeerTable table(found, folder.string());
    bench_fit(blade, data, by_evidence, places, table);
    bench_growth(blade, by_evidence, data.points.size());
    bench_warm_start(surface, data.points);
    bench_closest(surface, queries, table);
    fs::remove_all(folder);
    bench_compensation();
}

}  // namespace cmm::bench
