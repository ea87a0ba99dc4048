// SPDX-License-Identifier: Apache-2.0
/// What a section feels of a part frame that is not known exactly.
#include "acquisition/part_frame.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "tests/acquisition/session_fixture.hpp"

namespace cmm::acquisition {
namespace {

/// The blade of the session tests, which tapers, twists and leans, at three heights half a millimetre apart.
class PartFrameTest : public testing::Test {
  protected:
    static std::string text() {
        std::string part = session_part_text("0.4");
        part.replace(part.find("[20, 40]"), 8, "[29.5, 30, 30.5]");
        for (const char* name : {"area", "stagger", "centroid_x", "displacement_y", "twist"})
            part += std::string("[[characteristic]]\nname = \"") + name + "\"\n";
        return part + "[[characteristic]]\nname = \"le_thickness\"\ndistance_mm = 3\n";
    }
    /// As if the nominal lay on the machine; in the frame, where one is given.
    SectionResult judged(std::size_t section, const std::optional<PartFrame>& frame = {}) const {
        auto setup = job.setup(section);
        if (frame) take_frame(setup, *frame);
        std::vector<RecordedPoint> recorded;
        for (const auto& point : job.plan.paths[section].points) {
            recorded.emplace_back().sequence = recorded.size();
            recorded.back().centre_mm = point.centre_mm;
        }
        SectionJudge judge;
        return judge.finish(setup, recorded);
    }
    static PartFrame frame() {
        PartFrame out;
        out.about_mm = {3.0, 2.0, 10.0};
        return out;
    }

    SessionPart job{text()};
};

TEST_F(PartFrameTest, NumbersFeelAWrongHeightAsTheSectionsBesideItSay) {
    constexpr double u_mm = 0.05, apart_mm = 1.0;
    auto high = frame();
    high.covariance(2, 2) = u_mm * u_mm;
    const auto below = judged(0), above = judged(2), plain = judged(1), felt = judged(1, high);
    for (const char* name :
         {"chord", "max_thickness", "le_radius", "te_radius", "area", "stagger", "centroid_x", "le_thickness_3"}) {
        const auto *low = below.find(name), *up = above.find(name), *before = plain.find(name), *now = felt.find(name);
        ASSERT_TRUE(low->value && up->value && before->u95 && now->u95) << name;
        EXPECT_NEAR(*now->value, *before->value, 1e-9) << name;
        // In quadrature with the noise, which is next to nothing here; the error of the 2-D offset is added.
        const double by_height =
            plain.fit->contour_noise.coverage() * u_mm * std::abs(*up->value - *low->value) / apart_mm;
        // A nose counts 1.12 times (docs/theory.md, section 13).
        EXPECT_NEAR(*now->u95 - *before->u95, by_height, 0.15 * by_height + 0.1 * *before->u95) << name;
    }
}

TEST_F(PartFrameTest, ATiltIsAHeightThatGrowsAwayFromItsAxis) {
    // About y: the section's height is wrong by the turn times the distance from x 3.
    constexpr double u_rad = 0.002;
    auto tilted = frame();
    tilted.covariance(4, 4) = u_rad * u_rad;
    const auto plain = judged(1), felt = judged(1, tilted);
    EXPECT_GT(*felt.find("chord")->u95, *plain.find("chord")->u95);
    // 15 mm off the axis at most, on walls that lean by 6 degrees at most.
    EXPECT_LT(*felt.find("chord")->u95, *plain.find("chord")->u95 + 2.0 * 2.0 * u_rad * 15.0 * std::tan(0.1));
}

TEST_F(PartFrameTest, ShiftsInThePlaneAreFeltByPositionsAlone) {
    constexpr double u_mm = 0.01;
    auto shifted = frame();
    shifted.covariance(0, 0) = shifted.covariance(1, 1) = u_mm * u_mm;
    const auto plain = judged(1), felt = judged(1, shifted);
    for (const char* size : {"chord", "max_thickness", "le_radius", "area"})
        EXPECT_NEAR(*felt.find(size)->u95, *plain.find(size)->u95, 1e-4 * *plain.find(size)->u95) << size;
    const double by_shift = plain.fit->contour_noise.coverage() * u_mm;
    for (const char* position : {"centroid_x", "displacement_y"})
        EXPECT_NEAR(*felt.find(position)->u95 - *plain.find(position)->u95, by_shift, 0.1 * by_shift) << position;
}

TEST_F(PartFrameTest, WithoutATouchThereIsNoDeviationButSizesKeepTheirUncertainty) {
    auto setup = job.setup(1);
    setup.alignment.kind = AlignmentKind::six_points;
    std::vector<RecordedPoint> recorded;
    for (const auto& point : job.plan.paths[1].points) {
        recorded.emplace_back().sequence = recorded.size();
        recorded.back().centre_mm = point.centre_mm;
    }
    SectionJudge judge;
    const auto alone = judge.finish(setup, recorded), plain = judged(1);
    EXPECT_EQ(alone.alignment.state, Alignment::State::refused);
    EXPECT_TRUE(alone.deviation_mm.empty());
    ASSERT_GT(plain.fit->contour.front().offset_error_mm, 0.0) << "the blade leans, and the section is alone";
    for (const char* size : {"chord", "max_thickness", "le_radius"}) {
        EXPECT_NEAR(*alone.find(size)->u95, *plain.find(size)->u95, 1e-9) << size;
    }
    EXPECT_NE(alone.find("chord")->note.find("2-D offset error"), std::string::npos) << alone.find("chord")->note;
}

TEST(PartFrame, IsReadBackWithTheTouchesThatMadeIt) {
    PartFrame frame;
    fitting::SixPoints points;
    for (std::size_t i = 0; i < points.size(); ++i)
        points[i].place_mm = {1.0 * static_cast<double>(i), 2.0, 3.0};
    points[1].opposite = fitting::DatumTouch{{1.0, -2.0, 3.0}, -Eigen::Vector3d::UnitX()};
    frame.points = points;
    auto numbers = frame_numbers(frame);
    const auto read = frame_from_numbers(numbers).value().value();
    ASSERT_TRUE(read.points);
    for (std::size_t i = 0; i < points.size(); ++i) {
        EXPECT_EQ((*read.points)[i].place_mm, points[i].place_mm);
        ASSERT_EQ((*read.points)[i].opposite.has_value(), i == 1);
    }
    EXPECT_EQ((*read.points)[1].opposite->place_mm, points[1].opposite->place_mm);
    EXPECT_EQ((*read.points)[1].opposite->normal, points[1].opposite->normal);
    numbers.erase("opposite_2_normal_z");
    EXPECT_FALSE(frame_from_numbers(numbers));
    EXPECT_FALSE(frame_from_numbers(frame_numbers(PartFrame())).value()->points) << "as of an older run";
}

}  // namespace
}  // namespace cmm::acquisition
