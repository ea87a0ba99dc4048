// SPDX-License-Identifier: Apache-2.0
#include "acquisition/run_results.hpp"

#include "acquisition/recorded_sections.hpp"

#include "tests/acquisition/session_fixture.hpp"
#include "tests/acquisition/temp_folder.hpp"

namespace cmm::acquisition {
namespace {

struct RunResultsTest : ::testing::Test {
    SessionPart job;
    TempFolder folder;
    std::string file = folder.path("run.cmmrun");
    std::uint64_t next = 1;

    std::unique_ptr<Journal> create() const { return std::move(Journal::create(file, session_header(job)).value()); }
    /// Points first ... last of a section as a path of the run.
    void scan(Journal& journal, std::uint16_t path, std::size_t section, std::size_t first, std::size_t last,
              bool finish) {
        ASSERT_TRUE(journal.begin_path({path, section, static_cast<std::uint32_t>(first), false}));
        auto planned = job.plan.paths[section];
        planned.points = {planned.points.begin() + static_cast<std::ptrdiff_t>(first),
                          planned.points.begin() + static_cast<std::ptrdiff_t>(last)};
        const auto samples = samples_of(planned, path, next);
        ASSERT_TRUE(journal.append(samples));
        next += samples.size();
        if (finish) {
            ASSERT_TRUE(journal.finish_path(path));
        }
    }
    std::size_t count(std::size_t section) const { return job.plan.paths[section].points.size(); }
};

TEST_F(RunResultsTest, SectionsAreGatheredOverTheirPaths) {
    const auto journal = create();
    scan(*journal, 1, 0, 0, 30, false);
    auto touch = sample_at(next++, 2, {1.0, 2.0, 3.0});
    touch.flags = core::sample_flag::touch;
    ASSERT_TRUE(journal->append(std::vector{touch}));
    scan(*journal, 2, 0, 30, count(0), true);
    scan(*journal, 3, 1, 0, 12, false);

    const auto sections = recorded_sections(*journal);
    ASSERT_TRUE(sections) << sections.error().text();
    ASSERT_EQ(sections->size(), 2U);
    EXPECT_EQ((*sections)[0].points.size(), count(0));  // without the touch
    EXPECT_TRUE((*sections)[0].finished);
    EXPECT_EQ((*sections)[0].last_path, 2);
    for (std::size_t i = 0; i < count(0); ++i) {
        EXPECT_NEAR(((*sections)[0].points[i].centre_mm - job.plan.paths[0].points[i].centre_mm).norm(), 0.0,
                    test_lsb_mm);
    }
    EXPECT_EQ((*sections)[1].points.size(), 12U);
    EXPECT_FALSE((*sections)[1].finished);
    EXPECT_EQ((*sections)[1].last_path, 3);
}

TEST_F(RunResultsTest, ASampleOfAPathThatWasNeverBegunIsCorrupt) {
    const auto journal = create();
    scan(*journal, 1, 0, 0, 10, false);
    ASSERT_TRUE(journal->append(std::vector{sample_at(next, 9, {1.0, 2.0, 3.0})}));
    const auto sections = recorded_sections(*journal);
    ASSERT_FALSE(sections);
    EXPECT_EQ(sections.error().code, core::ErrorCode::journal_corrupt);
    EXPECT_TRUE(holds(sections.error().message, "sample 11")) << sections.error().message;
    EXPECT_TRUE(holds(sections.error().message, "path 9")) << sections.error().message;
}

TEST_F(RunResultsTest, AFinishedRunIsJudgedByItsOwnPartFile) {
    {
        const auto journal = create();
        scan(*journal, 1, 0, 0, count(0), true);
        scan(*journal, 2, 1, 0, count(1), true);
        ASSERT_TRUE(journal->flush());
    }
    const auto result = results_of_run(file, nullptr);
    ASSERT_TRUE(result) << result.error().text();
    EXPECT_EQ(result->part_name, "blade");
    EXPECT_EQ(result->part_serial, "7");
    EXPECT_EQ(result->run_id, "run-1");
    EXPECT_TRUE(result->complete);
    EXPECT_TRUE(result->has_nominal);
    EXPECT_EQ(result->verdict(), Decision::accept);
    ASSERT_EQ(result->sections.size(), 2U);
    EXPECT_EQ(result->sections[1].z_mm, 40.0);

    // Another part file with a limit that nothing can hold.
    auto strict = job.part;
    strict.gate.profile_mm = 1e-6;
    const auto refused = results_of_run(file, &strict);
    ASSERT_TRUE(refused) << refused.error().text();
    EXPECT_NE(refused->verdict(), Decision::accept);
    ASSERT_EQ(refused->sections.size(), 2U);
    // The same points give the same contour to the last bit.
    const auto& a = result->sections[0].fit->contour;
    const auto& b = refused->sections[0].fit->contour;
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t i = 0; i < a.size(); ++i)
        EXPECT_EQ(a[i].position_mm, b[i].position_mm);
}

TEST_F(RunResultsTest, ABrokenRunIsNotComplete) {
    {
        const auto journal = create();
        scan(*journal, 1, 0, 0, count(0), true);
        scan(*journal, 2, 1, 0, 20, false);
        ASSERT_TRUE(journal->flush());
    }
    const auto result = results_of_run(file, nullptr);
    ASSERT_TRUE(result) << result.error().text();
    EXPECT_FALSE(result->complete);
    EXPECT_NE(result->verdict(), Decision::accept);
    ASSERT_EQ(result->sections.size(), 2U);
    EXPECT_TRUE(result->sections[0].has_contour());
    EXPECT_FALSE(result->sections[1].has_contour());
    EXPECT_EQ(result->sections[1].points.size(), 20U);
}

TEST_F(RunResultsTest, ARunFileThatIsNotThereIsSaidSo) {
    EXPECT_FALSE(results_of_run(file, nullptr));
}

struct PointsTest : RunResultsTest {
    std::vector<PointSection> points(double lift_mm) const {
        std::vector<PointSection> sections;
        for (const auto& path : job.plan.paths) {
            PointSection section;
            section.name = "s" + std::to_string(sections.size());
            for (const auto& point : path.points)
                section.points_mm.emplace_back(point.centre_mm + Eigen::Vector3d(0.0, 0.0, lift_mm));
            sections.push_back(std::move(section));
        }
        return sections;
    }
};

TEST_F(PointsTest, PointsNearAPlannedHeightAreAtThatHeight) {
    const auto near = results_of_points(points(0.015), 1.0, &job.part);
    ASSERT_TRUE(near) << near.error().text();
    EXPECT_EQ(near->sections.at(0).z_mm, 20.0);
    EXPECT_EQ(near->sections.at(1).z_mm, 40.0);
    EXPECT_EQ(near->sections.at(0).name, "s0");
    EXPECT_EQ(near->verdict(), Decision::accept);
    const auto between = results_of_points(points(0.5), 1.0, &job.part);
    ASSERT_TRUE(between) << between.error().text();
    EXPECT_NEAR(between->sections.at(0).z_mm, 20.5, 1e-9);
}

TEST_F(PointsTest, ASectionLiesInOnePlane) {
    auto sections = points(0.0);
    sections[1].points_mm[5].z() += 30.0;
    EXPECT_TRUE(results_of_points(sections, 1.0, nullptr)->sections.at(1).has_contour()) << "one point off";
    for (std::size_t k = 0; k < sections[1].points_mm.size(); ++k)
        sections[1].points_mm[k].z() = 38.0 + 0.01 * static_cast<double>(k % 400);
    const auto result = results_of_points(sections, 1.0, nullptr);
    ASSERT_TRUE(result) << result.error().text();
    EXPECT_TRUE(result->sections.at(0).has_contour());
    EXPECT_FALSE(result->sections.at(1).has_contour());
    EXPECT_EQ(result->sections.at(1).decision(), Decision::undecided);
    EXPECT_NE(result->sections.at(1).why.find("its points lie between z 38.000 and "), std::string::npos)
        << result->sections.at(1).why;
}

TEST_F(PointsTest, WithoutAPartFileThePointsAreMeasuredOnly) {
    auto sections = points(0.0);
    for (auto& section : sections) {
        section.flags.assign(section.points_mm.size(), 0);
        section.flags[7] = core::sample_flag::no_contact;
    }
    const auto result = results_of_points(sections, 1.0, nullptr);
    ASSERT_TRUE(result) << result.error().text();
    EXPECT_FALSE(result->has_nominal);
    ASSERT_EQ(result->sections.size(), 2U);
    for (const auto& section : result->sections) {
        EXPECT_TRUE(section.has_contour()) << section.why;
        EXPECT_EQ(section.decision(), Decision::reported);
        EXPECT_EQ(section.points[7].verdict.reason, fitting::RejectReason::no_contact);
    }
    EXPECT_EQ(result->sections[1].points[0].sequence, count(0) + 1);
}

/// A part of steel at 50 degrees, drawn at 20: 0.35 mm on a metre. Upright, so that the height does not matter.
TEST_F(PointsTest, AnExpansionIsCorrectedOrCountedInFull) {
    const auto text = upright_part_text() + "[[characteristic]]\nname = \"axial_chord\"\n";
    const SessionPart upright(text);
    constexpr double growth = 30.0 * 11.5e-6;
    const auto measured = [&](double factor) {
        std::vector<PointSection> sections(2);
        for (std::size_t i = 0; i < 2; ++i) {
            for (const auto& point : upright.plan.paths[i].points) {
                // The ball does not grow.
                const Eigen::Vector3d ball = 1.0 * point.normal;
                Eigen::Vector3d centre = factor * (point.centre_mm - ball) + ball;
                centre.z() = point.centre_mm.z();
                sections[i].points_mm.push_back(centre);
            }
        }
        return sections;
    };
    const auto judged = [&](double factor, const std::string& correction) {
        const auto part = parse_part_file(text + "[uncertainty]\npart_temperature_c = 50\nexpansion_um_m_k = 11.5\n" +
                                              "expansion_correction = \"" + correction + "\"\n",
                                          "warm.toml");
        EXPECT_TRUE(part) << part.error().text();
        return results_of_points(measured(factor), 1.0, &*part).value();
    };
    const auto drawn = judged(1.0, "by_machine"), as_measured = judged(1.0 + growth, "none"),
               corrected = judged(1.0 + growth, "applied");
    for (std::size_t i = 0; i < 2; ++i) {
        for (const char* name : {"chord", "axial_chord", "max_thickness", "profile_suction", "profile_le"}) {
            const auto &before = *drawn.sections[i].find(name), &after = *corrected.sections[i].find(name),
                       &raw = *as_measured.sections[i].find(name);
            EXPECT_NEAR(*after.value, *before.value, 0.2e-3) << name;
            EXPECT_NEAR(*after.u95, *before.u95, 0.2e-3) << name;
            EXPECT_LT(std::abs(*raw.value - *before.value), *raw.u95) << name;
        }
        const auto &chord = *as_measured.sections[i].find("axial_chord"),
                   &plain = *drawn.sections[i].find("axial_chord");
        EXPECT_NEAR(*chord.value - *plain.value, growth * *plain.value, 0.2e-3);
        EXPECT_NEAR(*chord.u95 - *plain.u95, growth * *plain.value, 0.2e-3);
    }
}

TEST_F(PointsTest, AHeightOutsideTheNominalIsRefused) {
    const auto result = results_of_points(points(30.0), 1.0, &job.part);
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().code, core::ErrorCode::plan_invalid);
}

}  // namespace
}  // namespace cmm::acquisition
