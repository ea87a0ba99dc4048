// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "fitting/section.hpp"

namespace cmm::fitting {

/// The uncertainty of the radius of the LE or TE: the noise is that of the edge's own fit, with the section's height;
/// machine, probe, temperature and the 2-D offset add how it answers to them. Where the points chose another form than
/// the arc, but by no more than what the form of the probe may have made of one, the difference to the arc's radius is
/// added. Only of a valid radius.
NumberUncertainty radius_uncertainty(const SectionFit& fit, Zone zone);

}  // namespace cmm::fitting
