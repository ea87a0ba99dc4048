// SPDX-License-Identifier: Apache-2.0
#include "fitting/lifted_runs.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "fitting/circle_frame.hpp"
#include "fitting/orthogonal_polynomials.hpp"
#include "fitting/statistics.hpp"

namespace cmm::fitting {
namespace {

constexpr auto longest_run = static_cast<std::ptrdiff_t>(longest_bad_run);
constexpr std::ptrdiff_t farthest_flank = 24;  // points passed over to fill a flank
constexpr std::ptrdiff_t most_flank = 12, usual_flank = 6, shortest_flank = 4;
constexpr std::size_t most_flank_degree = 6, short_flank_degree = 3;
constexpr std::size_t fewest_numbers = 3;       // of a polynomial with a lift
constexpr double least_contrast = 7.0;          // in sigmas: of the four-neighbour test at the run's ends
constexpr double least_single_contrast = 12.0;  // a point is among the neighbours of those next to it
constexpr double gain_of_bad_run = 18.0;        // of the criterion: a probability of 8 000 to one
constexpr double gain_of_two = 25.0;            // likewise, where one of some fifty runs beside it is left out
constexpr double least_lift = 5.0;              // in standard deviations, its own and a point's
constexpr double same_without = 0.5;            // of the lift, when the points next to the run are not heard
constexpr double nearly_as_much = 0.8;          // of the contrast of a candidate: looked at with it
constexpr double as_much_as_any = 0.6;          // of the largest contrast beside it
constexpr std::ptrdiff_t to_next_run = 4;       // points from one run to another

using RunValues = Eigen::Array<double, longest_run, 1>;

struct LiftedRun {
    std::ptrdiff_t first = 0, length = 0;
    double contrast = 0.0;  ///< at its ends, when it was looked for
    double gain = 0.0, sd_mm = 0.0;
    RunValues off_mm = RunValues::Zero();  ///< each of its points
};

/// Points to one side of a run that are not heard: so many next to it, and those of another run by their distances.
struct LeftOut {
    std::ptrdiff_t next = 0, from = 0, to = 0;
    bool has(std::ptrdiff_t distance) const { return distance < next || (distance >= from && distance < to); }
};

struct Flanks {
    std::ptrdiff_t points;  ///< a side
    std::size_t most_degree;
    LeftOut before{}, after{};
};

/// A run among good points to either side of it, in the frame of these.
class RunAmongOthers {
  public:
    RunAmongOthers(ChainState& chain, const LiftedRun& run, const Flanks& flanks)
        : flanks_(flanks), side_(flanks.points), length_(run.length) {
        std::array<Vec2, most_flank> before, after;
        const std::ptrdiff_t low = collect(chain, run.first - 1, -1, flanks.before, before);
        const std::ptrdiff_t high = collect(chain, run.first + run.length, 1, flanks.after, after);
        if (low == ChainState::none || high == ChainState::none || high - low >= chain.size()) return;
        for (const std::ptrdiff_t by : {-longest_run, std::ptrdiff_t{0}, longest_run})
            if (chain.exists(run.first + by)) sigma_ = std::max(sigma_, chain.sigma_at(run.first + by));
        const auto last = static_cast<std::size_t>(side_ - 1);
        const CircleFrame frame(before[last], before[0], after[last]);
        x_.resize(2 * side_ + length_);
        y_.resize(x_.size());
        for (std::ptrdiff_t k = 0; k < side_; ++k) {
            place(frame, side_ - 1 - k, before[static_cast<std::size_t>(k)]);
            place(frame, side_ + length_ + k, after[static_cast<std::size_t>(k)]);
        }
        for (std::ptrdiff_t k = 0; k < length_; ++k)
            place(frame, side_ + k, chain.point(run.first + k));
        price_ = std::log(static_cast<double>(x_.size()));
        if (!far_) compare(flanks.most_degree);
    }

    /// Of the run off the others, where a polynomial through these leaves residuals like noise; otherwise 0.
    double lift_mm() const { return lift_; }
    /// Of the lift and of a point: the larger.
    double sd_mm() const { return sd_; }
    /// Of each point of the run off that polynomial.
    const RunValues& off_mm() const { return off_; }
    /// Of the criterion, against the best curve without a lift.
    double gain() const { return lift_ != 0.0 ? plain_ - lifted_ : 0.0; }
    /// No lift explains so much better than the best curve without one.
    bool is_plain() const { return plain_ <= gain_of_bad_run + price(fewest_numbers); }

    /// The best curve without a lift may also be one whose curvature jumps near the run.
    void allow_jumps() {
        for (std::ptrdiff_t gap = side_ - 2; gap < side_ + length_ + 2; ++gap)
            for (const double share : {0.0, 0.5})
                allow_jump(x_[gap] + share * (x_[gap + 1] - x_[gap]));
    }

  private:
    static constexpr int most_points = 2 * most_flank + longest_run;
    using Terms = OrthogonalPolynomials<most_points, most_flank_degree>;
    using Values = Terms::Values;

    /// The last point of the flank; none where there are not enough.
    std::ptrdiff_t collect(ChainState& chain, std::ptrdiff_t from, std::ptrdiff_t step, const LeftOut& left_out,
                           std::array<Vec2, most_flank>& points) const {
        std::ptrdiff_t count = 0;
        for (std::ptrdiff_t at = from; std::abs(at - from) < farthest_flank && chain.exists(at); at += step) {
            if (chain.state(at) == PointState::bad || left_out.has(std::abs(at - from))) continue;
            points[static_cast<std::size_t>(count++)] = chain.point(at);
            if (count == side_) return at;
        }
        return ChainState::none;
    }

    void place(const CircleFrame& frame, std::ptrdiff_t k, const Vec2& p) {
        const Vec2 q = frame.local(p);
        far_ = far_ || frame.is_far(q.x());
        x_[k] = q.x();
        y_[k] = q.y();
    }

    /// Polynomials without the lift, and the simplest one that holds with it.
    void compare(std::size_t most_degree) {
        const double variance = sigma_ * sigma_;
        Values run = Values::Zero(x_.size());  // what no polynomial has of the lift
        run.segment(side_, length_) = 1.0;
        terms_.begin(x_);
        do {
            const std::size_t degree = terms_.degree();
            take_off(degree, y_);
            take_off(degree, run);
            left_[degree] = y_;
            const double squares = y_.square().sum();
            squares_[degree] = squares;
            if (degree == 0) continue;
            plain_ = std::min(plain_, squares / variance + price(degree + 1));
            if (!flanks_.before.has(0) && !flanks_.after.has(0) && is_plain()) return;
            const double unexplained = run.square().sum(), along = (run * y_).sum();
            if (lift_ != 0.0 || unexplained < least_unexplained) continue;
            const double with = squares - along * along / unexplained;
            if (with > variance * chi_square_limit_999(static_cast<std::size_t>(x_.size()) - degree - 2)) continue;
            lifted_ = with / variance + price(degree + 2);
            lift_ = along / unexplained;
            sd_ = sigma_ * std::max(1.0, 1.0 / std::sqrt(unexplained));
            off_.head(length_) = y_.segment(side_, length_) + lift_ * (1.0 - run.segment(side_, length_));
        } while (terms_.degree() < most_degree && terms_.raise());
    }

    void allow_jump(double at) {
        Values jump = (x_ - at).max(0.0).square();
        for (std::size_t degree = 0; degree <= terms_.degree(); ++degree) {
            take_off(degree, jump);
            const double unexplained = jump.square().sum(), along = (jump * left_[degree]).sum();
            if (degree == 0 || !(unexplained > 0.0)) continue;
            plain_ = std::min(plain_,
                              (squares_[degree] - along * along / unexplained) / (sigma_ * sigma_) + price(degree + 3));
        }
    }

    double price(std::size_t numbers) const { return static_cast<double>(numbers) * price_; }
    void take_off(std::size_t degree, Values& from) const {
        const Values& term = terms_.values_of(degree);
        from -= (term * from).sum() / terms_.norm_of(degree) * term;
    }

    static constexpr double least_unexplained = 1e-6;

    Flanks flanks_;
    std::ptrdiff_t side_, length_;
    bool far_ = false;
    double sigma_ = 0.0, plain_ = HUGE_VAL, lifted_ = HUGE_VAL, lift_ = 0.0, sd_ = 0.0;
    double price_ = 0.0;  // of a number, by the criterion
    Values x_, y_;
    Terms terms_;
    std::array<Values, most_flank_degree + 1> left_;  // by the polynomials up to each degree, of y
    std::array<double, most_flank_degree + 1> squares_{};
    RunValues off_ = RunValues::Zero();
};

class LiftedRuns {
  public:
    explicit LiftedRuns(ChainState& chain)
        : chain_(chain),
          steps_(static_cast<std::size_t>(chain.size()), 0.0),
          contrasts_(static_cast<std::size_t>(chain.size())),
          fails_(static_cast<std::size_t>(chain.size())) {
        take_steps(0, chain.size() - 1);
        take_contrasts(0, chain.size() - 1);
    }

    /// Those that show most go first, and what they leave is looked at anew.
    bool convict() {
        for (std::ptrdiff_t first = 0; first < chain_.size(); ++first)
            for (std::ptrdiff_t length = 1; length <= longest_run; ++length)
                if (const double contrast = of(contrasts_, first, length); contrast > 0.0)
                    open_.push_back({first, length, contrast});
        std::sort(open_.begin(), open_.end(), [](const Candidate& a, const Candidate& b) {
            if (a.contrast != b.contrast) return a.contrast > b.contrast;
            return a.first != b.first ? a.first < b.first : a.length < b.length;
        });
        for (const Candidate& candidate : open_)
            for (std::ptrdiff_t runs = 0; runs < longest_run && convict_beside(candidate);)
                ++runs;
        bool any = false;
        for (const LiftedRun& run : bad_)
            any = stays_bad(run) || any;
        return any;
    }

  private:
    struct Candidate {
        std::ptrdiff_t first, length;
        double contrast;
    };
    enum class Finding { bad, plain, unclear };
    /// By the point that a run begins with, and by its length less one.
    template <class Value>
    using ByRun = std::vector<std::array<Value, longest_run>>;

    /// Of the runs beside a candidate that show nearly as much as it does now, the surest, if it is bad. None while
    /// others beside it show far more.
    bool convict_beside(const Candidate& candidate) {
        const double contrast = of(contrasts_, candidate.first, candidate.length);
        if (!(contrast > 0.0) || of(fails_, candidate.first, candidate.length) != 0) return false;
        std::ptrdiff_t low = candidate.first - to_next_run, high = candidate.first + candidate.length;
        if (!chain_.closed()) {
            low = std::max<std::ptrdiff_t>(low, 0);
            high = std::min(high, chain_.size() - 1);
        }
        for (std::ptrdiff_t first = low; first <= high; ++first)
            for (const double beside : contrasts_[index(first)])
                if (contrast < as_much_as_any * beside) return false;
        LiftedRun surest{0, 0, 0.0, gain_of_bad_run};
        for (std::ptrdiff_t first = low; first <= high; ++first)
            for (std::ptrdiff_t length = 1; length <= longest_run; ++length) {
                if (of(contrasts_, first, length) < nearly_as_much * contrast) continue;
                char& known = of(fails_, first, length);
                if (known != 0) continue;
                const LiftedRun run = look_at({first, length, of(contrasts_, first, length)});
                known = run.gain > gain_of_bad_run ? 0 : 1;
                if (run.gain > surest.gain) surest = run;
            }
        if (surest.length == 0) return false;
        set(surest, PointState::bad);
        bad_.push_back(surest);
        forget(surest.first - farthest_flank, surest.first + surest.length + farthest_flank);
        return true;
    }

    /// What was known of runs that begin there.
    void forget(std::ptrdiff_t low, std::ptrdiff_t high) {
        take_steps(low, high);
        take_contrasts(low - longest_run, high);
        for (std::ptrdiff_t first = low; first <= high; ++first)
            fails_[index(first)].fill(0);
    }

    /// Good ones that lay between bad ones come back when these are not heard any more.
    bool stays_bad(const LiftedRun& run) {
        set(run, PointState::good);
        const LiftedRun now = look_at({run.first, run.length, run.contrast});
        if (now.gain <= gain_of_bad_run) return false;
        set(now, PointState::bad);
        return true;
    }

    void set(const LiftedRun& run, PointState state) {
        for (std::ptrdiff_t k = 0; k < run.length; ++k)
            chain_.note(run.first + k, state, {run.off_mm[k], run.sd_mm, true, true, false});
        const std::ptrdiff_t by = 3 * chain_.stride(run.first);
        chain_.test(run.first - by, run.first + run.length + by);
    }

    /// From each point to the next one, of the residuals of the four-neighbour test, in sigmas.
    void take_steps(std::ptrdiff_t low, std::ptrdiff_t high) {
        double before = 0.0;
        for (std::ptrdiff_t i = low - 1; i <= high; ++i) {
            if (!chain_.exists(i)) continue;
            const double off = std::copysign(chain_.ratio(i), chain_.residual(i)) / chain_.sigma_at(i);
            if (i >= low && chain_.exists(i - 1)) steps_[index(i)] = off - before;
            before = off;
        }
    }

    /// Of the runs that begin from low to high. A lift shows at the ends of the run: the points on either side of each
    /// end are off their neighbours' cubic in opposite senses. In sigmas; 0 where it is not enough, or not all are
    /// good.
    void take_contrasts(std::ptrdiff_t low, std::ptrdiff_t high) {
        for (std::ptrdiff_t first = low; first <= high; ++first) {
            if (!chain_.exists(first) || !chain_.exists(first - 1)) continue;
            auto& contrasts = contrasts_[index(first)];
            contrasts.fill(0.0);
            const double step = steps_[index(first)];
            double least = chain_.stride(first) == 1 ? least_single_contrast : least_contrast;
            for (std::ptrdiff_t after = first + 1; after <= first + longest_run; ++after, least = least_contrast) {
                if (!chain_.exists(after) || chain_.state(after - 1) != PointState::good) break;
                const double contrast = std::abs(step - steps_[index(after)]);
                if (contrast > least) contrasts[static_cast<std::size_t>(after - first - 1)] = contrast;
            }
        }
    }

    std::size_t index(std::ptrdiff_t i) const {
        const std::ptrdiff_t n = chain_.size();
        return static_cast<std::size_t>(i >= 0 && i < n ? i : (i % n + n) % n);
    }
    template <class Value>
    Value& of(ByRun<Value>& values, std::ptrdiff_t first, std::ptrdiff_t length) const {
        return values[index(first)][static_cast<std::size_t>(length - 1)];
    }

    /// With its gain; none where it is not bad. Good points between two bad runs are too few to tell of either alone:
    /// where the points beside a run do not tell, those of another run beyond are left out.
    LiftedRun look_at(LiftedRun run) {
        const std::ptrdiff_t side = usual_side(run);
        Finding found = hear(run, {side, most_flank_degree}, gain_of_bad_run);
        if (found == Finding::unclear)
            found = hear(run, {std::max(shortest_flank, side / 2), short_flank_degree}, gain_of_bad_run);
        if (found != Finding::unclear) return run;
        const LeftOut before = run_beyond(run, -1), after = run_beyond(run, 1);
        if (before.to + after.to > 0) hear(run, {side, most_flank_degree, before, after}, gain_of_two);
        return run;
    }

    /// What such flanks say; `run` has the rest when it is bad.
    Finding hear(LiftedRun& run, const Flanks& flanks, double least_gain) {
        RunAmongOthers among(chain_, run, flanks);
        if (among.is_plain()) return Finding::plain;
        if (std::abs(among.lift_mm()) < least_lift * among.sd_mm() || among.gain() <= least_gain)
            return Finding::unclear;
        among.allow_jumps();
        if (among.gain() <= least_gain || !is_off_without_the_next(run, flanks, among.lift_mm()))
            return Finding::unclear;
        run.gain = among.gain();
        run.sd_mm = among.sd_mm();
        run.off_mm = among.off_mm();
        return Finding::bad;
    }

    std::ptrdiff_t usual_side(const LiftedRun& run) const {
        return std::min(most_flank, usual_flank * chain_.stride(run.first));
    }

    /// Where to one side, beyond some good points, another run shows as much.
    LeftOut run_beyond(const LiftedRun& run, int direction) {
        LeftOut out;
        double most = as_much_as_any * run.contrast;
        for (std::ptrdiff_t apart = 1; apart <= longest_run; ++apart)
            for (std::ptrdiff_t length = 1; length <= longest_run; ++length) {
                const std::ptrdiff_t first =
                    direction > 0 ? run.first + run.length + apart : run.first - apart - length;
                if (!chain_.exists(first) || of(contrasts_, first, length) <= most) continue;
                most = of(contrasts_, first, length);
                out.from = apart;
                out.to = apart + length;
            }
        return out;
    }

    /// Between two bad points good ones look like a run that lies off to the other side.
    bool is_off_without_the_next(const LiftedRun& run, Flanks flanks, double lift_mm) {
        flanks.points = std::max(shortest_flank, usual_side(run) - 1);
        flanks.most_degree = most_flank_degree;
        flanks.before.next = flanks.after.next = 1;
        const RunAmongOthers among(chain_, run, flanks);
        return among.lift_mm() * std::copysign(1.0, lift_mm) >= same_without * std::abs(lift_mm);
    }

    ChainState& chain_;
    std::vector<double> steps_;
    std::vector<Candidate> open_;
    std::vector<LiftedRun> bad_;  // the surest first
    ByRun<double> contrasts_;     // as the states and the steps are now
    ByRun<char> fails_;           // looked at, and not bad, since nothing changed near it
};

}  // namespace

bool convict_lifted_runs(ChainState& chain) {
    return LiftedRuns(chain).convict();
}

}  // namespace cmm::fitting
