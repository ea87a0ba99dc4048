// SPDX-License-Identifier: Apache-2.0
// Blades of which not everything was measured, as STEP surfaces: what was not measured has no face.
#include "acquisition/part_body.hpp"

#include <gtest/gtest.h>

#include <BRepBndLib.hxx>
#include <BRepBuilderAPI_MakeVertex.hxx>
#include <BRepCheck_Analyzer.hxx>
#include <BRepExtrema_DistShapeShape.hxx>
#include <Bnd_Box.hxx>
#include <STEPControl_Reader.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS_Shape.hxx>
#include <algorithm>
#include <filesystem>

#include "acquisition/part_rows.hpp"
#include "acquisition/points_file.hpp"
#include "acquisition/run_results.hpp"
#include "core/text.hpp"
#include "fitting/point_deviation.hpp"
#include "fitting/surface_fit.hpp"
#include "tests/acquisition/gapped_part.hpp"
#include "tests/acquisition/temp_folder.hpp"
#include "tests/acquisition/test_blade.hpp"

namespace cmm::acquisition {
namespace {

std::string four_sections() {
    std::string text = leaning_text("profile_mm = 0.2\n");
    const std::string three = "[20, 25, 30]";
    return text.replace(text.find(three), three.size(), "[20, 25, 30, 35]");
}

bool everywhere(const RecordedPoint&, const Eigen::Vector2d&) {
    return true;
}

class PartBodies : public testing::Test {
  protected:
    TempFolder folder_;
    std::string file_ = folder_.path("blade.step");

    TopoDS_Shape surface_of(const PartResult& part) {
        const auto written = export_step(part, PartBody::surface, file_);
        EXPECT_TRUE(written) << written.error().text();
        STEPControl_Reader reader;
        EXPECT_EQ(reader.ReadFile(file_.c_str()), IFSelect_RetDone);
        reader.TransferRoots();
        EXPECT_TRUE(BRepCheck_Analyzer(reader.OneShape()).IsValid());
        EXPECT_FALSE(TopExp_Explorer(reader.OneShape(), TopAbs_SOLID).More());
        return reader.OneShape();
    }
};

double distance_mm(const TopoDS_Shape& shape, const Eigen::Vector2d& at, double z_mm) {
    const TopoDS_Shape vertex = BRepBuilderAPI_MakeVertex(gp_Pnt(at.x(), at.y(), z_mm)).Shape();
    return BRepExtrema_DistShapeShape(vertex, shape).Value();
}

TEST_F(PartBodies, AGapOfASectionIsAHole) {
    for (const Missing& missing : {Missing(on_suction_side), Missing(round_the_te)}) {
        const auto part = judged_part_without(missing, four_sections(), {1});
        const SectionResult& section = part.sections[1];
        ASSERT_EQ(section.gaps().size(), 1U) << section.why;
        const auto shape = surface_of(part);
        const ContourGap gap = section.gaps()[0];
        const auto& contour = section.fit->contour;
        const std::size_t n = contour.size(), in_gap = (gap.behind + n - gap.before) % n;
        const auto at = [&](std::size_t k) { return contour[(gap.before + k) % n].position_mm; };
        double nearest_mm = 5.0;  // to the sections beside it
        for (const auto& point : contour)
            if (point.measured) nearest_mm = std::min(nearest_mm, (point.position_mm - at(in_gap / 2)).norm());
        EXPECT_GT(nearest_mm, 2.0);
        EXPECT_GT(distance_mm(shape, at(in_gap / 2), section.z_mm), 0.95 * nearest_mm);
        // It ends at the section above, which has all of its own.
        const auto& above = part.sections[2].fit->contour;
        for (std::size_t k = 0; k < above.size(); k += above.size() / 40)
            EXPECT_LT(distance_mm(shape, above[k].position_mm, part.sections[2].z_mm), 2e-3) << k;
        for (std::size_t k = in_gap; k < n; k += n / 40)
            EXPECT_LT(distance_mm(shape, at(k), section.z_mm), 2e-3) << k;
    }
}

TEST_F(PartBodies, NothingStandsWhereASectionIsMissing) {
    const auto part = judged_part_without(everywhere, four_sections(), {1});
    ASSERT_FALSE(part.sections[1].has_contour());
    Bnd_Box box;
    BRepBndLib::AddOptimal(surface_of(part), box, false, false);
    EXPECT_NEAR(box.CornerMin().Z(), 30.0, 1e-3);
    EXPECT_NEAR(box.CornerMax().Z(), 35.0, 1e-3);
    const auto three = export_step(part, PartBody::surface, file_);
    ASSERT_TRUE(three) << three.error().text();
    ASSERT_EQ(three->passed_over.size(), 1U);
    EXPECT_EQ(three->passed_over[0]->index, 1U);
    const auto none = export_step(judged_part_without(everywhere, four_sections(), {1, 3}), PartBody::surface, file_);
    ASSERT_FALSE(none);
    EXPECT_NE(none.error().message.find("nothing of the surface was measured"), std::string::npos);
}

TEST_F(PartBodies, ASolidTakesTheSectionsWithoutGaps) {
    const auto one_lacks = judged_part_without(on_suction_side, four_sections(), {1});
    const auto solid = export_step(one_lacks, PartBody::solid, file_);
    ASSERT_TRUE(solid) << solid.error().text();
    ASSERT_EQ(solid->passed_over.size(), 1U);
    EXPECT_EQ(solid->passed_over[0]->index, 1U);
    EXPECT_NE(core::read_file(file_)->find("'passes over 1 of 4 sections, which were not measured all round; "),
              std::string::npos);
    const auto surface = export_step(one_lacks, PartBody::surface, file_);
    ASSERT_TRUE(surface) << surface.error().text();
    EXPECT_TRUE(surface->passed_over.empty());
    EXPECT_EQ(core::read_file(file_)->find("passes over"), std::string::npos);
    const auto most_lack = export_step(judged_part_without(on_suction_side, four_sections(), {0, 1, 3}),
                                       PartBody::solid, folder_.path("solid.step"));
    ASSERT_FALSE(most_lack);
    EXPECT_NE(most_lack.error().message.find("measured all round"), std::string::npos) << most_lack.error().text();
}

/// Sections 10 to 15 mm apart, with the form of a real part, which the ones beside do not have: the body keeps it.
TEST_F(PartBodies, GoThroughTheSectionsOfARealBlade) {
    std::vector<std::string> files;
    for (const char* height : {"300.0", "315.0", "330.0", "345.0", "360.0", "370.0"})
        files.push_back(real_data(std::string("engine-blade/section_z") + height + ".csv"));
    if (!std::filesystem::exists(files[0])) GTEST_SKIP() << "../shared/data/engine-blade is absent";
    const auto part = results_of_points(read_points(files).value(), 0.0, nullptr);
    ASSERT_TRUE(part) << part.error().text();
    for (const PartBody body : {PartBody::solid, PartBody::surface}) {
        const auto written = export_step(*part, body, file_);
        ASSERT_TRUE(written) << written.error().text();
        EXPECT_LT(written->off_max_mm, 0.3e-3);
    }
}

/// By Open CASCADE, from the file.
TEST_F(PartBodies, SaysHowFarTheMeasuredContoursAreFromIt) {
    std::string text = four_sections();
    text.replace(text.find("pitch_mm = 0.5"), 14, "pitch_mm = 0.8");
    const auto part = judged_part_without(everywhere, text, {});
    const auto written = export_step(part, PartBody::surface, file_);
    ASSERT_TRUE(written) << written.error().text();
    EXPECT_GT(written->off_max_mm, 1e-6);
    const auto shape = surface_of(part);
    const auto off_mm = [&](const SectionResult& section, std::size_t k) {
        const double off = distance_mm(shape, section.fit->contour[k].position_mm, section.z_mm);
        EXPECT_LE(off, written->off_max_mm + 1e-6) << section.name << ", point " << k;
        return off;
    };
    std::vector<const SectionResult*> sections;
    std::vector<fitting::Vec3> points;
    for (const auto& section : part.sections) {
        sections.push_back(&section);
        for (const auto& point : section.fit->contour)
            points.emplace_back(point.position_mm.x(), point.position_mm.y(), section.z_mm);
        for (std::size_t k = 0; k < section.fit->contour.size(); k += 16)
            off_mm(section, k);
    }
    // All of them by another search than the program's.
    const auto rows = part_rows(sections);
    ASSERT_TRUE(rows) << rows.error().text();
    const auto fit = fitting::fit_surface(*rows, {.through_rows = true});
    ASSERT_TRUE(fit) << fit.error().text();
    EXPECT_NEAR(fitting::deviation_of(fit->surface, points).rms_mm, written->off_rms_mm, 1e-9);
    // Every fourth, then all near the farthest of those: the distance has a sharp peak.
    std::vector<double> off;
    const SectionResult& farthest = *written->farthest;
    for (std::size_t k = 0; k < farthest.fit->contour.size(); k += 4)
        off.push_back(off_mm(farthest, k));
    const auto at = 4 * static_cast<std::size_t>(std::max_element(off.begin(), off.end()) - off.begin());
    double most = 0.0;
    for (std::size_t k = std::max<std::size_t>(at, 4) - 4; k < std::min(at + 4, farthest.fit->contour.size()); ++k)
        most = std::max(most, off_mm(farthest, k));
    EXPECT_NEAR(most, written->off_max_mm, 1e-6);
}

}  // namespace
}  // namespace cmm::acquisition
