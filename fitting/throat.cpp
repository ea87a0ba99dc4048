// SPDX-License-Identifier: Apache-2.0
#include "fitting/throat.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

namespace cmm::fitting {
namespace {

constexpr std::size_t looked_at = 300;  // places of the neighbour for the first look
constexpr int most_narrowings = 60;
constexpr double settled_mm = 1e-10;
constexpr double least_throat_mm = 1e-3;  // less is no passage

/// The shortest way from the blade to a place of its neighbour.
struct Passage {
    ContourPlace here, there;  // of the blade, and of the neighbour before it was moved
    double width_mm, growth;   // of the width: on the way along the neighbour
    double outwards;           // cosine of the way to the blade's normal
};

class Cascade {
  public:
    Cascade(const ContourGeometry& contour, const Vec2& pitch_mm)
        : contour_(contour), pitch_mm_(pitch_mm), places_(std::min(looked_at, contour.size())) {
        for (std::size_t k = 0; k < places_; ++k)
            seen_.push_back(passage_at(index_of(k)));
    }

    /// Whether the neighbour reaches into the blade: there may be a smallest distance all the same, behind the place
    /// where it comes out again.
    bool cross() const {
        return std::any_of(seen_.begin(), seen_.end(), [](const Passage& p) { return p.outwards < 0.0; });
    }

    /// The narrowest of all. A width changes no faster than the place of the neighbour moves, so most of the places
    /// that are narrower than both beside them need no second look.
    Passage narrowest() const {
        std::vector<std::size_t> order(places_);
        for (std::size_t k = 0; k < places_; ++k)
            order[k] = k;
        std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return width(a) < width(b); });
        std::optional<Passage> best;
        for (const std::size_t k : order) {
            if (width(k) > width(k + places_ - 1) || width(k) > width(k + 1)) continue;
            if (best && width(k) - reach_mm(k) > best->width_mm) continue;
            const Passage found = narrowest_at(k);
            if (!best || found.width_mm < best->width_mm) best = found;
        }
        return *best;
    }

  private:
    double width(std::size_t k) const { return seen_[k % places_].width_mm; }
    double index_of(std::size_t k) const {
        return static_cast<double>(k) * static_cast<double>(contour_.size()) / static_cast<double>(places_);
    }

    /// How far the neighbour goes to the farther one of the places beside the k-th.
    double reach_mm(std::size_t k) const {
        const auto way = [&](std::size_t a, std::size_t b) {
            const double round = contour_.perimeter();
            return std::abs(
                std::remainder(contour_.arc(seen_[b % places_].there) - contour_.arc(seen_[a % places_].there), round));
        };
        return std::max(way(k + places_ - 1, k), way(k, k + 1));
    }

    /// Of the place of the neighbour `index`, with its share of the way to the next point.
    Passage passage_at(double index) const {
        const double whole = std::floor(index);
        const ContourPlace there{static_cast<std::size_t>(whole) % contour_.size(), index - whole};
        const Vec2 place = contour_.position(there) + pitch_mm_;
        const ContourPlace nearest{contour_.nearest_point(place), 0.0};
        const ContourPlace here =
            contour_.foot(place, {nearest.index + contour_.size() / 2, contour_.size()}, &nearest);
        const Vec2 across = place - contour_.position(here);
        const double width_mm = across.norm();
        const Vec2 along = across / std::max(width_mm, least_throat_mm);
        return {here, there, width_mm, along.dot(left_of(contour_.normal(there))), along.dot(contour_.normal(here))};
    }

    /// Between the places beside the k-th, which are no narrower.
    Passage narrowest_at(std::size_t k) const {
        Passage best = seen_[k];
        const bool before = best.growth > 0.0;
        double low = index_of(before ? k + places_ - 1 : k), high = index_of(before ? k + places_ : k + 1);
        double falls = seen_[before ? (k + places_ - 1) % places_ : k].growth;
        double rises = seen_[before ? k : (k + 1) % places_].growth;
        for (int step = 0; step < most_narrowings && std::abs(best.growth) * reach_mm(k) > settled_mm; ++step) {
            // Half way from time to time: the false position alone may creep. So where an end's slope has no sense.
            const bool halve = step % 3 == 2 || falls >= 0.0 || rises <= 0.0;
            const double at = halve ? 0.5 * (low + high) : low + (high - low) * falls / (falls - rises);
            const Passage passage = passage_at(at);
            if (passage.width_mm <= best.width_mm) best = passage;
            (passage.growth > 0.0 ? high : low) = at;
            (passage.growth > 0.0 ? rises : falls) = passage.growth;
        }
        return best;
    }

    const ContourGeometry& contour_;
    Vec2 pitch_mm_;
    std::size_t places_;
    std::vector<Passage> seen_;
};

}  // namespace

core::Result<Measure> measure_throat(MeasuredSection& section, const Vec2& pitch_mm) {
    const ContourGeometry& contour = section.contour();
    const auto refuse = [](const char* why) {
        return core::fail(core::ErrorCode::fit_not_evaluable, std::string("throat: ") + why);
    };
    const Cascade cascade(contour, pitch_mm);
    if (cascade.cross()) return refuse("the neighbours cross");
    const Passage passage = cascade.narrowest();
    // Where the blades touch or cross, the way from one to the other leads through material.
    if (passage.width_mm < least_throat_mm || passage.outwards < 0.5) return refuse("the neighbours touch");
    Measure out{"THROAT: smallest distance to the same section moved by the nominal pitch", passage.width_mm, {}, {}};
    contour.add(passage.here, -1.0, out.slopes);
    contour.add(passage.there, -1.0, out.slopes);
    return out;
}

}  // namespace cmm::fitting
