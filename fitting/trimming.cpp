// SPDX-License-Identifier: Apache-2.0
#include "fitting/trimming.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "fitting/closed_curve.hpp"
#include "fitting/crossings.hpp"

namespace cmm::fitting {
namespace {

constexpr double nearer_mm = 1e-9;      // a point that much nearer than the distance is in a loop
constexpr double same_place_mm = 1e-7;  // crossings of more than two branches
constexpr std::size_t most_tests = 3;
constexpr double tangential_rad = 1e-6;

struct Station {
    std::size_t stretch = 0;
    double x = 0.0;
    double along = 0.0;  // share of the stretch that lies before
    std::size_t crossing = 0;
    std::size_t partner = 0;
    bool may_end = true, may_begin = true;  // a valid branch, by the side to which the other one crosses
};

/// Whether a branch that is wholly valid or wholly not is valid.
bool is_far_enough(const ParallelCurve& curve, const ClosedCurve& source, const Branch& branch) {
    const std::size_t tests = std::min(most_tests, branch.size());
    for (std::size_t k = 1; k <= tests; ++k) {
        const StretchPart& part = branch[branch.size() * k / (tests + 1)];
        const Vec2 p = curve.at(curve.stretches()[part.stretch], 0.5 * (part.from + part.to)).position;
        if (std::abs(source.closest(p).distance_mm) < std::abs(curve.distance()) - nearer_mm) return false;
    }
    return tests > 0;
}

class Trimming {
  public:
    Trimming(const ParallelCurve& curve, const std::vector<Crossing>& crossings)
        : curve_(curve), all_(curve.stretches()), source_(curve.source()) {
        for (std::size_t i = 0; i < crossings.size(); ++i) {
            const Crossing& c = crossings[i];
            add_station(c.first, c.first_x, i);
            add_station(c.second, c.second_x, i);
        }
        std::sort(stations_.begin(), stations_.end(), [](const Station& a, const Station& b) {
            return a.stretch != b.stretch ? a.stretch < b.stretch : a.along < b.along;
        });
        std::vector<std::size_t> seen(crossings.size(), stations_.size());
        for (std::size_t i = 0; i < stations_.size(); ++i) {
            std::size_t& other = seen[stations_[i].crossing];
            if (other < stations_.size()) {
                stations_[i].partner = other;
                stations_[other].partner = i;
                set_sides(stations_[other], stations_[i]);
            }
            other = i;
        }
        for (std::size_t i = 0; i < stations_.size(); ++i) {
            branches_.push_back(branch_after(i));
            const bool may_be = stations_[i].may_begin && stations_[(i + 1) % stations_.size()].may_end;
            valid_.push_back(may_be && is_valid(branches_.back()) ? 1 : 0);
        }
    }

    std::vector<TrimmedLoop> loops() {
        std::vector<TrimmedLoop> loops;
        for (std::size_t first = 0; first < branches_.size(); ++first) {
            TrimmedLoop loop;
            std::optional<std::size_t> at = first;
            while (at && valid_[*at]) {
                valid_[*at] = 0;
                loop.branches.push_back(branches_[*at]);
                at = follower((*at + 1) % stations_.size(), first);
                if (at == first) {
                    loops.push_back(std::move(loop));
                    break;
                }
            }
        }
        return loops;
    }

  private:
    void add_station(std::size_t stretch, double x, std::size_t crossing) {
        const Stretch& s = all_[stretch];
        stations_.push_back({stretch, x, (x - s.from) / (s.to - s.from), crossing, 0});
    }

    /// The valid side of the curve is the left one inwards, the right one outwards: its boundary comes along the one
    /// branch and leaves along the other that turns to that side.
    void set_sides(Station& a, Station& b) const {
        const auto normal = [&](const Station& s) { return curve_.at(all_[s.stretch], s.x).normal; };
        const double turn = -curve_.distance() * cross(normal(a), normal(b));
        if (std::abs(turn) < tangential_rad * std::abs(curve_.distance())) return;
        a.may_end = b.may_begin = turn > 0.0;
        b.may_end = a.may_begin = turn < 0.0;
    }

    /// What lies between a station and the next, round the start of the curve if need be.
    Branch branch_after(std::size_t i) const {
        const Station& begin = stations_[i];
        const Station& end = stations_[(i + 1) % stations_.size()];
        Branch branch;
        if (i + 1 < stations_.size() && begin.stretch == end.stretch) return {{begin.stretch, begin.x, end.x}};
        branch.push_back({begin.stretch, begin.x, all_[begin.stretch].to});
        for (std::size_t k = (begin.stretch + 1) % all_.size(); k != end.stretch; k = (k + 1) % all_.size())
            branch.push_back({k, all_[k].from, all_[k].to});
        branch.push_back({end.stretch, all_[end.stretch].from, end.x});
        return branch;
    }

    bool is_valid(const Branch& branch) const {
        const bool backwards = std::any_of(branch.begin(), branch.end(),
                                           [&](const StretchPart& part) { return all_[part.stretch].backwards; });
        return !backwards && is_far_enough(curve_, source_, branch);
    }

    /// The branch that goes on from the end of another: the one that crosses there, or where several cross in one
    /// place the next in order.
    std::optional<std::size_t> follower(std::size_t end, std::size_t first) const {
        const auto may_follow = [&](std::size_t i) { return valid_[i] || i == first; };
        if (may_follow(stations_[end].partner)) return stations_[end].partner;
        const Vec2 here = place(end);
        for (std::size_t k = 0; k < stations_.size(); ++k) {
            const std::size_t i = (end + k) % stations_.size();
            if (may_follow(i) && (place(i) - here).norm() < same_place_mm) return i;
        }
        return {};
    }

    Vec2 place(std::size_t i) const { return curve_.at(all_[stations_[i].stretch], stations_[i].x).position; }

    const ParallelCurve& curve_;
    const std::vector<Stretch>& all_;
    ClosedCurve source_;
    std::vector<Station> stations_;
    std::vector<Branch> branches_;  // from station i to the next
    std::vector<char> valid_;       // and not yet in a loop
};

/// Of the polygon through the parts' ends and middles.
double area_of(const ParallelCurve& curve, const TrimmedLoop& loop) {
    double twice = 0.0;
    std::optional<Vec2> origin;
    Vec2 last = Vec2::Zero();
    for (const Branch& branch : loop.branches)
        for (const StretchPart& part : branch)
            for (const double share : {0.0, 0.5, 1.0}) {
                const double x = part.from + share * (part.to - part.from);
                const Vec2 p = curve.at(curve.stretches()[part.stretch], x).position;
                if (!origin) origin = p;
                twice += cross(last - *origin, p - *origin);
                last = p;
            }
    return 0.5 * twice;
}

}  // namespace

TrimmedLoop largest_loop(const ParallelCurve& curve) {
    const auto crossings = curve.distance() != 0.0 ? find_crossings(curve) : std::vector<Crossing>();
    TrimmedLoop largest;
    if (crossings.empty()) {
        Branch whole;
        for (std::size_t i = 0; i < curve.stretches().size(); ++i) {
            const Stretch& s = curve.stretches()[i];
            if (!s.backwards) whole.push_back({i, s.from, s.to});
        }
        // Without a crossing a curve that is regular is simple and valid; otherwise what runs backwards is a loop below
        // rounding, or nothing is far enough away.
        if (curve.regular() || is_far_enough(curve, ClosedCurve(curve.source()), whole))
            largest = {{std::move(whole)}, true};
        return largest;
    }
    double largest_area = 0.0;
    for (TrimmedLoop& loop : Trimming(curve, crossings).loops()) {
        const double area = area_of(curve, loop);
        if (area <= largest_area) continue;
        largest_area = area;
        largest = std::move(loop);
    }
    return largest;
}

}  // namespace cmm::fitting
