// SPDX-License-Identifier: Apache-2.0
#include "fitting/edge_fit.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <span>
#include <utility>
#include <variant>

#include "core/text.hpp"
#include "fitting/circle.hpp"
#include "fitting/edge_form.hpp"

namespace cmm::fitting {
namespace {

constexpr double around_share = 1.75;         // of the edge zone's length, to either side of its middle
constexpr std::ptrdiff_t points_beyond = 24;  // of the sides, for the bridges
constexpr double nearest_share = 0.45;        // of the way to the other edge
constexpr double roughly_circular = 0.05;     // rms over radius above which a radius means nothing
constexpr double circular_mm = 0.5e-3;        // deviation from a circle that needs no noise to excuse it
constexpr double whole_turn = 2.0 * std::numbers::pi;
constexpr double strong_evidence = 6.0;  // Kass and Raftery 1995: what replaces the free form must be surer than a name

double u95(const ModelTrial& trial, const Eigen::VectorXd& slopes) {
    return coverage_95(trial.noise.freedom) * std::sqrt(std::max(0.0, slopes.dot(trial.covariance * slopes)));
}

/// Names the shape's parameters and its curvature at the nose.
struct Describer {
    const ModelTrial& trial;
    Vec2 nose;  // normal
    EdgeFit& fit;
    Eigen::MatrixXd& by_shape;  ///< of centre and radius

    void operator()(const std::monostate&) const {}

    void operator()(const ArcShape& s) const {
        set_radius(s.values()[2], s.values().head<2>(), Eigen::Vector3d::UnitZ());
        set_covariance(Eigen::Matrix3d::Identity());
        fit.parameters = {{"radius_mm", fit.radius_mm, fit.radius_u95_mm}};
    }

    void operator()(const EllipseShape& s) const {
        const auto& v = s.values();
        set_vertex(v.head<2>(), v[2], v[3], Eigen::VectorXd::Unit(5, 3));
        Eigen::VectorXd along = Eigen::VectorXd::Zero(5), across = along;
        along[3] = 1.0 / v[4];
        along[4] = -v[3] / (v[4] * v[4]);
        across[3] = 1.0 / std::sqrt(v[4]);
        across[4] = -0.5 * v[3] / std::pow(v[4], 1.5);
        fit.parameters = {{"semi_axis_along_mm", s.semi_axis_along(), u95(trial, along)},
                          {"semi_axis_across_mm", s.semi_axis_across(), u95(trial, across)},
                          {"direction_rad", std::remainder(v[2], whole_turn), u95(trial, Eigen::VectorXd::Unit(5, 2))}};
    }

    void operator()(const ParabolaShape& s) const {
        const auto& v = s.values();
        set_vertex(v.head<2>(), v[2], v[3], Eigen::VectorXd::Unit(4, 3));
        fit.parameters = {{"nose_radius_mm", v[3], fit.radius_u95_mm},
                          {"direction_rad", std::remainder(v[2], whole_turn), u95(trial, Eigen::VectorXd::Unit(4, 2))}};
    }

    void operator()(const DoubleArcShape& s) const {
        const auto& v = s.values();
        const bool second = cross(Vec2(std::cos(v[4]), std::sin(v[4])), nose) > 0.0;
        set_radius(second ? v[3] : v[2], second ? s.second_centre() : Vec2(v.head<2>()),
                   Eigen::VectorXd::Unit(5, second ? 3 : 2));
        Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(3, 5);
        jacobian.topLeftCorner(2, 2).setIdentity();
        jacobian(2, second ? 3 : 2) = 1.0;
        if (second) {
            const Vec2 axis(std::cos(v[4]), std::sin(v[4]));
            jacobian.block<2, 1>(0, 2) = axis;
            jacobian.block<2, 1>(0, 3) = -axis;
            jacobian.block<2, 1>(0, 4) = (v[2] - v[3]) * left_of(axis);
        }
        set_covariance(jacobian);
        fit.parameters = {{"first_radius_mm", v[2], u95(trial, Eigen::VectorXd::Unit(5, 2))},
                          {"second_radius_mm", v[3], u95(trial, Eigen::VectorXd::Unit(5, 3))},
                          {"direction_rad", std::remainder(v[4], whole_turn), u95(trial, Eigen::VectorXd::Unit(5, 4))}};
    }

  private:
    void set_radius(double radius, const Vec2& centre, const Eigen::VectorXd& slopes) const {
        fit.radius_mm = radius;
        fit.centre_mm = centre;
        fit.radius_u95_mm = u95(trial, slopes);
    }
    void set_vertex(const Vec2& vertex, double direction, double radius, const Eigen::VectorXd& slopes) const {
        const Vec2 axis(std::cos(direction), std::sin(direction));
        set_radius(radius, vertex - radius * axis, slopes);
        Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(3, slopes.size());
        jacobian.topLeftCorner(2, 2).setIdentity();
        jacobian.block<2, 1>(0, 2) = -radius * left_of(axis);
        jacobian.block<2, 1>(0, 3) = -axis;
        jacobian(2, 3) = 1.0;
        set_covariance(jacobian);
    }
    /// `jacobian`: of centre and radius by the shape's parameters.
    void set_covariance(const Eigen::MatrixXd& jacobian) const {
        by_shape = jacobian;
        fit.covariance_mm2 = jacobian * trial.covariance * jacobian.transpose();
    }
};

/// Of the shape's parameters by least squares, first order.
struct Answerer {
    std::span<const EdgePoint> points;
    const Eigen::MatrixXd& by_shape;

    Eigen::MatrixXd operator()(const std::monostate&) const { return {}; }
    template <class Shape>
    Eigen::MatrixXd operator()(const Shape& shape) const {
        const auto n = static_cast<Eigen::Index>(points.size());
        Eigen::MatrixXd rows(n, Shape::size);
        for (Eigen::Index i = 0; i < n; ++i) {
            const EdgePoint& point = points[static_cast<std::size_t>(i)];
            rows.row(i) = shape.foot(point.centre, point.normal).slopes.transpose();
        }
        return by_shape * (rows.transpose() * rows).ldlt().solve(rows.transpose());
    }
};

/// Of a circle through points of the curve of ball centres.
EdgeAnswer answer_of_circle(std::span<const Vec2> points, std::span<const double> t, const Vec2& centre) {
    EdgeAnswer answer{{t.begin(), t.end()}, {}};
    Eigen::MatrixXd rows(static_cast<Eigen::Index>(points.size()), 3);
    for (std::size_t i = 0; i < points.size(); ++i) {
        const Vec2 outward = (points[i] - centre).normalized();
        rows.row(static_cast<Eigen::Index>(i)) << outward.x(), outward.y(), 1.0;
    }
    answer.by_point = (rows.transpose() * rows).ldlt().solve(rows.transpose());
    return answer;
}

void judge_radius(EdgeFit& fit) {
    if (fit.radius_mm <= fit.radius_u95_mm)
        fit.why = "sharp: the radius is not above its uncertainty of " + core::length_text(fit.radius_u95_mm);
    else if (fit.arc_angle_rad < shortest_arc_rad)
        fit.why = "an arc of " + core::fixed(fit.arc_angle_rad * 180.0 / std::numbers::pi, 0) +
                  " degrees is too short for a radius (60 degrees)";
    else
        fit.valid = true;
}

}  // namespace

EdgeFitter::EdgeFitter(const EdgeSource& source) : source_(source), order_(source.points.size()) {
    std::iota(order_.begin(), order_.end(), std::size_t{0});
    const std::vector<double>& t = source.smooth.parameter;
    const auto before = [&](std::size_t a, std::size_t b) { return t[a] < t[b]; };
    if (!std::is_sorted(order_.begin(), order_.end(), before)) std::sort(order_.begin(), order_.end(), before);
}

double EdgeFitter::t_of(std::ptrdiff_t k) const {
    const auto n = static_cast<std::ptrdiff_t>(order_.size());
    const std::ptrdiff_t lap = k >= 0 ? k / n : -((n - 1 - k) / n);
    return source_.smooth.parameter[order_[static_cast<std::size_t>(k - lap * n)]] +
           source_.smooth.curve.period() * static_cast<double>(lap);
}

EdgeFitter::Surroundings EdgeFitter::surroundings(const EdgeRegion& region, const EdgeRegion& other) const {
    const PiecewiseCubic& curve = source_.smooth.curve;
    const double period = curve.period();
    const auto ahead = [&](double from, double to) {
        const double way = std::fmod(to - from, period);
        return way < 0.0 ? way + period : way;
    };
    const auto t_at = [&](std::size_t i) { return source_.part[i].t; };
    const double begin = t_at(region.begin), length = ahead(begin, t_at(region.end));
    const double middle = begin + 0.5 * length;
    const double most_ahead = nearest_share * ahead(middle, t_at(other.begin));
    const double most_behind = nearest_share * ahead(t_at(other.end), middle);
    const double reach = around_share * length;

    const auto n = static_cast<std::ptrdiff_t>(order_.size());
    const double wrapped = curve.wrap(middle);
    const auto at = std::lower_bound(order_.begin(), order_.end(), wrapped,
                                     [&](std::size_t i, double value) { return source_.smooth.parameter[i] < value; });
    const std::ptrdiff_t centre = at - order_.begin();
    std::ptrdiff_t first = centre, last = centre;  // [first, last)
    while (centre - first < n / 2 && wrapped - t_of(first - 1) < reach)
        --first;
    while (last - centre < n / 2 && t_of(last) - wrapped < reach)
        ++last;
    for (std::ptrdiff_t k = 0; k < points_beyond; ++k) {
        --first;
        ++last;
    }
    while (first < centre && wrapped - t_of(first) > most_behind)
        ++first;
    while (last > centre && t_of(last - 1) - wrapped > most_ahead)
        --last;

    Surroundings around{first, last, middle - wrapped};
    for (const CurvatureStep& joint : source_.smooth.joints) {
        const double off = std::remainder(joint.t - wrapped, period);
        if (off > t_of(first) - wrapped && off < t_of(last - 1) - wrapped) ++around.joints;
    }
    for (const Gap& gap : source_.gaps) {
        const double before = source_.smooth.parameter[gap.before];
        const double off =
            std::remainder(before + 0.5 * ahead(before, source_.smooth.parameter[gap.behind]) - wrapped, period);
        around.over_gap = around.over_gap || (off > t_of(first) - wrapped && off < t_of(last - 1) - wrapped);
    }
    return around;
}

bool EdgeFitter::may_patch(const EdgeRegion& region, const EdgeRegion& other) const {
    return may_patch(surroundings(region, other));
}

bool EdgeFitter::may_patch(const Surroundings& around) const {
    return source_.noise.sigma_mm > least_noise_mm && around.joints == 0 && !around.over_gap;
}

EdgeFitter::Gathered EdgeFitter::gather(const EdgeRegion& region, const Surroundings& around) const {
    const PiecewiseCubic& curve = source_.smooth.curve;
    const auto n = static_cast<std::ptrdiff_t>(order_.size());
    Gathered out;
    out.edge.joints = around.joints;
    out.edge.ball_mm = source_.ball_mm;
    out.edge.noise = source_.noise;
    const Vec2& nose = source_.part[region.middle].normal;
    double best = -2.0;
    for (std::ptrdiff_t k = around.first; k < around.last; ++k) {
        const double t = t_of(k);
        double inside = t;
        const std::size_t span = curve.span_of(inside), i = order_[static_cast<std::size_t>((k % n + n) % n)];
        EdgePoint point;
        point.centre = source_.points[i];
        point.normal = curve.jet_in(span, inside).right_normal();
        point.residual_mm = source_.smooth.residual[i];
        point.leverage = source_.leverage.empty() ? source_.smooth.leverage[i] : source_.leverage[i];
        if (const double alike = point.normal.dot(nose); alike > best) {
            best = alike;
            out.edge.nose = out.edge.points.size();
        }
        out.edge.points.push_back(point);
        out.t.push_back(t + around.shift);
    }
    return out;
}

/// The gathered points from one transition to the other.
std::pair<std::size_t, std::size_t> EdgeFitter::zone_points(const EdgeRegion& region, const Gathered& gathered) const {
    const double begin = source_.part[region.begin].t;
    double end = source_.part[region.end].t;
    if (end < begin) end += source_.smooth.curve.period();
    const auto& t = gathered.t;
    return {static_cast<std::size_t>(std::lower_bound(t.begin(), t.end(), begin) - t.begin()),
            static_cast<std::size_t>(std::upper_bound(t.begin(), t.end(), end) - t.begin())};
}

/// The mean circle of the zone's middle part, for a radius; the contour stays free form.
EdgeFit EdgeFitter::free_form(const EdgeRegion& region, const Gathered& gathered, EdgeAnswer& answer) const {
    EdgeFit fit;
    const auto [first, last] = zone_points(region, gathered);
    const auto trim = static_cast<std::size_t>(0.5 * (1.0 - mean_circle_share) * static_cast<double>(last - first));
    std::vector<Vec2> points;
    for (std::size_t i = first + trim; i + trim < last; ++i)
        points.push_back(gathered.edge.points[i].centre);
    const auto circle = fit_circle(points, source_.noise);
    if (circle)
        answer = answer_of_circle(points, std::span(gathered.t).subspan(first + trim, points.size()), circle->centre);
    if (!circle) {
        fit.why = circle.error().message;
        return fit;
    }
    fit.centre_mm = circle->centre;
    fit.radius_mm = circle->radius - source_.ball_mm;
    fit.radius_u95_mm = circle->radius_u95;
    fit.covariance_mm2 = circle->covariance;
    fit.arc_angle_rad = circle->arc_angle;
    fit.rms_mm = circle->rms;
    judge_radius(fit);
    if (!fit.valid) return fit;
    fit.why = "free form: the points support none of the models";
    if (circle->rms > std::max(3.0 * std::max(source_.noise.sigma_mm, circular_mm), roughly_circular * fit.radius_mm)) {
        fit.valid = false;
        fit.why = "not circular: the points leave the circle by " + core::length_text(circle->rms) + " rms";
    }
    return fit;
}

EdgeOutcome EdgeFitter::run(const EdgeRegion& region, const EdgeRegion& other, std::optional<EdgeModel> request) const {
    const Surroundings around = surroundings(region, other);
    const Gathered gathered = gather(region, around);
    const auto [first, last] = zone_points(region, gathered);
    const FormFinding finding = recognise_form(gathered.edge, first, last);
    // A model that was asked for is tried on any end that was measured as a whole.
    if (finding.form == EdgeForm::partial || (finding.form != EdgeForm::round && !request)) {
        EdgeOutcome refused;
        refused.fit.form = finding.form;
        refused.fit.why = finding.text();
        return refused;
    }
    const EdgeChoice choice = choose_edge_model(gathered.edge, request);
    EdgeOutcome outcome;
    if (!choice.chosen) {
        outcome.fit = free_form(region, gathered, outcome.answer);
    } else {
        const ModelTrial& trial = choice.trials[*choice.chosen];
        EdgeFit& fit = outcome.fit;
        fit.model = trial.model;
        fit.rms_mm = trial.rms_mm;
        fit.arc_angle_rad =
            turn_angle(gathered.edge.points[trial.begin].normal, gathered.edge.points[gathered.edge.nose].normal) +
            turn_angle(gathered.edge.points[gathered.edge.nose].normal, gathered.edge.points[trial.end - 1].normal);
        Eigen::MatrixXd by_shape;
        std::visit(Describer{trial, gathered.edge.points[gathered.edge.nose].normal, fit, by_shape}, trial.shape);
        const std::size_t count = trial.end - trial.begin;
        outcome.answer.t.assign(gathered.t.begin() + static_cast<std::ptrdiff_t>(trial.begin),
                                gathered.t.begin() + static_cast<std::ptrdiff_t>(trial.end));
        outcome.answer.by_point =
            std::visit(Answerer{std::span(gathered.edge.points).subspan(trial.begin, count), by_shape}, trial.shape);
        judge_radius(fit);
        if (trial.gain >= strong_evidence && may_patch(around))
            outcome.patch = make_patch(source_.smooth.curve, gathered.edge, gathered.t, trial);
        fit.used_in_contour = outcome.patch.has_value();
    }
    for (const ModelTrial& trial : choice.trials) {
        const auto* const arc = std::get_if<ArcShape>(&trial.shape);
        outcome.fit.evidence.push_back(
            {trial.model, trial.rms_mm, trial.gain, trial.why, arc != nullptr ? arc->values()[2] : 0.0});
    }
    return outcome;
}

}  // namespace cmm::fitting
