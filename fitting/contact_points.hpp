// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "core/error.hpp"
#include "fitting/compensation.hpp"
#include "fitting/compensation_method.hpp"
#include "fitting/nominal_normal.hpp"

/// The classic ways to take the ball off, point by point (named in JIA, 1.2, without formulas; docs/compensation.md has
/// ours and their errors): contact = centre - r N, N found from the neighbouring centres as they were measured. For
/// comparison with what is used elsewhere; the product's own way is SurfaceCompensation. Pure functions, millimetres,
/// part frame.
namespace cmm::fitting {

/// The ball centres of a section that count, counter-clockwise, closed: SectionFit::centres.points.
struct CentreRow {
    double z_mm = 0.0;
    std::span<const Vec2> centres;
    double sigma_mm = 0.0;  ///< standard deviation of a centre along the normal
};

/// Where a ball touched, by its own centre and its neighbours'.
struct Contact : ContactPoint {
    /// Along the normal, expanded (k = 2), from the noise of the centres: that of its own, and r (1 - cos d) for an
    /// error d of the normal. The method's own error is not in it.
    double u95_mm = 0.0;
    /// Only one row beside it told the lean, and not how the surface bends: largest error by that, of the 2-D offset.
    double bound_mm = 0.0;
};

/// Contacts of all centres of `rows[row]`, in their order; `rows` ascend in z. Neighbours in the row are the next ones
/// at least r/5 away (nearer ones tell the noise, not the normal); those above and below are the nearest places of the
/// next rows' polygons that face the same way. Errors of all: fit_not_evaluable (fewer than 8 centres; of those that
/// need neighbours: no other row, one that has no place that faces the same way).

/// Three points on a circle: the normal in the section's plane of the circle through a centre and its neighbours. Exact
/// on upright cylinders; where the surface leans by a it is off by r (1/cos a - 1) in the plane, like the 2-D offset.
core::Result<std::vector<Contact>> contacts_by_three_points(std::span<const CentreRow> rows, std::size_t row,
                                                            double ball_radius_mm);
/// Micro-plane: the plane through a centre that is nearest to its neighbours in the row, above and below, by least
/// squares with weights 1/distance^2. Off where
/// these lie unevenly on a curved surface, by kappa h / 2 (h: spacing) in the normal at the first and last row.
core::Result<std::vector<Contact>> contacts_by_micro_plane(std::span<const CentreRow> rows, std::size_t row,
                                                           double ball_radius_mm);
/// Mean vector: mean of the unit normals of the triangles that a centre makes with its neighbours. Errors as above.
core::Result<std::vector<Contact>> contacts_by_mean_vector(std::span<const CentreRow> rows, std::size_t row,
                                                           double ball_radius_mm);
/// Two passes: a first one gives an approximate part, by three points on a circle; the second goes along the normals of
/// that part, by the mean vector of its points (neighbours are those of the centres). Of a scan both passes see the
/// same centres, since a ball that rests on the part rests there from whichever side it came.
core::Result<std::vector<Contact>> contacts_by_two_passes(std::span<const CentreRow> rows, std::size_t row,
                                                          double ball_radius_mm);
/// Point distance: |centre - nominal| - r is the deviation along the nominal's normal. Exact for a part that is
/// parallel to its nominal; off by r (1 - cos d) where its normal differs by d.
core::Result<std::vector<Contact>> contacts_by_point_distance(std::span<const CentreRow> rows, std::size_t row,
                                                              double ball_radius_mm, const NominalNormal& nominal);

/// The same by name. `nominal` is for point_distance alone. Errors: those of the method; fit_not_evaluable (not point
/// by point, point_distance without a nominal).
core::Result<std::vector<Contact>> contacts_by(CompensationMethod method, std::span<const CentreRow> rows,
                                               std::size_t row, double ball_radius_mm,
                                               const NominalNormal& nominal = {});

}  // namespace cmm::fitting
