// SPDX-License-Identifier: Apache-2.0
#include "acquisition/part_frame.hpp"

#include <algorithm>
#include <cmath>

#include "core/text.hpp"
#include "core/units.hpp"

namespace cmm::acquisition {
namespace {

using Eigen::Vector3d;

constexpr std::array<const char*, 6> of_motion{"shift_x", "shift_y", "shift_z", "turn_x", "turn_y", "turn_z"};
constexpr double rigid_to = 1e-9;     // a rotation matrix in a file, to rounding
constexpr double steepest_rad = 1.4;  // about 80 degrees; there is no section of a wall that is flatter

/// Every number under its name: one list for writing and for reading.
template <class Frame, class Visit>
void for_each_frame_number(Frame& frame, const Visit& visit) {
    constexpr std::array<const char*, 3> axes{"x", "y", "z"};
    for (Eigen::Index i = 0; i < 3; ++i) {
        const std::string row = axes.at(static_cast<std::size_t>(i));
        for (Eigen::Index k = 0; k < 3; ++k)
            visit("machine_" + row + "_from_part_" + axes.at(static_cast<std::size_t>(k)),
                  frame.machine_from_part.matrix()(i, k));
        visit("origin_" + row + "_mm", frame.machine_from_part.matrix()(i, 3));
        visit("about_" + row + "_mm", frame.about_mm[i]);
    }
    for (Eigen::Index i = 0; i < 6; ++i)
        for (Eigen::Index k = 0; k < 6; ++k)
            visit(std::string("covariance_") + of_motion.at(static_cast<std::size_t>(i)) + "_" +
                      of_motion.at(static_cast<std::size_t>(k)),
                  frame.covariance(i, k));
    for (std::size_t i = 0; i < frame.residual_mm.size(); ++i)
        visit("residual_" + std::to_string(i + 1) + "_mm", frame.residual_mm[i]);
    visit("moved_mm", frame.moved_mm);
    visit("condition", frame.condition);
    visit("length_mm", frame.length_mm);
    visit("touch_standard_mm", frame.touch_standard_mm);
    visit("rounds", frame.rounds);
}

/// Only middles have one.
std::string excess_name(std::size_t index) {
    return "excess_" + std::to_string(index + 1) + "_mm";
}

template <class Touch, class Visit>
void for_each_touch_number(Touch& touch, const std::string& name, const Visit& visit) {
    constexpr std::array<const char*, 3> axes{"x", "y", "z"};
    for (Eigen::Index k = 0; k < 3; ++k) {
        const std::string axis = axes.at(static_cast<std::size_t>(k));
        visit(name + "_" + axis + "_mm", touch.place_mm[k]);
        visit(name + "_normal_" + axis, touch.normal[k]);
    }
}

/// Of the points that were touched.
std::string point_name(std::size_t index) {
    return "point_" + std::to_string(index + 1);
}
std::string opposite_touch_name(std::size_t index) {
    return "opposite_" + std::to_string(index + 1);
}

/// Shift x and y and the turn about z at a height, from the six numbers of the frame; about the same x and y.
Eigen::Matrix3d covariance_at(const PartFrame& frame, double z_mm) {
    const double rise = z_mm - frame.about_mm.z();
    Eigen::Matrix<double, 3, 6> answer = Eigen::Matrix<double, 3, 6>::Zero();
    answer(0, 0) = answer(1, 1) = answer(2, 5) = 1.0;
    answer(0, 4) = rise;
    answer(1, 3) = -rise;
    return answer * frame.covariance * answer.transpose();
}

double height_variance(const PartFrame& frame, const Eigen::Vector2d& at_mm) {
    const Eigen::Vector2d arm = at_mm - frame.about_mm.head<2>();
    Eigen::Matrix<double, 6, 1> answer;
    answer << 0.0, 0.0, 1.0, arm.y(), -arm.x(), 0.0;
    return answer.dot(frame.covariance * answer);
}

/// Shift z and the turns about x and y.
fitting::PlaneUncertainty plane_uncertainty(const PartFrame& frame) {
    Eigen::Matrix<double, 3, 6> answer = Eigen::Matrix<double, 3, 6>::Zero();
    answer(0, 2) = answer(1, 3) = answer(2, 4) = 1.0;
    return {frame.about_mm.head<2>(), answer * frame.covariance * answer.transpose()};
}

}  // namespace

std::map<std::string, double> frame_numbers(const PartFrame& frame) {
    std::map<std::string, double> numbers;
    for_each_frame_number(
        frame, [&](const std::string& name, const auto& value) { numbers.emplace(name, static_cast<double>(value)); });
    for (std::size_t i = 0; i < frame.excess_mm.size(); ++i)
        if (frame.excess_mm[i]) numbers.emplace(excess_name(i), *frame.excess_mm[i]);
    const auto write = [&](const std::string& name, double value) { numbers.emplace(name, value); };
    for (std::size_t i = 0; frame.points && i < frame.points->size(); ++i) {
        const auto& point = (*frame.points)[i];
        for_each_touch_number(point, point_name(i), write);
        if (point.opposite) for_each_touch_number(*point.opposite, opposite_touch_name(i), write);
    }
    return numbers;
}

core::Result<std::optional<PartFrame>> frame_from_numbers(const std::map<std::string, double>& numbers) {
    if (numbers.empty()) return std::optional<PartFrame>();
    PartFrame frame;
    std::string missing;
    const auto read = [&](const std::string& name, auto& value) {
        const auto found = numbers.find(name);
        if (found == numbers.end() || !std::isfinite(found->second) || std::abs(found->second) > 1e9) {
            if (missing.empty()) missing = name;
        } else {
            value = static_cast<std::remove_reference_t<decltype(value)>>(found->second);
        }
    };
    for_each_frame_number(frame, read);
    for (std::size_t i = 0; i < frame.excess_mm.size(); ++i)
        if (const auto found = numbers.find(excess_name(i)); found != numbers.end()) frame.excess_mm[i] = found->second;
    // Runs of older versions have none.
    if (numbers.contains(point_name(0) + "_x_mm")) frame.points.emplace();
    for (std::size_t i = 0; frame.points && i < frame.points->size(); ++i) {
        auto& point = (*frame.points)[i];
        for_each_touch_number(point, point_name(i), read);
        if (numbers.contains(opposite_touch_name(i) + "_x_mm"))
            for_each_touch_number(point.opposite.emplace(), opposite_touch_name(i), read);
    }
    if (!missing.empty())
        return core::fail(core::ErrorCode::journal_corrupt, "the frame of the part has no number for " + missing);
    const Eigen::Matrix3d turn = frame.machine_from_part.linear();
    if ((turn * turn.transpose() - Eigen::Matrix3d::Identity()).norm() > rigid_to || turn.determinant() < 0.0)
        return core::fail(core::ErrorCode::journal_corrupt, "the frame of the part is no rigid motion");
    return std::optional<PartFrame>(frame);
}

PartFrame with_errors(PartFrame frame, const fitting::SystematicErrors& errors) {
    if (!errors.any() || !frame.points) return frame;
    fitting::ErrorFields fields(errors, 0.0);
    fields.lie_in_frame_of(*frame.points);
    frame.covariance += fitting::ErrorFields::covariance_of_touches(errors, *frame.points);
    frame.shared = fields.covariance_of_frame();
    return frame;
}

core::PartFromMachine part_from_machine(const std::optional<PartFrame>& frame) {
    if (!frame) return {};
    return core::MachineFromPart(frame->machine_from_part).inverse();
}

void take_frame(SectionSetup& setup, const PartFrame& frame) {
    if (setup.alignment.kind == AlignmentKind::none) setup.alignment.kind = AlignmentKind::six_points;
    if (setup.fields.any() && frame.points) setup.fields.lie_in_frame_of(*frame.points);
    SectionAlignment known;
    known.datum.motion.about_mm = frame.about_mm.head<2>();
    known.datum.covariance = known.datum.from_others = covariance_at(frame, setup.z_mm);
    setup.plane = plane_uncertainty(frame);
    known.alignment.state = Alignment::State::final;
    known.alignment.spec = setup.alignment;
    known.alignment.motion = known.datum.motion;
    known.alignment.covariance = known.datum.covariance;
    if (setup.nominal) {
        double height = 0.0;
        for (const auto& point : setup.nominal->reference.points())
            height = std::max(height, height_variance(frame, point));
        const double slope = std::tan(std::min(setup.nominal->lean_rad, steepest_rad));
        known.alignment.covariance(0, 0) += height * slope * slope;
        known.alignment.covariance(1, 1) += height * slope * slope;
    }
    known.alignment.condition = frame.condition;
    known.alignment.rounds = frame.rounds;
    setup.frame = std::move(known);
}

SectionAlignment without_frame(const AlignmentSpec& spec) {
    SectionAlignment out;
    out.alignment.spec = spec;
    out.alignment.state = Alignment::State::refused;
    out.alignment.note = "the six datum points were not touched: where the part stands is not known";
    return out;
}

std::string part_frame_words(const PartFrame& frame) {
    const auto u = frame.standard();
    const Vector3d moved = frame.shift_mm(), turn = frame.turn_rad();
    std::string out = "by six datum points (RPS): ";
    for (std::size_t k = 0; k < 3; ++k)
        out += std::string(k == 0 ? "" : ", ") + "xyz"[k] + " " +
               core::signed_fixed(moved[static_cast<Eigen::Index>(k)], 4) + " mm (u " + core::fixed(u[k], 5) + ")";
    for (std::size_t k = 0; k < 3; ++k)
        out += std::string(", about ") + "xyz"[k] + " " +
               core::signed_fixed(core::deg_from_rad(turn[static_cast<Eigen::Index>(k)]), 5) + " deg (u " +
               core::fixed(core::deg_from_rad(u[3 + k]), 6) + ")";
    out += ", at x " + core::fixed(frame.about_mm.x(), 3) + ", y " + core::fixed(frame.about_mm.y(), 3) + ", z " +
           core::fixed(frame.about_mm.z(), 3) + "; residuals";
    for (std::size_t i = 0; i < frame.residual_mm.size(); ++i)
        out += (i == 0 ? " " : ", ") + core::length_text(frame.residual_mm[i]) +
               (frame.excess_mm[i] ? " (middle of two touches, " + core::signed_fixed(*frame.excess_mm[i], 4) +
                                         " mm farther apart than the nominal)"
                                   : std::string());
    return out + "; condition " + core::fixed(frame.condition, 1) + " (lengths in units of " +
           core::fixed(frame.length_mm, 1) + " mm), " + std::to_string(frame.rounds) + " rounds; u of a touch " +
           core::length_text(frame.touch_standard_mm);
}

}  // namespace cmm::acquisition
