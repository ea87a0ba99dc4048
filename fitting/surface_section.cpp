// SPDX-License-Identifier: Apache-2.0
#include "fitting/surface_section.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "fitting/closed_curve.hpp"
#include "fitting/closest_point.hpp"
#include "fitting/displaced_row.hpp"
#include "fitting/offset.hpp"
#include "fitting/section_mover.hpp"
#include "fitting/slope_forecast.hpp"
#include "fitting/surface_cut.hpp"

namespace cmm::fitting {
namespace {

constexpr std::size_t parts_of_a_span = 8;
constexpr std::size_t looked_ahead = 48;
constexpr double section_window_share = 0.04;  // of the curve's breaks, to either side
// Of the noise of the curve: up to there an rms distance of the surface is explained by it, from there on not at all.
constexpr double explained_sigmas = 1.5, own_sigmas = 3.0;
constexpr double least_scatter_freedom = 2.0;  // of a column, that its rows leave
/// From a joint of the curve, as far as what is not known of its place is felt, wholly and at all.
constexpr double joint_spans = 6.0, no_joint_spans = 12.0;
constexpr double joint_break_share = 0.1;  // of a span: how near the breaks at a joint are
constexpr double clear_break_share = 0.3;  // of that: nearer to others there are none

/// How well the other sections foretell a section: the polynomial through their points along each u = const.
class NeighbourForecast {
  public:
    /// Of the section at z with the curve of ball centres `own`. `u`: the places that will be asked for.
    NeighbourForecast(const SurfaceCompensation& surface, double z, const PiecewiseCubic& own,
                      std::span<const double> u)
        : others_(nearest_others(surface.rows(), z)), slope_(heights(others_, z)), off_(u.size(), Vec2::Zero()) {
        add(surface, z, own, u, -1.0);
        for (std::size_t k = 0; k < others_.size(); ++k)
            add(surface, others_[k]->z_mm(), others_[k]->smooth().curve, u, slope_.weight(k));
    }

    /// By so much the polynomial misses the section at place i, along the unit normal in the plane.
    double missed_mm(std::size_t i, const Vec2& outward) const { return off_[i].dot(outward); }
    /// Of the slope of a column that was missed so, as an angle.
    double slope_error(double missed_mm) const { return slope_.slope_error(missed_mm); }

  private:
    using Others = std::vector<const SurfaceRow*>;

    static Others nearest_others(std::span<const SurfaceRow> rows, double z) {
        Others others;
        for (const SurfaceRow& row : rows)
            if (row.z_mm() != z) others.push_back(&row);
        std::sort(others.begin(), others.end(), [&](const SurfaceRow* a, const SurfaceRow* b) {
            return std::abs(a->z_mm() - z) < std::abs(b->z_mm() - z);
        });
        others.resize(std::min(others.size(), SlopeForecast::most_others));
        return others;
    }
    static std::vector<double> heights(const Others& others, double z) {
        std::vector<double> out;
        for (const SurfaceRow* other : others)
            out.push_back(other->z_mm() - z);
        return out;
    }
    /// The section's own points beside those of the surface.
    void add(const SurfaceCompensation& surface, double z, const PiecewiseCubic& own, std::span<const double> u,
             double weight) {
        std::vector<Vec2> points;
        for (const double place : u)
            points.push_back(surface.centres()->surface.position({place, z}).head<2>());
        std::vector<ClosestPoint> feet(points.size());
        ClosedCurve(own).closest(points, feet);
        for (std::size_t i = 0; i < feet.size(); ++i)
            off_[i] += weight * feet[i].foot;
    }

    Others others_;
    SlopeForecast slope_;
    std::vector<Vec2> off_;
};

/// The root of the mean square over a window of a closed sequence.
std::vector<double> local_rms(const std::vector<double>& values) {
    const std::size_t n = values.size();
    const auto half = std::max<std::size_t>(2, static_cast<std::size_t>(section_window_share * static_cast<double>(n)));
    std::vector<double> rms(n);
    for (std::size_t i = 0; i < n; ++i) {
        double sum = 0.0;
        for (std::size_t k = 0; k <= 2 * half; ++k) {
            const double value = values[(i + n - half % n + k) % n];
            sum += value * value;
        }
        rms[i] = std::sqrt(sum / static_cast<double>(2 * half + 1));
    }
    return rms;
}

/// Along two closed curves side by side: the point of `to` that is nearest to each of `from`, not far from that of the
/// one before, so that a thin edge is not taken for its other side.
std::vector<std::size_t> nearest_along(std::span<const Vec2> from, std::span<const Vec2> to) {
    const std::size_t n = to.size();
    const auto squared = [&](std::size_t j, const Vec2& p) { return (to[j % n] - p).squaredNorm(); };
    std::size_t at = 0;
    for (std::size_t j = 1; j < n; ++j)
        if (squared(j, from[0]) < squared(at, from[0])) at = j;
    std::vector<std::size_t> found;
    for (const Vec2& p : from) {
        const std::size_t first = at + n - std::min(looked_ahead, n);
        std::size_t best = at;
        for (std::size_t j = first; j <= first + 2 * looked_ahead; ++j)
            if (squared(j, p) < squared(best, p)) best = j;
        at = best % n;
        found.push_back(at);
    }
    return found;
}

/// The point of `cut` that is nearest to each place of the curve, among those that face the same way.
std::vector<std::size_t> nearest_facing(const PiecewiseCubic& curve, std::span<const Vec2> own,
                                        std::span<const Vec2> wanted, std::span<const CutPoint> cut) {
    std::vector<std::size_t> found;
    for (std::size_t k = 0; k < own.size(); ++k) {
        const Vec2 outward = curve.jet(curve.breaks()[k]).right_normal();
        std::size_t best = 0;
        double best_squared = std::numeric_limits<double>::infinity();
        for (std::size_t j = 0; j < wanted.size(); ++j) {
            const double squared = (wanted[j] - own[k]).squaredNorm();
            if (squared >= best_squared || cut[j].normal.head<2>().dot(outward) < 0.0) continue;
            best = j;
            best_squared = squared;
        }
        found.push_back(best);
    }
    return found;
}

class SurfaceLook {
  public:
    /// `of_surface`: the section is one of those that the surface was made of.
    SurfaceLook(const SurfaceCompensation& surface, double z_mm, const SmoothCurve& smooth, bool of_surface,
                std::size_t row, const SectionFit& flat, const SectionOptions& options, const NominalNormal& nominal)
        : surface_(surface),
          z_mm_(z_mm),
          of_surface_(of_surface),
          follows_(of_surface),
          row_(row),
          flat_(flat),
          options_(options),
          nominal_(nominal),
          smooth_(smooth) {}

    core::Result<SurfaceSection> run() {
        if (auto status = lay_on_surface(); !status) return tl::unexpected(status.error());
        if (auto status = break_at_joints(); !status) return tl::unexpected(status.error());
        for (std::size_t k = 0; k < curve_.spans(); ++k)
            own_.push_back(curve_.pieces()[k][0]);
        if (auto status = look_up(); !status) return tl::unexpected(status.error());
        return move_section(smooth_, std::move(movement_), flat_, options_);
    }

  private:
    /// A section that lies apart as a whole has the lean of the places that it would lie at with the others.
    core::Status lay_on_surface() {
        const Surface& surface = surface_.centres()->surface;
        std::vector<Vec2> level;
        for (const double u : span_parameters(surface.u(), parts_of_a_span))
            level.push_back(surface.position({u, z_mm_}).head<2>());
        auto curve = ClosedCurve::through(level);
        if (!curve) return tl::unexpected(curve.error());
        level_curve_ = std::move(*curve);
        if (const auto displacement = displacement_of(smooth_, level_curve_)) {
            displacement_ = *displacement;
            follows_ = false;
        }
        curve_ = undone(smooth_.curve, displacement_);
        return {};
    }

    /// Where the plane of the section cuts the surface of contacts.
    struct Cut {
        std::vector<CutPoint> points;
        std::vector<double> off_nominal_rad;  // with a nominal: by which the surface there leans otherwise
    };
    /// At these u. With a nominal by its lean: the 2-D offset's error is another then, and how the surface bends over z
    /// is what the sections below have told.
    core::Result<Cut> cut_at(std::span<const double> u) const {
        const double r = options_.ball_radius_mm;
        auto found = cut_at_height(surface_.centres()->surface, -r, z_mm_, u);
        if (!found) return tl::unexpected(found.error());
        Cut cut{std::move(found->points), {}};
        if (!nominal_) return cut;
        for (CutPoint& p : cut.points) {
            const Vec2 outward = p.normal.head<2>().normalized();
            const double told = lean_of(nominal_(p.position.head<2>() + r * outward, outward)), own = lean_of(p.normal);
            p.position.head<2>() -= (lean_error(r, told).in_plane_mm - lean_error(r, own).in_plane_mm) * outward;
            p.normal << std::cos(told) * outward, std::sin(told);
            cut.off_nominal_rad.push_back(std::abs(told - own));
        }
        return cut;
    }
    static double lean_of(const Vec3& normal) { return std::asin(std::clamp(normal.z(), -1.0, 1.0)); }

    /// Where the wall leans, the ball meets the end of an edge beside where the cut has it (0.02 mm and more): there
    /// the movement, too, has to bend at once.
    core::Status break_at_joints() {
        const double r = options_.ball_radius_mm;
        const auto cut = cut_at(surface_.centres()->joints);
        if (!cut) return tl::unexpected(cut.error());
        const ClosestPointIndex own(curve_);
        const auto& breaks = curve_.breaks();
        struct Break {
            double t, clear;  // parameter, and how far from others it has to be
        };
        std::vector<Break> wanted;
        std::size_t span = 0;
        for (const CutPoint& p : cut->points) {
            const CurveFoot foot = own.closest(p.position.head<2>() + r * p.normal.head<2>().normalized(), span);
            span = foot.span;
            // The spans at the curve's own joints are narrow.
            double widest = 0.0;
            for (std::size_t k = span > 0 ? span - 1 : 0; k < std::min(span + 2, curve_.spans()); ++k)
                widest = std::max(widest, breaks[k + 1] - breaks[k]);
            const double apart = joint_break_share * widest;
            for (const double t : {foot.t - apart, foot.t, foot.t + apart})
                if (t > breaks.front() && t < breaks.back()) wanted.push_back({t, clear_break_share * apart});
        }
        std::sort(wanted.begin(), wanted.end(), [](const Break& a, const Break& b) { return a.t < b.t; });
        std::vector<double> places;
        for (const auto& [t, clear] : wanted) {
            const auto above = std::upper_bound(breaks.begin(), breaks.end(), t);
            const double last = places.empty() ? *(above - 1) : std::max(*(above - 1), places.back());
            if (t - last > clear && *above - t > clear) places.push_back(t);
        }
        smooth_.curve = smooth_.curve.broken_at(places);
        curve_ = undone(smooth_.curve, displacement_);
        return {};
    }

    /// At every break of the curve: where it belongs, and what the surface says.
    core::Status look_up() {
        const Surface& surface = surface_.centres()->surface;
        const double r = options_.ball_radius_mm;
        const auto cut = cut_at(span_parameters(surface.u(), parts_of_a_span));
        if (!cut) return tl::unexpected(cut.error());
        std::vector<Vec2> wanted;
        for (const CutPoint& p : cut->points)
            wanted.push_back(p.position.head<2>() + r * p.normal.head<2>().normalized());
        const auto wanted_curve = ClosedCurve::through(wanted);
        if (!wanted_curve) return tl::unexpected(wanted_curve.error());
        const std::size_t n = own_.size();
        std::vector<ClosestPoint> feet(n), level_feet(n);
        wanted_curve->closest(own_, feet);
        level_curve_.closest(own_, level_feet);
        std::vector<double> off(n);
        for (std::size_t k = 0; k < n; ++k)
            off[k] = level_feet[k].distance_mm;
        const auto rms = local_rms(off);
        const auto place =
            of_surface_ ? nearest_along(own_, wanted) : nearest_facing(curve_, own_, wanted, cut->points);
        std::vector<double> u;
        for (const std::size_t i : place)
            u.push_back(cut->points[i].place.u);
        const std::vector<double> beside = beside_joints();
        const NeighbourForecast forecast(surface_, z_mm_, smooth_.curve, u);
        for (std::size_t k = 0; k < n; ++k) {
            const double t = curve_.breaks()[k], noise = smooth_.noise.sigma_mm(t);
            const double explained =
                follows_
                    ? std::clamp((own_sigmas * noise - rms[k]) / ((own_sigmas - explained_sigmas) * noise), 0.0, 1.0)
                    : 0.0;
            const CutPoint& p = cut->points[place[k]];
            const Vec2 outward = p.normal.head<2>().normalized();
            movement_.shift.push_back(
                displacement_.apply_to_direction(feet[k].foot - own_[k] + (1.0 - explained) * off[k] * outward));
            SurfaceStation s = station(t, p);
            if (nominal_) {
                s.doubt(options_.ball_radius_mm, cut->off_nominal_rad[place[k]]);
            } else {
                const double missed_mm = forecast.missed_mm(k, outward), error = forecast.slope_error(missed_mm);
                s.doubt(options_.ball_radius_mm, error);
                if (std::isfinite(error)) s.drawn_doubt_mm = std::copysign(s.lean_doubt_mm, missed_mm * s.lean_rad);
            }
            movement_.stations.push_back(s);
            if (explained > 0.0)
                take_shares({p.place.u, noise, rms[k], beside[k]}, explained, movement_.stations.back());
        }
        return {};
    }

    /// By spans from the nearest joint of the section's curve: 1 beside it, 0 far from it.
    std::vector<double> beside_joints() const {
        const std::size_t n = curve_.spans();
        std::vector<double> beside(n, 0.0);
        for (const CurvatureStep& joint : smooth_.joints) {
            double t = joint.t;
            const std::size_t at = curve_.span_of(t);
            for (std::size_t k = 0; k < n; ++k) {
                const std::size_t apart = at > k ? at - k : k - at;
                const auto spans = static_cast<double>(std::min(apart, n - apart));
                const double share = (no_joint_spans - spans) / (no_joint_spans - joint_spans);
                beside[k] = std::max(beside[k], std::clamp(share, 0.0, 1.0));
            }
        }
        return beside;
    }

    struct Place {
        double u, noise_mm, off_mm;  // of the surface; of the section's own curve; of the surface from it
        double beside;               // a joint
    };
    /// What the surface leaves of the noise of the section's own curve (docs/theory.md, section 12): of what scatters
    /// from row to row its leverage, of what the prior keeps the rows from alike what as many measurements of one would
    /// leave, and all beside joints, whose places the rows have from each other. Nowhere more than the own curve's
    /// noise and how far the surface is from it, together; that also where too few rows tell how they scatter.
    void take_shares(const Place& at, double explained, SurfaceStation& s) const {
        const SurfaceFit& fit = *surface_.centres();
        const std::size_t span = fit.surface.u().span_of(at.u, 0);
        const auto rows = static_cast<double>(surface_.rows().size());
        const double own = 1.0 + std::pow(at.off_mm / at.noise_mm, 2);
        double whole = own, scatter = own, kept = own;
        if (rows - fit.freedom_v[span] >= least_scatter_freedom) {
            scatter = fit.scatter.leverage[fit.scatter.weight[span]][row_];
            const double scattered = std::pow(fit.scatter.standard_mm[span] / at.noise_mm, 2);
            const double by_points = std::min(scattered, 1.0);
            const double alike = (1.0 + by_points * (1.0 - 1.0 / rows)) / (by_points * rows + 1.0 - by_points);
            kept = alike + at.beside * (1.0 - alike);
            whole = std::min(scatter * scattered + kept * (1.0 - by_points), own);
        }
        s.noise_share = 1.0 + explained * (std::sqrt(whole) - 1.0);
        s.scatter_share = 1.0 + explained * (std::sqrt(scatter) - 1.0);
        s.kept_share = 1.0 + explained * (std::sqrt(kept) - 1.0);
    }

    static SurfaceStation station(double t, const CutPoint& p) {
        SurfaceStation s;
        s.t = t;
        s.lean_rad = lean_of(p.normal);
        return s;
    }

    const SurfaceCompensation& surface_;
    double z_mm_;
    bool of_surface_, follows_;  // the latter: as far as its noise explains
    std::size_t row_;
    const SectionFit& flat_;
    const SectionOptions& options_;
    const NominalNormal& nominal_;
    SmoothCurve smooth_;        // of the section's ball centres, as the surface has it
    ClosedCurve level_curve_;   // of the surface at the section's height
    PlaneMotion displacement_;  // of the section from there
    PiecewiseCubic curve_;      // the section's without it
    std::vector<Vec2> own_;     // at its breaks
    SectionMovement movement_;
};

}  // namespace

core::Result<SurfaceSection> compensate_section(const SurfaceCompensation& surface, double z_mm, const SectionFit& flat,
                                                const SectionOptions& options, const NominalNormal& nominal) {
    const auto refuse = [](const char* why) { return core::fail(core::ErrorCode::fit_not_evaluable, why); };
    const auto rows = surface.rows();
    if (!surface.centres()) return refuse("compensation: no other section tells the lean");
    const auto row = std::find_if(rows.begin(), rows.end(), [&](const auto& r) { return r.z_mm() == z_mm; });
    const bool of_surface = row != rows.end();
    const SmoothCurve& smooth = of_surface ? row->smooth() : flat.centres.curve;
    if (flat.contour.empty() || smooth.parameter.size() != flat.centres.points.size())
        return refuse("compensation: the section's curve of ball centres is not that of its points");
    if (z_mm < rows.front().z_mm() || z_mm > rows.back().z_mm())
        return refuse("compensation: the section lies beyond those that tell the lean");
    return SurfaceLook(surface, z_mm, smooth, of_surface, static_cast<std::size_t>(row - rows.begin()), flat, options,
                       nominal)
        .run();
}

}  // namespace cmm::fitting
