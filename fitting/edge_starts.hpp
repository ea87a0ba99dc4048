// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "fitting/edge_shapes.hpp"
#include "fitting/model_fitter.hpp"

namespace cmm::fitting {

/// Where the fits of an edge's models begin, from circles through a window of its points (Kasa 1976). None where there
/// is no such circle, or the ball does not fit into it.
std::optional<ArcShape> arc_start(const ModelFitter& fitter, const EdgeWindow& window);

/// Vertex, direction and radius of the circle: where conics begin.
std::optional<ParabolaShape> vertex_start(const ModelFitter& fitter, const EdgeWindow& window);

/// An ellipse that is a circle as yet, with that vertex.
std::optional<EllipseShape> round_start(const ModelFitter& fitter, const EdgeWindow& window);

/// The best of three places where a circle may meet another.
std::optional<DoubleArcShape> two_arcs_start(const ModelFitter& fitter, const EdgeWindow& window);

}  // namespace cmm::fitting
