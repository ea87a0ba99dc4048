// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/error.hpp"
#include "fitting/contact_points.hpp"
#include "fitting/section.hpp"

namespace cmm::fitting {

/// Contacts slid along their tangent planes, the steepest way, into the plane z: that of their centres c, where they
/// become c - r n / |n|^2 (n the normal's part in the plane). The surface's bend over r sin(lean) is neglected.
std::vector<Vec2> slid_into_plane(std::span<const Contact> contacts, double z_mm);

/// A section whose contour goes through contacts that were found point by point.
struct ContactSection {
    SectionFit fit;
    std::size_t set_aside = 0;  ///< contacts that disagree with their neighbours or lie out of order (thin edges)
};

/// The contour of contacts of one section, slid into its plane: a section of a ball of radius 0 (bad points, smooth
/// curve, edges, zones, sizes as fit_section finds them). Its uncertainty is that of the contacts' scatter about it,
/// with their bounds. `flat`: the same section as fit_section made it, whose verdicts and ball centres are kept;
/// `options` as then; `leans`: the contacts' normals know the lean. Errors: those of fit_section.
core::Result<ContactSection> section_of_contacts(std::span<const Contact> contacts, double z_mm, bool leans,
                                                 const SectionFit& flat, const SectionOptions& options);

}  // namespace cmm::fitting
