// SPDX-License-Identifier: Apache-2.0
#include "acquisition/run_review.hpp"

#include "acquisition/run_results.hpp"
#include "tests/acquisition/session_fixture.hpp"
#include "tests/acquisition/temp_folder.hpp"

namespace cmm::acquisition {
namespace {

/// A run that is still being written.
struct RunReviewTest : ::testing::Test {
    SessionPart job{three_sections()};
    TempFolder folder;
    std::string file = folder.path("run.cmmrun");
    std::unique_ptr<Journal> journal = std::move(Journal::create(file, session_header(job)).value());
    std::uint64_t next = 1;

    static std::string three_sections() {
        std::string text = session_part_text();
        const std::string two = "[20, 40]";
        return text.replace(text.find(two), two.size(), "[20, 30, 40]");
    }
    void begin(std::size_t section) {
        ASSERT_TRUE(journal->begin_path({static_cast<std::uint16_t>(section + 1), section, 0, false}));
    }
    void write(std::size_t section, std::size_t first, std::size_t last) {
        auto planned = job.plan.paths[section];
        planned.points = {planned.points.begin() + static_cast<std::ptrdiff_t>(first),
                          planned.points.begin() + static_cast<std::ptrdiff_t>(last)};
        const auto samples = samples_of(planned, static_cast<std::uint16_t>(section + 1), next);
        next += samples.size();
        ASSERT_TRUE(journal->append(samples));
    }
    void end(std::size_t section) {
        ASSERT_TRUE(journal->finish_path(static_cast<std::uint16_t>(section + 1)));
        ASSERT_TRUE(journal->flush());
    }
    void measure(std::size_t section) {
        begin(section);
        write(section, 0, count(section));
        end(section);
    }
    std::size_t count(std::size_t section) const { return job.plan.paths[section].points.size(); }
};

TEST_F(RunReviewTest, FollowsARunWhileItIsWritten) {
    begin(0);
    write(0, 0, 10);
    ASSERT_TRUE(journal->flush());
    auto review = std::move(RunReview::open(file).value());
    ASSERT_EQ(review->recorded().all().size(), 1U);
    EXPECT_EQ(review->recorded().last_sequence(), 10U);
    EXPECT_FALSE(review->recorded().all()[0].finished);
    EXPECT_FALSE(review->result_at(0).value()->has_contour());

    write(0, 10, count(0));
    end(0);
    begin(1);
    write(1, 0, 5);
    ASSERT_TRUE(journal->flush());
    ASSERT_TRUE(review->refresh());
    ASSERT_EQ(review->recorded().all().size(), 2U);
    EXPECT_TRUE(review->recorded().all()[0].finished);
    EXPECT_EQ(review->recorded().all()[0].points.size(), count(0));
    EXPECT_TRUE(review->result_at(0).value()->has_contour()) << "judged anew";

    // Every point once and in order, as if it had been read at one time.
    const auto whole = recorded_sections(*journal).value();
    for (std::size_t s = 0; s < 2; ++s) {
        const auto& points = review->recorded().all()[s].points;
        ASSERT_EQ(points.size(), whole[s].points.size());
        for (std::size_t i = 0; i < points.size(); ++i)
            EXPECT_EQ(points[i].sequence, whole[s].points[i].sequence);
    }
}

TEST_F(RunReviewTest, AJudgementIsThatOfTheWholeRun) {
    measure(0);
    measure(1);
    auto review = std::move(RunReview::open(file).value());
    const auto last_first = review->result_at(1).value()->fit->contour;
    const auto whole = results_of_run(file, nullptr).value();
    ASSERT_EQ(last_first.size(), whole.sections[1].fit->contour.size());
    for (std::size_t i = 0; i < last_first.size(); ++i)
        EXPECT_EQ(last_first[i].position_mm, whole.sections[1].fit->contour[i].position_mm);
}

TEST_F(RunReviewTest, ASectionThatIsStillMeasuredChangesNothingOfTheOthers) {
    measure(0);
    measure(1);
    auto review = std::move(RunReview::open(file).value());
    const auto* first = review->result_at(0).value();
    const auto* const kept = first;
    const Eigen::Vector2d corner_mm = first->fit->contour[0].position_mm;
    EXPECT_EQ(first->compensation.state, Compensation::State::final);
    begin(2);
    for (const std::size_t from : {0U, 10U, 20U, 30U, 40U}) {
        write(2, from, from + 10);
        ASSERT_TRUE(journal->flush());
        ASSERT_TRUE(review->refresh());
        const auto& open = *review->result_at(2).value();
        EXPECT_EQ(open.has_contour(), from >= 30) << "from 40 points on a part of it can be shown";
        EXPECT_FALSE(open.all_round());
        EXPECT_EQ(review->result_at(0).value(), kept);
        EXPECT_EQ(kept->fit->contour[0].position_mm, corner_mm);
    }
    write(2, 50, count(2));
    end(2);
    ASSERT_TRUE(review->refresh());
    const auto& last = *review->result_at(2).value();
    EXPECT_EQ(last.compensation.state, Compensation::State::final) << last.why << last.compensation.note;
    EXPECT_NE(review->result_at(0).value()->fit->contour[0].position_mm, corner_mm) << "it has a neighbour more";
}

TEST_F(RunReviewTest, AnOperatorsWordIsHeardAndTakenBack) {
    measure(0);
    auto review = std::move(RunReview::open(file).value());
    const auto reason = [&] { return review->result_at(0).value()->points[4].verdict.reason; };
    EXPECT_EQ(reason(), fitting::RejectReason::none);
    OperatorChoice choice;
    choice.reject(5);
    review->choose(choice);
    EXPECT_EQ(reason(), fitting::RejectReason::by_operator);
    EXPECT_TRUE(review->result());
    choice.withdraw(5);
    review->choose(choice);
    EXPECT_EQ(reason(), fitting::RejectReason::none);
    choice.restore(9999);
    review->choose(choice);
    EXPECT_EQ(review->result().error().code, core::ErrorCode::usage);
}

}  // namespace
}  // namespace cmm::acquisition
