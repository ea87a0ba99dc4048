// SPDX-License-Identifier: Apache-2.0
// The program with a STEP file as nominal: points that lie on the body are judged by it.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <numbers>

#include "tests/cad/elliptic_body.hpp"
#include "tests/support/outputs.hpp"
#include "tests/support/process.hpp"

namespace cmm::test {
namespace {

using cad::test::EllipticBody;
using Eigen::Vector2d;

constexpr double ball_mm = 1.0;

/// Ball centres round the body at this height: off the ellipse by the ball's radius, denser at the ends.
void write_ball_centres(const std::string& file, const EllipticBody& body, double z_mm, double outwards_mm) {
    const auto ellipse = body.at(z_mm);
    std::ofstream out(file);
    out.precision(10);
    out << "x,y,z\n";
    for (int k = 0; k < 600; ++k) {
        const double t = 2.0 * std::numbers::pi * k / 600.0;
        const Vector2d place =
            (ellipse.centre_mm + std::cos(t) * ellipse.along_mm + std::sin(t) * ellipse.across_mm).head<2>();
        const Vector2d along = (-std::sin(t) * ellipse.along_mm + std::cos(t) * ellipse.across_mm).head<2>();
        const Vector2d normal = Vector2d(along.y(), -along.x()).normalized();
        const Vector2d centre = place + (ball_mm + outwards_mm) * normal;
        out << centre.x() << ',' << centre.y() << ',' << z_mm << '\n';
    }
}

class StepProgram : public testing::Test {
  protected:
    Finished fit(double outwards_mm) {
        write_step_file(folder_ / "body.step", body_);
        std::ofstream(folder_ / "part.toml")
            << "[part]\nname = \"body\"\n[nominal]\nkind = \"step\"\nfiles = [\"body.step\"]\n[stylus]\nradius_mm = "
            << ball_mm << "\n[scan]\nheights_mm = [30]\n[gate]\nprofile_mm = 0.05\nedge_profile_mm = 0.05\n";
        write_ball_centres(folder_ / "points.csv", body_, 30.0, outwards_mm);
        return run(
            {cmmlive(), "fit", folder_ / "points.csv", "--part", folder_ / "part.toml", "--out", folder_ / "out"});
    }
    double worst_deviation_mm() const {
        double worst = 0.0;
        for (const auto& row : read_csv(folder_ / "out/section-0.csv"))
            worst = std::max(worst, std::abs(std::stod(row.at("deviation_mm"))));
        return worst;
    }

    TemporaryFolder folder_;
    EllipticBody body_;
};

TEST_F(StepProgram, JudgesByTheStepFile) {
    const auto on_it = fit(0.0);
    EXPECT_NE(on_it.out.find("section"), std::string::npos) << on_it.out << on_it.err;
    EXPECT_LT(worst_deviation_mm(), 0.001) << on_it.out;
    // Too thick by 0.1 mm all round: rejected.
    const auto thick = fit(0.1);
    EXPECT_EQ(thick.exit_code, 1) << thick.out << thick.err;
    EXPECT_NEAR(worst_deviation_mm(), 0.1, 0.001);
}

TEST_F(StepProgram, SaysOnStandardErrorAloneWhatIsWrong) {
    std::ofstream(folder_ / "body.step") << "no STEP\n";
    std::ofstream(folder_ / "part.toml")
        << "[part]\nname = \"body\"\n[nominal]\nkind = \"step\"\nfiles = [\"body.step\"]\n"
           "[scan]\nheights_mm = [30]\n";
    const auto plan = run({cmmlive(), "plan", "--part", folder_ / "part.toml"});
    EXPECT_EQ(plan.exit_code, 3);
    EXPECT_EQ(plan.out, "");
    EXPECT_NE(plan.err.find("is not a STEP file"), std::string::npos) << plan.err;
}

}  // namespace
}  // namespace cmm::test
