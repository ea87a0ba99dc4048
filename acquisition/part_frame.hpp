// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <optional>
#include <string>

#include "acquisition/section_setup.hpp"
#include "core/error.hpp"
#include "core/frame.hpp"
#include "fitting/six_points.hpp"

/// The frame of a part that was found on the machine, as the run file keeps it and as its sections see it.
namespace cmm::acquisition {

using PartFrame = fitting::SixPointFrame;

/// Names and numbers for the run file; what is read back is the same to the last bit.
std::map<std::string, double> frame_numbers(const PartFrame& frame);
/// Nothing where there are none: the machine's frame is the part's. Errors: journal_corrupt (a number is missing, or
/// they are no rigid motion).
core::Result<std::optional<PartFrame>> frame_from_numbers(const std::map<std::string, double>& numbers);

/// The same frame, with what machine, probe and temperature do to its touches.
PartFrame with_errors(PartFrame frame, const fitting::SystematicErrors& errors);

core::PartFromMachine part_from_machine(const std::optional<PartFrame>& frame);

/// Lets a section know where the part stands and how well that is known; one that is aligned by nothing else is in the
/// frame of the six points from now on. Of the frame's uncertainty a section feels shift and turn in its plane, at its
/// height; that of the height moves a wall by the tangent of its lean: numbers have it by each of their places
/// (fitting/plane_error.hpp), deviations by the steepest wall of the section, on top of both shifts.
void take_frame(SectionSetup& setup, const PartFrame& frame);

/// The alignment of a section that six points should have aligned, when nobody touched them.
SectionAlignment without_frame(const AlignmentSpec& spec);

/// For people: "x +0.8000 mm (u 0.00010), ...; turned by 0.5000 deg about (...); residuals ..., condition ..., rounds".
std::string part_frame_words(const PartFrame& frame);

}  // namespace cmm::acquisition
