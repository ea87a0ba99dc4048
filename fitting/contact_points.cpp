// SPDX-License-Identifier: Apache-2.0
#include "fitting/contact_points.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "fitting/cyclic.hpp"
#include "fitting/offset.hpp"

namespace cmm::fitting {
namespace {

using core::ErrorCode;
using Contacts = core::Result<std::vector<Contact>>;

constexpr double apart_radii = 0.2;  // of the ball radius: neighbours in a row are at least so far away
constexpr std::size_t fewest_centres = 8;
constexpr double coverage = 2.0;

Vec3 raised(const Vec2& p, double z) {
    return {p.x(), p.y(), z};
}

/// A centre with its neighbours in the row.
struct Triple {
    Vec2 before, at, after;
    double back() const { return (at - before).norm(); }
    double ahead() const { return (after - at).norm(); }
    /// Unit, outward: of the circle through the three. The angles of the tangent to both chords are half the arcs, so
    /// each chord's direction weighs the other's length.
    Vec2 normal() const {
        const double a = back(), b = ahead();
        return right_normal((at - before) / a * b + (after - at) / b * a).normalized();
    }
};

/// Of points at -a, 0 and b of a line, each with unit noise: standard deviation of the slope that the circle has in the
/// middle, and of the mean of both chords' slopes; where there is only one chord, of that one.
double circle_slope_noise(double a, double b) {
    return std::hypot(b / (a * (a + b)), (b - a) / (a * b), a / (b * (a + b)));
}
double chord_slope_noise(double a, double b) {
    return std::hypot(0.5 / a, 0.5 / a - 0.5 / b, 0.5 / b);
}
double single_slope_noise(double a) {
    return std::sqrt(2.0) / a;
}
/// A place on the polygon of a row: between two of its points.
struct Place {
    std::size_t from = 0, to = 0;
    double share = 0.0;
    Vec2 on(std::span<const Vec2> points) const { return points[from] + share * (points[to] - points[from]); }
};

/// Who is whose neighbour, by the centres.
class RowPoints {
  public:
    explicit RowPoints(std::span<const Vec2> points) : points_(points) {}

    /// Neighbours of a point in the row, in steps of one to the next that is a base away, or a quarter of the row.
    std::size_t before(std::size_t i, double base_mm) const { return step(i, points_.size() - 1, base_mm); }
    std::size_t after(std::size_t i, double base_mm) const { return step(i, 1, base_mm); }
    Triple triple(std::size_t i, double base_mm) const {
        return {points_[before(i, base_mm)], points_[i], points_[after(i, base_mm)]};
    }

    /// The nearest place that faces the same way.
    std::optional<Place> facing(const Vec2& p, const Vec2& outward) const {
        std::optional<Place> best;
        double best_squared = std::numeric_limits<double>::max();
        const std::size_t n = points_.size();
        for (std::size_t i = 0; i < n; ++i) {
            const std::size_t next = cyclic(i + 1, n);
            const Vec2 &a = points_[i], along = points_[next] - a;
            if (!(right_normal(along).dot(outward) > 0.0)) continue;
            const double share = std::clamp((p - a).dot(along) / along.squaredNorm(), 0.0, 1.0);
            const double squared = (a + share * along - p).squaredNorm();
            if (squared >= best_squared) continue;
            best = Place{i, next, share};
            best_squared = squared;
        }
        return best;
    }

  private:
    std::size_t step(std::size_t i, std::size_t by, double base_mm) const {
        const std::size_t n = points_.size();
        std::size_t k = (i + by) % n;
        for (std::size_t steps = 1; steps < n / 4 && (points_[k] - points_[i]).norm() < base_mm; ++steps)
            k = (k + by) % n;
        return k;
    }

    std::span<const Vec2> points_;
};

/// A centre with its neighbours in the row, below and above.
struct Cross {
    Triple row;
    Vec2 outward;
    double z = 0.0;
    std::optional<Vec3> below, above;

    bool one_sided() const { return !below || !above; }
    double down() const { return below ? (*below - raised(row.at, z)).norm() : 0.0; }
    double up() const { return above ? (*above - raised(row.at, z)).norm() : 0.0; }
};

/// A normal, and its standard deviation along the row and across.
struct Direction {
    Vec3 normal;
    double along = 0.0, across = 0.0;
};

/// Through the centre: heights along the row's outward normal over the place in the row and in z, each neighbour with
/// the inverse square of its distance. (By orthogonal distances the plane may stand on end, and with equal weights the
/// far neighbours tilt it along the row: over widely spaced sections a blade bends by more than its scan's pitch.)
Direction plane_normal(const Cross& c, double sigma) {
    const Vec3 at = raised(c.row.at, c.z), outward = raised(c.outward, 0.0);
    const Vec3 along = Vec3::UnitZ().cross(outward);
    std::vector<Vec3> ways{raised(c.row.before, c.z) - at, raised(c.row.after, c.z) - at};
    if (c.below) ways.emplace_back(*c.below - at);
    if (c.above) ways.emplace_back(*c.above - at);
    Eigen::Matrix2d normal = Eigen::Matrix2d::Zero();
    std::vector<Vec2> pull;  // of each neighbour's height on both slopes, by `normal`
    for (const Vec3& way : ways) {
        const Vec2 place(way.dot(along), way.z());
        pull.emplace_back(place / way.squaredNorm());
        normal += pull.back() * place.transpose();
    }
    const Eigen::Matrix2d inverse = normal.inverse();
    Vec2 slope = Vec2::Zero(), sum = Vec2::Zero(), squares = Vec2::Zero();
    for (std::size_t i = 0; i < ways.size(); ++i) {
        const Vec2 share = inverse * pull[i];
        slope += share * ways[i].dot(outward);
        sum += share;
        squares += share.cwiseAbs2();
    }
    const Vec2 noise = sigma * (squares + sum.cwiseAbs2()).cwiseSqrt();  // the centre's own is in all heights
    return {(outward - slope.x() * along - slope.y() * Vec3::UnitZ()).normalized(), noise.x(), noise.y()};
}

/// Triangles in turn: t x up is outward on a counter-clockwise row.
Direction mean_normal(const Cross& c, double sigma) {
    const Vec3 at = raised(c.row.at, c.z);
    const Vec3 after = raised(c.row.after, c.z) - at, before = raised(c.row.before, c.z) - at;
    Vec3 sum = Vec3::Zero();
    if (c.above) {
        const Vec3 up = *c.above - at;
        sum += after.cross(up).normalized() + up.cross(before).normalized();
    }
    if (c.below) {
        const Vec3 down = *c.below - at;
        sum += before.cross(down).normalized() + down.cross(after).normalized();
    }
    const double across = c.one_sided() ? single_slope_noise(c.up() + c.down()) : chord_slope_noise(c.down(), c.up());
    return {sum.normalized(), sigma * chord_slope_noise(c.row.back(), c.row.ahead()), sigma * across};
}

Contact contact_of(const Vec3& centre, const Direction& direction, double sigma, double r) {
    Contact contact;
    contact.normal = direction.normal;
    contact.position_mm = centre - r * direction.normal;
    contact.lean_rad = std::asin(std::clamp(direction.normal.z(), -1.0, 1.0));
    const double turned = coverage * std::hypot(direction.along, direction.across);
    contact.u95_mm = coverage * sigma + lean_error(r, turned).normal_mm;
    return contact;
}

core::Status check(std::span<const CentreRow> rows, std::size_t row, double r, bool by_neighbours) {
    const auto refuse = [](const char* why) { return core::fail(ErrorCode::fit_not_evaluable, why); };
    if (row >= rows.size() || !(r > 0.0) || !std::isfinite(r)) return refuse("contacts: no such row, or no ball");
    if (by_neighbours && rows.size() < 2) return refuse("contacts: no other section tells the lean");
    for (std::size_t k = 0; k < rows.size(); ++k) {
        if (rows[k].centres.size() < fewest_centres) return refuse("contacts: a row has fewer than 8 centres");
        if (k > 0 && !(rows[k].z_mm > rows[k - 1].z_mm)) return refuse("contacts: the rows do not ascend");
    }
    return {};
}

/// `parts`: by whose points the normals go, one for each centre; neighbours are those of the centres.
template <class Normal>
Contacts by_neighbours(std::span<const CentreRow> rows, std::span<const CentreRow> parts, std::size_t row, double r,
                       Normal&& normal) {
    const CentreRow& own = rows[row];
    const RowPoints centres(own.centres);
    const auto beside = [&](std::size_t k, const Vec2& p, const Vec2& outward) -> std::optional<Vec3> {
        if (k >= rows.size()) return std::nullopt;
        const auto place = RowPoints(rows[k].centres).facing(p, outward);
        if (!place) return std::nullopt;
        return raised(place->on(parts[k].centres), parts[k].z_mm);
    };
    std::vector<Contact> contacts;
    for (std::size_t i = 0; i < own.centres.size(); ++i) {
        const std::span<const Vec2> part = parts[row].centres;
        Cross cross;
        cross.z = own.z_mm;
        cross.row = {part[centres.before(i, apart_radii * r)], part[i], part[centres.after(i, apart_radii * r)]};
        cross.outward = centres.triple(i, apart_radii * r).normal();
        cross.below = beside(row - 1, own.centres[i], cross.outward);  // of row 0: beyond all
        cross.above = beside(row + 1, own.centres[i], cross.outward);
        if (!cross.below && !cross.above)
            return core::fail(ErrorCode::fit_not_evaluable,
                              "contacts: the next section has no place that faces as this one");
        const Direction direction = normal(cross, own.sigma_mm);
        contacts.push_back(contact_of(raised(own.centres[i], own.z_mm), direction, own.sigma_mm, r));
        if (cross.one_sided()) contacts.back().bound_mm = lean_error(r, contacts.back().lean_rad).in_plane_mm;
    }
    return contacts;
}

}  // namespace

Contacts contacts_by_three_points(std::span<const CentreRow> rows, std::size_t row, double ball_radius_mm) {
    if (auto status = check(rows, row, ball_radius_mm, false); !status) return tl::unexpected(status.error());
    const CentreRow& own = rows[row];
    const RowPoints points(own.centres);
    std::vector<Contact> contacts;
    for (std::size_t i = 0; i < own.centres.size(); ++i) {
        const Triple triple = points.triple(i, apart_radii * ball_radius_mm);
        const Direction direction{raised(triple.normal(), 0.0),
                                  own.sigma_mm * circle_slope_noise(triple.back(), triple.ahead()), 0.0};
        contacts.push_back(contact_of(raised(triple.at, own.z_mm), direction, own.sigma_mm, ball_radius_mm));
    }
    return contacts;
}

Contacts contacts_by_micro_plane(std::span<const CentreRow> rows, std::size_t row, double ball_radius_mm) {
    if (auto status = check(rows, row, ball_radius_mm, true); !status) return tl::unexpected(status.error());
    return by_neighbours(rows, rows, row, ball_radius_mm, plane_normal);
}

Contacts contacts_by_mean_vector(std::span<const CentreRow> rows, std::size_t row, double ball_radius_mm) {
    if (auto status = check(rows, row, ball_radius_mm, true); !status) return tl::unexpected(status.error());
    return by_neighbours(rows, rows, row, ball_radius_mm, mean_normal);
}

Contacts contacts_by_two_passes(std::span<const CentreRow> rows, std::size_t row, double ball_radius_mm) {
    if (auto status = check(rows, row, ball_radius_mm, true); !status) return tl::unexpected(status.error());
    std::vector<std::vector<Vec2>> places(rows.size());
    std::vector<CentreRow> parts(rows.begin(), rows.end());
    for (std::size_t k = row > 0 ? row - 1 : 0; k < std::min(rows.size(), row + 2); ++k) {
        const auto first = contacts_by_three_points(rows, k, ball_radius_mm);
        if (!first) return tl::unexpected(first.error());
        for (const Contact& contact : *first)
            places[k].push_back(contact.position_mm.head<2>());
        parts[k].centres = places[k];
    }
    return by_neighbours(rows, parts, row, ball_radius_mm, mean_normal);
}

Contacts contacts_by_point_distance(std::span<const CentreRow> rows, std::size_t row, double ball_radius_mm,
                                    const NominalNormal& nominal) {
    if (auto status = check(rows, row, ball_radius_mm, false); !status) return tl::unexpected(status.error());
    if (!nominal) return core::fail(ErrorCode::fit_not_evaluable, "contacts: point distance needs a nominal");
    const CentreRow& own = rows[row];
    const RowPoints points(own.centres);
    std::vector<Contact> contacts;
    for (std::size_t i = 0; i < own.centres.size(); ++i) {
        const Direction direction{nominal(own.centres[i], points.triple(i, apart_radii * ball_radius_mm).normal()), 0.0,
                                  0.0};
        contacts.push_back(contact_of(raised(own.centres[i], own.z_mm), direction, own.sigma_mm, ball_radius_mm));
    }
    return contacts;
}

Contacts contacts_by(CompensationMethod method, std::span<const CentreRow> rows, std::size_t row, double ball_radius_mm,
                     const NominalNormal& nominal) {
    switch (method) {
        case CompensationMethod::micro_plane:
            return contacts_by_micro_plane(rows, row, ball_radius_mm);
        case CompensationMethod::mean_vector:
            return contacts_by_mean_vector(rows, row, ball_radius_mm);
        case CompensationMethod::two_pass:
            return contacts_by_two_passes(rows, row, ball_radius_mm);
        case CompensationMethod::three_points:
            return contacts_by_three_points(rows, row, ball_radius_mm);
        case CompensationMethod::point_distance:
            return contacts_by_point_distance(rows, row, ball_radius_mm, nominal);
        case CompensationMethod::surface:
        case CompensationMethod::flat:
            break;
    }
    return core::fail(ErrorCode::fit_not_evaluable, "contacts: this method does not go point by point");
}

}  // namespace cmm::fitting
