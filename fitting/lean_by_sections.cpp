// SPDX-License-Identifier: Apache-2.0
#include "fitting/lean_by_sections.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "fitting/closest_point.hpp"
#include "fitting/slope_forecast.hpp"

namespace cmm::fitting {
namespace {

constexpr std::size_t most_met = SlopeForecast::most_others;
constexpr double least_facing = 0.5;      // cosine between the normals of sections side by side
constexpr double steepest_way = 3.0;      // slope to a neighbour
constexpr double most_doubt_rad = 0.03;   // of the lean
constexpr double flattest_radii = 8.0;    // of the ball
constexpr double together_radii = 0.05;   // of the ball: breaks so near to each other
constexpr double most_radii = 4.0;        // of the ball: a curve less sharp lies on its tangent
constexpr std::size_t breaks_beside = 2;  // whose doubts count
constexpr int newton_steps = 12;
constexpr double met_mm = 1e-9;

/// Where a section was measured, by the parameter of its curve of ball centres.
class MeasuredAlong {
  public:
    explicit MeasuredAlong(const SectionFit& fit) : curve_(fit.centres.curve.curve) {
        for (const ContourPoint& point : fit.contour)
            places_.emplace_back(point.t, point.measured);
        std::sort(places_.begin(), places_.end());
    }
    bool at(double t) const {
        const auto next = std::lower_bound(places_.begin(), places_.end(), std::pair(curve_.wrap(t), false));
        const auto& after = next != places_.end() ? *next : places_.front();
        const auto& before = next != places_.begin() ? *(next - 1) : places_.back();
        return after.second && before.second;
    }

  private:
    const PiecewiseCubic& curve_;
    std::vector<std::pair<double, bool>> places_;
};

/// Offsets of the surface of ball centres along one line, over the height from the section's own plane, where it is 0.
class OffsetOverHeight {
  public:
    void add(double height_mm, double offset_mm) {
        height_[count_] = height_mm;
        offset_[count_++] = offset_mm;
    }
    std::size_t count() const { return count_; }
    bool full() const { return count_ == height_.size(); }

    /// Value, slope and bend of the polynomial through the section's own place and the others.
    std::array<double, 3> at(double z) const {
        // Newton's divided differences, the own place first.
        std::array<double, most_met + 1> node{}, c{};
        for (std::size_t i = 0; i < count_; ++i) {
            node[i + 1] = height_[i];
            c[i + 1] = offset_[i];
        }
        for (std::size_t order = 1; order <= count_; ++order)
            for (std::size_t i = count_; i >= order; --i)
                c[i] = (c[i] - c[i - 1]) / (node[i] - node[i - order]);
        std::array<double, 3> out{c[count_], 0.0, 0.0};
        for (std::size_t i = count_; i-- > 0;) {
            const double x = z - node[i];
            out = {out[0] * x + c[i], out[1] * x + out[0], out[2] * x + 2.0 * out[1]};
        }
        return out;
    }

    /// Of the slope at the own place: by how far the polynomial through the others misses it.
    double slope_error() const {
        const SlopeForecast slope({height_.data(), count_});
        double forecast = 0.0;
        for (std::size_t i = 0; i < count_; ++i)
            forecast += slope.weight(i) * offset_[i];
        return slope.slope_error(forecast);
    }

  private:
    std::array<double, most_met> height_{}, offset_{};
    std::size_t count_ = 0;
};

/// Where a curve has tangents of a given direction.
class Tangents {
  public:
    explicit Tangents(const PiecewiseCubic& curve) : curve_(curve) {
        for (std::size_t k = 0; k < curve.spans(); ++k)
            jets_.push_back(curve.jet(curve.breaks()[k]));
    }
    /// Near the parameter of the one nearest to p among those with this outward normal; none without one.
    std::optional<double> nearest(const Vec2& p, const Vec2& outward) const {
        std::optional<double> found;
        double least = std::numeric_limits<double>::infinity();
        const std::size_t n = jets_.size();
        double before = jets_[0].d1.dot(outward);
        for (std::size_t k = 0; k < n; ++k) {
            const Jet& jet = jets_[k];
            const double after = jets_[k + 1 < n ? k + 1 : 0].d1.dot(outward);
            const bool turns = before >= 0.0 && after < 0.0 && cross(outward, jet.d1) > 0.0;
            before = after;
            if (!turns) continue;
            const double squared = (jet.position - p).squaredNorm();
            if (squared >= least) continue;
            least = squared;
            const double from = jet.d1.dot(outward);
            found = curve_.breaks()[k] + from / (from - after) * (curve_.breaks()[k + 1] - curve_.breaks()[k]);
        }
        return found;
    }

  private:
    const PiecewiseCubic& curve_;
    std::vector<Jet> jets_;
};

/// The surface beside a place, by the offsets of two kinds of curves on it.
struct Ways {
    OffsetOverHeight line;     ///< in the plane of the normal and z
    OffsetOverHeight support;  ///< of the tangents that face the same way: where these touch
};

/// The contour at the own height, as the place of the curve of which it is the plain offset by r: along the normal.
struct Cut {
    double shift_mm = 0.0, lean_rad = 0.0;
    bool by_tangents = false;
    bool sure = false;  ///< otherwise between others
};

/// The ball that touches at the own height has its centre at z: z + r d'/w = 0, d' the slope there, w = sqrt(1 + d'^2).
std::optional<Cut> cut_of(const OffsetOverHeight& centres, double r) {
    double z = 0.0;
    for (int step = 0; step < newton_steps; ++step) {
        const auto [value, slope, bend] = centres.at(z);
        const double w = std::sqrt(1.0 + slope * slope), off = z + r * slope / w, by_z = 1.0 + r * bend / (w * w * w);
        if (!(by_z > 0.0) || std::abs(z) > r) return std::nullopt;  // the ball reaches the place from nowhere
        if (std::abs(off) < met_mm) return Cut{value - r / w + r, -std::atan(slope)};
        z -= off / by_z;
    }
    return std::nullopt;
}

class LeanBySections {
  public:
    LeanBySections(std::span<const SectionInPlane> sections, std::size_t own, const SectionOptions& options)
        : sections_(sections), own_(own), fit_(*sections[own].fit), options_(options), ways_(curve().spans()) {
        const double z = sections[own].z_mm;
        for (std::size_t m = 0; m < sections.size(); ++m) {
            const auto as_high = [&](std::size_t other) { return sections[other].z_mm == sections[m].z_mm; };
            if (!as_high(own) && std::none_of(others_.begin(), others_.end(), as_high)) others_.push_back(m);
        }
        std::sort(others_.begin(), others_.end(), [&](std::size_t a, std::size_t b) {
            return std::abs(sections[a].z_mm - z) < std::abs(sections[b].z_mm - z);
        });
    }

    core::Result<SurfaceSection> run() {
        const MeasuredAlong measured(fit_);
        for (std::size_t k = 0; k < ways_.size(); ++k)
            if (measured.at(curve().breaks()[k])) open_.push_back(k);
        for (const std::size_t m : others_)
            meet(*sections_[m].fit, sections_[m].z_mm - sections_[own_].z_mm);
        std::vector<std::optional<Cut>> cuts(ways_.size());
        SectionMovement movement{std::vector<Vec2>(ways_.size(), Vec2::Zero()), {}};
        double largest_mm = 0.0;
        for (std::size_t k = 0; k < ways_.size(); ++k) {
            SurfaceStation& s = movement.stations.emplace_back();
            s.t = curve().breaks()[k];
            const double by_line = doubt_near(k, &Ways::line), by_tangents = doubt_near(k, &Ways::support);
            const OffsetOverHeight& best = by_tangents < by_line ? ways_[k].support : ways_[k].line;
            const double doubt = std::min(by_line, by_tangents);
            if (doubt < most_doubt_rad || (others_.size() == 1 && best.count() == 1))
                cuts[k] = cut_of(best, options_.ball_radius_mm);
            if (!cuts[k]) continue;
            cuts[k]->by_tangents = &best == &ways_[k].support;
            cuts[k]->sure = true;
            s.lean_rad = cuts[k]->lean_rad;
            s.doubt(options_.ball_radius_mm, doubt);
            largest_mm = std::max(largest_mm, s.offset_error_mm);
        }
        if (std::none_of(cuts.begin(), cuts.end(), [](const auto& cut) { return cut.has_value(); }))
            return core::fail(core::ErrorCode::fit_not_evaluable,
                              "compensation: no other section was measured beside this one");
        const auto spoken_for = thin_out(cuts, movement.stations);
        bridge(cuts);
        for (const std::size_t k : spoken_for)
            cuts[k]->sure = true;
        for (std::size_t k = 0; k < cuts.size(); ++k) {
            movement.shift[k] = shift_at(k, cuts);
            if (sure_near(k, cuts)) continue;
            movement.stations[k].lean_rad = cuts[k]->lean_rad;
            movement.stations[k].offset_error_mm = movement.stations[k].lean_doubt_mm = largest_mm;
        }
        return move_section(fit_.centres.curve, std::move(movement), fit_, options_);
    }

  private:
    const PiecewiseCubic& curve() const { return fit_.centres.curve.curve; }

    /// Of breaks that lie together, as at a joint of the curve, the one with the smallest doubt speaks for all: between
    /// two of them the shift would be as steep as their errors differ. The others are left to `bridge`.
    std::vector<std::size_t> thin_out(std::vector<std::optional<Cut>>& cuts,
                                      std::vector<SurfaceStation>& stations) const {
        const double together_mm = together_radii * options_.ball_radius_mm;
        std::vector<std::size_t> spoken_for;
        std::size_t kept = 0;
        for (std::size_t k = 1; k < cuts.size(); ++k) {
            if (!cuts[kept] || !cuts[k] || stations[k].t - stations[kept].t >= together_mm) {
                kept = k;
                continue;
            }
            const bool better = stations[k].lean_doubt_mm < stations[kept].lean_doubt_mm;
            const std::size_t left = better ? std::exchange(kept, k) : k;
            const double t = std::exchange(stations[left].t, stations[kept].t);
            stations[left] = stations[kept];
            stations[left].t = t;
            cuts[left].reset();
            spoken_for.push_back(left);
        }
        return spoken_for;
    }

    /// With its neighbours, through which a place that is not sure may draw the curve along.
    static bool sure_near(std::size_t k, const std::vector<std::optional<Cut>>& cuts) {
        const std::size_t n = cuts.size();
        return cuts[(k + n - 1) % n]->sure && cuts[k]->sure && cuts[(k + 1) % n]->sure;
    }

    /// The largest near by: the forecast may be right by chance.
    double doubt_near(std::size_t k, OffsetOverHeight Ways::*which) const {
        const std::size_t n = ways_.size();
        double doubt = 0.0;
        for (std::size_t i = k + n - breaks_beside; i <= k + n + breaks_beside; ++i)
            if (const auto& offsets = ways_[i % n].*which; offsets.count() > 0 || i == k + n)
                doubt = std::max(doubt, offsets.slope_error());
        return doubt;
    }

    /// Where tangents touch, the shift is that of the tangent; the curve lies behind it by h'^2 / 2 R on the normal's
    /// line, h' the slope of the shift over the normal's direction, R the radius of curvature.
    Vec2 shift_at(std::size_t k, const std::vector<std::optional<Cut>>& cuts) const {
        const auto at = [&](std::size_t i) { return curve().jet(curve().breaks()[i]); };
        const std::size_t n = cuts.size(), last = (k + n - 1) % n, next = (k + 1) % n;
        double shift = cuts[k]->shift_mm;
        if (cuts[last]->by_tangents && cuts[k]->by_tangents && cuts[next]->by_tangents) {
            const double way = (at(next).position - at(last).position).norm();
            const double turn = turn_angle(at(last).d1, at(next).d1),
                         change = cuts[next]->shift_mm - cuts[last]->shift_mm;
            if (turn * most_radii * options_.ball_radius_mm > way) shift -= 0.5 * change * change / (turn * way);
        }
        return shift * at(k).right_normal();
    }

    /// The places of another section that belong to those of this one.
    void meet(const SectionFit& other, double height_mm) {
        std::vector<std::size_t> places;
        std::vector<Vec2> points;
        for (const std::size_t k : open_) {
            if (ways_[k].line.full() && ways_[k].support.full()) continue;
            places.push_back(k);
            points.push_back(curve().pieces()[k][0]);
        }
        if (places.empty()) return;
        const PiecewiseCubic& theirs = other.centres.curve.curve;
        const ClosestPointIndex index(theirs);
        const MeasuredAlong measured(other);
        const Tangents tangents(theirs);
        index.for_each(points, [&](std::size_t i, const CurveFoot& foot) {
            const Jet own = curve().jet(curve().breaks()[places[i]]);
            const Vec2 &from = points[i], outward = own.right_normal();
            const auto take = [&](OffsetOverHeight& offsets, double near, const auto& off, const auto& by_t) {
                if (offsets.full()) return;
                const auto t = solved(theirs, near, off, by_t);
                if (!t || !measured.at(*t)) return;
                const Jet jet = theirs.jet(theirs.wrap(*t));
                const double along = (jet.position - from).dot(outward);
                if (jet.right_normal().dot(outward) > least_facing &&
                    std::abs(along) < steepest_way * std::abs(height_mm))
                    offsets.add(height_mm, along);
            };
            take(
                ways_[places[i]].line, foot.t, [&](const Jet& j) { return cross(outward, j.position - from); },
                [&](const Jet& j) { return cross(outward, j.d1); });
            if (const auto touch = tangents.nearest(from, outward); touch && sharp(own) && sharp(theirs.jet(*touch)))
                take(
                    ways_[places[i]].support, *touch, [&](const Jet& j) { return j.d1.dot(outward); },
                    [&](const Jet& j) { return j.d2.dot(outward); });
        });
    }

    /// On flat sides tangents of one direction touch far apart, or at several places.
    bool sharp(const Jet& jet) const { return jet.curvature() * flattest_radii * options_.ball_radius_mm > 1.0; }

    /// Where `off` is nought, near t.
    static std::optional<double> solved(const PiecewiseCubic& curve, double t, const auto& off, const auto& by_t) {
        const double longest = 0.02 * curve.period();
        for (int step = 0; step < newton_steps; ++step) {
            const Jet jet = curve.jet(curve.wrap(t));
            const double slope = by_t(jet);
            if (slope == 0.0) return std::nullopt;
            const double move = std::clamp(off(jet) / slope, -longest, longest);
            t -= move;
            if (std::abs(move) < met_mm) return t;
        }
        return std::nullopt;
    }

    /// Over places that nothing is known of, evenly from one side to the other.
    void bridge(std::vector<std::optional<Cut>>& cuts) const {
        const std::size_t n = cuts.size();
        const auto way = [&](std::size_t from, std::size_t to) {
            return to == from + n ? curve().period()
                                  : curve().ahead(curve().breaks()[from % n], curve().breaks()[to % n]);
        };
        const auto known = std::find_if(cuts.begin(), cuts.end(), [](const auto& cut) { return cut.has_value(); });
        const auto first = static_cast<std::size_t>(known - cuts.begin());
        for (std::size_t last = first, k = first + 1; k <= first + n; ++k) {
            if (!cuts[k % n]) continue;
            const Cut from = *cuts[last % n], to = *cuts[k % n];
            for (std::size_t i = last + 1; i < k; ++i) {
                const double share = way(last, i) / way(last, k);
                cuts[i % n] = Cut{from.shift_mm + share * (to.shift_mm - from.shift_mm),
                                  from.lean_rad + share * (to.lean_rad - from.lean_rad)};
            }
            last = k;
        }
    }

    std::span<const SectionInPlane> sections_;
    std::size_t own_;
    const SectionFit& fit_;
    const SectionOptions& options_;
    std::vector<std::size_t> others_;  // nearest first
    std::vector<Ways> ways_;           // by break of the curve
    std::vector<std::size_t> open_;    // those at measured places
};

}  // namespace

core::Result<SurfaceSection> compensate_by_sections(std::span<const SectionInPlane> sections, std::size_t own,
                                                    const SectionOptions& options) {
    if (!(options.ball_radius_mm > 0.0) || !std::isfinite(options.ball_radius_mm))
        return core::fail(core::ErrorCode::fit_not_evaluable, "compensation: the ball radius must be above 0");
    return LeanBySections(sections, own, options).run();
}

}  // namespace cmm::fitting
