// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "bench/pictures/pictures.hpp"
#include "core/text.hpp"
#include "core/units.hpp"
#include "fitting/section.hpp"
#include "support/families.hpp"

namespace cmm::pictures {
namespace {

using core::um_from_mm;

struct Found {
    std::vector<Vector2d> good, bad, missed, lost;  // along the scan in mm, residual in um
};

Found sorted_out(const fitting::families::BladeScan& scan, const fitting::SectionFit& fit) {
    const auto s = lengths(scan.points);
    Found out;
    for (std::size_t i = 0; i < scan.points.size(); ++i) {
        const Vector2d at(s[i], um_from_mm(fit.verdicts[i].residual_mm));
        const bool is_bad = scan.bad[i] != 0.0, rejected = fit.verdicts[i].reason != fitting::RejectReason::none;
        (is_bad ? (rejected ? out.bad : out.missed) : (rejected ? out.lost : out.good)).push_back(at);
    }
    return out;
}

}  // namespace

std::string bad_points() {
    const auto blade = fitting::families::make(fitting::families::Family::compressor, 3);
    fitting::families::ScanOptions options;
    options.bad_share = 0.03;
    options.bad_high_mm = 0.15;
    options.seed = 4;
    const auto scan = fitting::families::scan(blade, options);
    const auto fit = fitting::fit_section(scan.points, {}, {});
    if (!fit) return {};
    const auto found = sorted_out(scan, *fit);
    svg::Picture picture(width_px, 440, "residuals of a scan with bad points");
    const double length = lengths(scan.points).back();
    const auto draw = [&](double top, double height, double shown_um, const char* x_title) {
        const auto frame = frame_at(top, height, {0.0, -shown_um}, {length, shown_um});
        frame.draw_axes(picture, x_title, "off in \u00b5m", 10, 6);
        picture.clip(frame.corner(), frame.size());
        picture.path("dot", svg::dots(frame.px(found.good)));
        picture.path("reject", svg::crosses(frame.px(found.bad), 3.0));
        for (const auto* wrong : {&found.missed, &found.lost})
            for (const auto& at : *wrong)
                picture.circle("arc", frame.px(at), 6.0);
        picture.unclip();
    };
    picture.text("strong", {left_px, 16}, svg::Anchor::start,
                 std::to_string(found.good.size()) + " good points kept, " + std::to_string(found.lost.size()) +
                     " lost; " + std::to_string(found.bad.size()) + " bad points found (crosses), " +
                     std::to_string(found.missed.size()) + " missed (wrong: ringed)");
    draw(26, 220, 170.0, "");
    draw(276, 120, 6.0, "way of the ball centre in mm");
    return picture.finish();
}

}  // namespace cmm::pictures
