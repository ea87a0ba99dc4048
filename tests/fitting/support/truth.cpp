// SPDX-License-Identifier: Apache-2.0
#include "support/truth.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <functional>
#include <limits>
#include <numbers>
#include <sstream>

#include "core/rng.hpp"

namespace cmm::fitting::truth {
namespace {

using std::numbers::pi;

Vec2 rotated(const Vec2& p, double angle) {
    return {std::cos(angle) * p.x() - std::sin(angle) * p.y(), std::sin(angle) * p.x() + std::cos(angle) * p.y()};
}

double cross2(const Vec2& a, const Vec2& b) {
    return a.x() * b.y() - a.y() * b.x();
}

double area(const std::vector<Vec2>& p) {
    double twice = 0;
    for (std::size_t i = 0; i < p.size(); ++i)
        twice += cross2(p[i], p[(i + 1) % p.size()]);
    return 0.5 * twice;
}

void make_counter_clockwise(Outline& o) {
    if (area(o.points) >= 0) return;
    std::reverse(o.points.begin(), o.points.end());
    std::reverse(o.normals.begin(), o.normals.end());
}

double segment_squared(const Vec2& a, const Vec2& b, const Vec2& p) {
    const Vec2 d = b - a;
    const double length = d.squaredNorm();
    const double share = length > 0 ? std::clamp((p - a).dot(d) / length, 0.0, 1.0) : 0.0;
    return (a + share * d - p).squaredNorm();
}

/// Central-difference normals of a smooth dense polygon.
void normals_by_difference(Outline& o) {
    const std::size_t n = o.points.size();
    o.normals.resize(n);
    for (std::size_t i = 0; i < n; ++i) {
        const Vec2 d = o.points[(i + 1) % n] - o.points[(i + n - 1) % n];
        o.normals[i] = Vec2(d.y(), -d.x()).normalized();
    }
}

/// Both sides of a camber arc with half thickness y(x) perpendicular to it, x in [0, chord], y(0) = y(chord) = 0.
Outline cambered(const std::string& name, double chord, double camber_rad, const std::function<double(double)>& half,
                 const std::vector<double>& stations) {
    const double radius = std::abs(camber_rad) > 1e-9 ? chord / camber_rad : 0.0;
    const auto place = [&](double x, double y) -> Vec2 {
        if (radius == 0.0) return {x, y};
        const double a = x / radius - camber_rad / 2;
        return Vec2(radius * std::sin(a), radius * std::cos(a)) + y * Vec2(std::sin(a), std::cos(a));
    };
    Outline o{name, {}, {}};
    for (const double x : stations)
        o.points.push_back(place(x, -half(x)));
    for (std::size_t k = stations.size() - 1; k-- > 1;)
        o.points.push_back(place(stations[k], half(stations[k])));
    make_counter_clockwise(o);
    normals_by_difference(o);
    return o;
}

/// Stations that are dense near both ends: even steps of the angle of a circle.
std::vector<double> end_dense_stations(double chord, std::size_t count) {
    std::vector<double> x;
    for (std::size_t k = 0; k <= count; ++k) {
        const double a = pi * static_cast<double>(k) / static_cast<double>(count);
        const double even = 0.5 * (1 - std::cos(a));
        x.push_back(chord * even);
    }
    return x;
}

std::vector<std::vector<double>> read_numbers(const std::string& path,
                                              const std::function<bool(const std::string&)>& breaks,
                                              std::vector<std::size_t>& block_starts) {
    std::ifstream file(path);
    std::vector<std::vector<double>> rows;
    std::string line;
    while (std::getline(file, line)) {
        if (breaks(line)) block_starts.push_back(rows.size());
        std::replace(line.begin(), line.end(), ',', ' ');
        std::istringstream words(line);
        std::vector<double> row;
        for (double v = 0; words >> v;)
            row.push_back(v);
        if (words.eof() && row.size() >= 2) rows.push_back(row);
    }
    return rows;
}

}  // namespace

double Outline::distance(const Vec2& p) const {
    const std::size_t n = points.size();
    std::size_t best = 0;
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < n; ++i) {
        const double d = (points[i] - p).squaredNorm();
        if (d < nearest) {
            nearest = d;
            best = i;
        }
    }
    // Long facets: the nearest vertex need not end the nearest side, so all sides are tried that could be nearer.
    for (std::size_t i = 0; i < n; ++i) {
        const Vec2 &a = points[i], &b = points[(i + 1) % n];
        const double reach = std::sqrt(nearest) + (b - a).norm();
        if ((a - p).squaredNorm() > reach * reach) continue;
        nearest = std::min(nearest, segment_squared(a, b, p));
    }
    bool inside = false;
    for (std::size_t i = 0; i < n; ++i) {
        const Vec2 &a = points[i], &b = points[(i + 1) % n];
        if ((a.y() > p.y()) != (b.y() > p.y()) && p.x() < a.x() + (p.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x()))
            inside = !inside;
    }
    (void)best;
    return inside ? -std::sqrt(nearest) : std::sqrt(nearest);
}

double Outline::perimeter() const {
    double sum = 0;
    for (std::size_t i = 0; i < points.size(); ++i)
        sum += (points[(i + 1) % points.size()] - points[i]).norm();
    return sum;
}

Outline envelope_blade(const EnvelopeBlade& b) {
    const double r1 = b.le_radius, r2 = b.te_radius, k = b.chord - r1 - r2, th = b.camber_deg * pi / 180;
    const double big = th > 0 ? k / (2 * std::sin(th / 2)) : 0, length = th > 0 ? big * th : k;
    const double h = b.thickness / 2 - (r1 + r2) / 2;
    const auto rho = [&](double t) {
        return r1 * (1 - t) + r2 * t + h * 0.5 * (4 * t * (1 - t) + 27.0 / 4 * t * (1 - t) * (1 - t));
    };
    const auto slope = [&](double t) {
        return r2 - r1 + h * 0.5 * (4 * (1 - 2 * t) + 27.0 / 4 * ((1 - t) * (1 - t) - 2 * t * (1 - t)));
    };
    struct Frame {
        Vec2 m, e, n;
    };
    const auto frame = [&](double t) -> Frame {
        if (th <= 0) return {{(t - 0.5) * k, 0}, {1, 0}, {0, 1}};
        const double a = (t - 0.5) * th;
        return {{big * std::sin(a), big * (std::cos(a) - std::cos(th / 2))},
                {std::cos(a), -std::sin(a)},
                {std::sin(a), std::cos(a)}};
    };
    Outline o{"envelope", {}, {}};
    const auto push = [&](double t, double angle) {  // at the angle from the camber tangent on the circle of t
        const Frame f = frame(t);
        const Vec2 n = std::cos(angle) * f.e + std::sin(angle) * f.n;
        o.points.push_back(rotated(f.m + rho(t) * n, b.stagger_deg * pi / 180));
        o.normals.push_back(rotated(n, b.stagger_deg * pi / 180));
    };
    const auto side_angle = [&](double t) { return std::acos(std::clamp(-slope(t) / length, -1.0, 1.0)); };
    const int sides = 12000, arc = 1500;
    for (int i = 0; i < sides; ++i)
        push(i / double(sides), -side_angle(i / double(sides)));  // pressure, LE to TE
    for (int i = 0; i < arc; ++i)
        push(1, -side_angle(1) + 2 * side_angle(1) * i / arc);  // TE
    for (int i = 0; i < sides; ++i)
        push(1 - i / double(sides), side_angle(1 - i / double(sides)));
    for (int i = 0; i < arc; ++i)
        push(0, side_angle(0) + 2 * (pi - side_angle(0)) * i / arc);  // LE
    return o;
}

Outline ellipse_edged_blade(double chord, double camber_deg, double le_a, double le_b, double te_a, double te_b,
                            double thickness) {
    const double peak = thickness / 2;
    // Between the ellipses' ends the half thickness is a C2 bump on the line that joins their half axes.
    const auto half = [=](double x) {
        if (x < le_a) return le_b * std::sqrt(std::max(0.0, 1 - std::pow(1 - x / le_a, 2)));
        if (x > chord - te_a) return te_b * std::sqrt(std::max(0.0, 1 - std::pow(1 - (chord - x) / te_a, 2)));
        const double u = (x - le_a) / (chord - te_a - le_a), step = u * u * u * (10 + u * (6 * u - 15));
        return le_b + (te_b - le_b) * step + (peak - 0.5 * (le_b + te_b)) * std::pow(std::sin(pi * u), 2);
    };
    std::vector<double> x;
    for (int k = 0; k <= 1500; ++k)
        x.push_back(le_a * (1 - std::cos(pi / 2 * k / 1500)));
    for (int k = 1; k < 12000; ++k)
        x.push_back(le_a + (chord - te_a - le_a) * k / 12000);
    for (int k = 1500; k >= 0; --k)
        x.push_back(chord - te_a * (1 - std::cos(pi / 2 * k / 1500)));
    return cambered("ellipse-edged", chord, camber_deg * pi / 180, half, x);
}

Outline naca_blade(double chord, double thickness_share, double camber_share) {
    const auto half = [=](double x) {
        const double u = x / chord;
        const double naca =
            5 * thickness_share * chord *
            (0.2969 * std::sqrt(u) - 0.1260 * u - 0.3516 * u * u + 0.2843 * u * u * u - 0.1015 * u * u * u * u);
        const double d = chord - x;  // a parabola-like round end instead of the blunt one
        const double end = std::sqrt(std::max(0.0, d * (2 * 0.006 * chord)));
        return naca * end / std::sqrt(end * end + naca * naca + 1e-18);
    };
    return cambered("naca", chord, 8 * camber_share, half, end_dense_stations(chord, 16000));
}

Outline spline_outline(const std::vector<Vec2>& given, const std::string& name) {
    std::vector<Vec2> p;
    for (const Vec2& q : given)
        if (p.empty() || (q - p.back()).norm() > 1e-9) p.push_back(q);
    if ((p.front() - p.back()).norm() < 1e-9) p.pop_back();
    const std::size_t n = p.size();
    std::vector<double> h(n);
    for (std::size_t i = 0; i < n; ++i)
        h[i] = (p[(i + 1) % n] - p[i]).norm();
    // Second derivatives of the periodic spline by Gauss-Seidel: diagonally dominant, converges by half a round.
    std::vector<Vec2> m(n, Vec2::Zero());
    for (int round = 0; round < 200; ++round)
        for (std::size_t i = 0; i < n; ++i) {
            const std::size_t a = (i + n - 1) % n, b = (i + 1) % n;
            m[i] =
                (6 * ((p[b] - p[i]) / h[i] - (p[i] - p[a]) / h[a]) - h[a] * m[a] - h[i] * m[b]) / (2 * (h[a] + h[i]));
        }
    Outline o{name, {}, {}};
    for (std::size_t i = 0; i < n; ++i) {
        const std::size_t b = (i + 1) % n;
        const int parts = std::max(40, static_cast<int>(h[i] / 0.008));
        for (int k = 0; k < parts; ++k) {
            const double u = double(k) / parts, w = 1 - u;
            o.points.push_back(w * p[i] + u * p[b] +
                               h[i] * h[i] / 6 * ((w * w * w - w) * m[i] + (u * u * u - u) * m[b]));
        }
    }
    make_counter_clockwise(o);
    normals_by_difference(o);
    return o;
}

Outline polygon_outline(const std::vector<Vec2>& points, const std::string& name) {
    Outline o{name, points, {}};
    if ((o.points.front() - o.points.back()).norm() < 1e-9) o.points.pop_back();
    if (area(o.points) < 0) std::reverse(o.points.begin(), o.points.end());
    for (std::size_t i = 0; i < o.points.size(); ++i) {
        const Vec2 d = o.points[(i + 1) % o.points.size()] - o.points[i];
        o.normals.push_back(Vec2(d.y(), -d.x()).normalized());
    }
    return o;
}

std::vector<std::vector<Vec2>> hannover_profiles() {
    std::vector<std::vector<Vec2>> profiles;
    for (const char* file : {"1_Rotor1_Blade.crv", "2_Stator1_Vane.crv"}) {
        std::vector<std::size_t> starts;
        const auto rows = read_numbers(
            std::string("../shared/data/hannover-4ac/") + file,
            [](const std::string& line) { return line.starts_with('#'); }, starts);
        starts.push_back(rows.size());
        for (std::size_t k = 0; k + 1 < starts.size(); ++k) {
            std::vector<Vec2> points;
            for (std::size_t i = starts[k]; i < starts[k + 1]; ++i)
                points.emplace_back(rows[i][2], rows[i][0]);
            if (points.size() > 20) profiles.push_back(points);
        }
    }
    return profiles;
}

std::vector<Outline> hannover_outlines() {
    std::vector<Outline> outlines;
    for (const auto& points : hannover_profiles())
        outlines.push_back(spline_outline(points, "hannover-" + std::to_string(outlines.size())));
    return outlines;
}

std::vector<Outline> rotor37_outlines() {
    std::vector<std::size_t> starts;
    const auto rows = read_numbers(
        "../shared/data/rotor37/cffc_rotor37geometry.dat",
        [](const std::string& line) { return line.find("SURFACE") != std::string::npos; }, starts);
    starts.push_back(rows.size());
    std::vector<Outline> outlines;
    for (std::size_t k = 0; k + 1 < starts.size(); k += 3) {
        std::vector<Vec2> one, two;
        for (std::size_t i = starts[k]; i < starts[k + 1]; ++i) {
            if (rows[i].size() != 5) continue;
            one.emplace_back(10 * rows[i][1], 10 * rows[i][2] * rows[i][3]);
            two.emplace_back(10 * rows[i][1], 10 * rows[i][2] * rows[i][4]);
        }
        if (one.size() < 20) continue;
        one.insert(one.end(), two.rbegin(), two.rend());
        outlines.push_back(spline_outline(one, "rotor37-" + std::to_string(outlines.size())));
    }
    return outlines;
}

std::vector<Outline> engine_outlines() {
    std::vector<Outline> outlines;
    for (const char* z : {"300.0", "315.0", "330.0", "345.0", "360.0", "370.0"}) {
        std::vector<std::size_t> starts;
        const auto rows = read_numbers(
            std::string("../shared/data/engine-blade/section_z") + z + ".csv", [](const std::string&) { return false; },
            starts);
        std::vector<Vec2> points;
        for (const auto& row : rows)
            points.emplace_back(row[0], row[1]);
        if (points.size() > 20) outlines.push_back(polygon_outline(points, std::string("engine-") + z));
    }
    return outlines;
}

Outline ball_centres(const Outline& part, double radius) {
    if (radius <= 0) return part;
    Outline o{part.name, {}, {}};
    const std::size_t n = part.points.size();
    const bool facets = n < 2000;
    std::vector<Vec2> raw, normals;
    for (std::size_t i = 0; i < n; ++i) {
        const Vec2 &a = part.points[i], &b = part.points[(i + 1) % n], normal = part.normals[i];
        if (!facets) {
            raw.push_back(a + radius * normal);
            normals.push_back(normal);
            continue;
        }
        // Round the vertex (convex ones), then along the facet, in steps of 4 um.
        const Vec2& before = part.normals[(i + n - 1) % n];
        const double turn = std::atan2(cross2(before, normal), before.dot(normal));
        for (double done = 0; done < turn; done += 0.004 / radius) {
            raw.push_back(a + radius * rotated(before, done));
            normals.push_back(rotated(before, done));
        }
        const int parts = std::max(1, static_cast<int>((b - a).norm() / 0.004));
        for (int k = 0; k < parts; ++k) {
            raw.push_back(a + (b - a) * (double(k) / parts) + radius * normal);
            normals.push_back(normal);
        }
    }
    // Only a facetted part has concave corners that the ball cannot enter: there the clearance is checked.
    for (std::size_t i = 0; i < raw.size(); ++i) {
        if (facets) {
            bool clear = true;
            for (std::size_t k = 0; k < n && clear; ++k) {
                if ((part.points[k] - raw[i]).squaredNorm() > 400) continue;
                clear =
                    segment_squared(part.points[k], part.points[(k + 1) % n], raw[i]) > radius * radius * (1 - 1e-9);
            }
            if (!clear) continue;
        }
        o.points.push_back(raw[i]);
        o.normals.push_back(normals[i]);
    }
    return o;
}

Scan scan(const Outline& centres, const ScanOptions& options) {
    core::Rng rng(options.seed);
    const std::size_t n = centres.points.size();
    std::vector<double> s(n + 1, 0), turn(n + 1, 0);
    for (std::size_t i = 0; i < n; ++i) {
        s[i + 1] = s[i] + (centres.points[(i + 1) % n] - centres.points[i]).norm();
        const Vec2 &a = centres.normals[i], &b = centres.normals[(i + 1) % n];
        turn[i + 1] = turn[i] + std::atan2(cross2(a, b), a.dot(b));
    }
    const double total = s[n];
    const auto index_at = [&](double where) {
        where -= std::floor(where / total) * total;
        return std::min<std::size_t>(
            n - 1, static_cast<std::size_t>(std::upper_bound(s.begin(), s.end(), where) - s.begin()) - 1);
    };
    // The pitch wanted at every vertex, then graded: it grows by at most `grading` mm a mm, ahead and behind.
    std::vector<double> pitch(n);
    for (std::size_t i = 0; i < n; ++i) {
        const std::size_t a = index_at(s[i] - 0.25), b = index_at(s[i] + 0.25);
        const double angle = turn[b] - turn[a] + (b < a ? turn[n] : 0.0);
        pitch[i] = std::clamp(options.step_rad / std::max(std::abs(angle) / 0.5, 1e-9),
                              options.pitch / options.edge_density, options.pitch);
    }
    for (std::size_t k = 0; k < 2 * n; ++k) {
        const std::size_t i = k % n, j = (k + 1) % n;
        pitch[j] = std::min(pitch[j], pitch[i] + options.grading * (s[i + 1] - s[i]));
    }
    for (std::size_t k = 2 * n; k-- > 0;) {
        const std::size_t i = k % n, j = (k + 1) % n;
        pitch[i] = std::min(pitch[i], pitch[j] + options.grading * (s[i + 1] - s[i]));
    }
    Scan result;
    std::vector<Vec2> normals;
    std::vector<char> edge;
    double where = options.start_share * total;
    const double stop = where + total + options.overlap_mm;
    while (where < stop) {
        const std::size_t i = index_at(where);
        const double wrapped = where - std::floor(where / total) * total;
        const double share = (wrapped - s[i]) / std::max(s[i + 1] - s[i], 1e-300);
        const Vec2 normal = centres.normals[i];
        result.points.push_back(centres.points[i] + share * (centres.points[(i + 1) % n] - centres.points[i]) +
                                options.noise * rng.normal() * normal);
        normals.push_back(normal);
        edge.push_back(pitch[i] < 0.6 * options.pitch);
        where += pitch[i];
    }
    result.bad.assign(result.points.size(), 0);
    auto wanted = static_cast<std::size_t>(std::llround(options.bad_share * static_cast<double>(result.points.size())));
    for (int tries = 0; wanted > 0 && tries < 100000; ++tries) {
        const std::size_t at = rng.below(result.points.size()), run = std::min<std::size_t>(wanted, 1 + rng.below(3));
        if (!edge[at] && rng.uniform() < 0.8) continue;  // mostly at the edges
        bool free = true;  // two runs keep a good point between them, or they would be one longer run
        for (std::size_t k = 0; k < run + 2; ++k)
            free = free && result.bad[(at + result.bad.size() + k - 1) % result.bad.size()] == 0;
        if (!free) continue;
        const double size = options.bad_low * std::pow(options.bad_high / options.bad_low, rng.uniform());
        const double sign = rng.uniform() < 0.8 ? 1 : -1;
        const bool alike = rng.uniform() < 0.5;
        for (std::size_t k = 0; k < run; ++k) {
            const std::size_t i = (at + k) % result.bad.size();
            const double own = options.bad_low * std::pow(options.bad_high / options.bad_low, rng.uniform());
            result.bad[i] = sign * (alike ? size * rng.uniform(0.8, 1.25) : own);
            result.points[i] += result.bad[i] * normals[i];
        }
        wanted -= run;
    }
    if (options.clockwise) {
        std::reverse(result.points.begin(), result.points.end());
        std::reverse(result.bad.begin(), result.bad.end());
    }
    return result;
}

}  // namespace cmm::fitting::truth
