// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/error.hpp"
#include "fitting/stray_rows.hpp"
#include "fitting/surface.hpp"
#include "fitting/surface_rows.hpp"

namespace cmm::fitting {

struct SurfaceFitOptions {
    /// How far the surface reaches beyond the first and the last row.
    double beyond_mm = 0.0;
    /// Turning that a span of u holds at most.
    double span_turn_rad = 0.06;
    /// Through all rows, instead of smoothed across them without those that lie apart: for rows that are results
    /// themselves, whose differences are the part's.
    bool through_rows = false;
};

/// What a surface has of its rows' own errors, by span of u (docs/theory.md, section 12).
struct RowScatter {
    std::vector<double> standard_mm;            ///< of the rows about the surface, along its normal
    std::vector<std::size_t> weight;            ///< which of `leverage` it may well be
    std::vector<std::vector<double>> leverage;  ///< by row: its share in the surface there
};

struct SurfaceFit {
    Surface surface;
    /// Effective number of parameters along v, by span of u: chosen from the noise in the rows.
    std::vector<double> freedom_v;
    /// Standard deviation of the rows about the surface along its normal: what the neighbours took from them.
    double row_sigma_mm = 0.0;
    RowScatter scatter;
    /// There the surface follows the others alone.
    std::vector<Stray> strays;
    /// Places of u where its curvature may jump, ascending.
    std::vector<double> joints;
};

/// Whether rows can make a surface together. Errors: fit_not_evaluable (rows that are not in order or at the same
/// height, rows that cross: a neighbour's noses are farther away than the row is long).
core::Status check_rows(std::span<const SurfaceRow> rows);

/// The surface through rows of different counts and spacing (seed 001, B1-B14, layered): the rows' smooth curves are
/// aligned by LE and TE, sampled at common places that follow the turning of a usual row (B4-B10), smoothed across
/// the rows column by column with a strength that generalised cross-validation takes from the scatter along the normal
/// (or `through_rows`), and interpolated along u. Rows ascend in z; S_z(u, v) = v. Errors: those of check_rows,
/// fit_not_evaluable (fewer than 2 rows).
core::Result<SurfaceFit> fit_surface(std::span<const SurfaceRow> rows, const SurfaceFitOptions& options = {});

}  // namespace cmm::fitting
