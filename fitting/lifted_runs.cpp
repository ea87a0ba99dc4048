// SPDX-License-Identifier: Apache-2.0
#include "fitting/lifted_runs.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "fitting/run_among_others.hpp"

namespace cmm::fitting {
namespace {

constexpr std::ptrdiff_t longest_run = PointRun::longest;
constexpr std::ptrdiff_t usual_flank = 6, shortest_flank = 4;
constexpr std::size_t short_flank_degree = 3;
constexpr double least_contrast = 7.0;          // in sigmas: of the four-neighbour test at the run's ends
constexpr double least_single_contrast = 12.0;  // a point is among the neighbours of those next to it
constexpr double gain_of_two = 25.0;            // of the criterion: one of some fifty runs beside it is left out
constexpr double least_lift = 5.0;              // in standard deviations, its own and a point's
constexpr double same_without = 0.5;            // of the lift, when the points next to the run are not heard
constexpr double nearly_as_much = 0.8;          // of the contrast of a candidate: looked at with it
constexpr double as_much_as_any = 0.6;          // of the largest contrast beside it
constexpr std::ptrdiff_t to_next_run = 4;       // points from one run to another

// Of most runs few points are heard, and vector lanes that are empty cost as much as others.
constexpr int few_lanes = 20, all_lanes = 32;
static_assert(2 * Flanks::most_points + longest_run <= all_lanes);
constexpr double gain_of_bad_run = RunAmongOthers<all_lanes>::gain_of_bad_run;

/// Standard deviations of a point at which a run is known not to be bad; at none, as it is made.
struct Fails {
    double from_mm = HUGE_VAL, to_mm = 0.0;
    bool at(double sigma_mm) const { return sigma_mm >= from_mm && sigma_mm <= to_mm; }
};

struct LiftedRun : PointRun {
    double contrast = 0.0;  ///< at its ends, when it was looked for
    double gain = 0.0, sd_mm = 0.0;
    Values off_mm = Values::Zero();  ///< each of its points
    Fails fails{};                   ///< if it is not bad
};

}  // namespace

class LiftedRuns::Search {
  public:
    explicit Search(ChainState& chain)
        : chain_(chain),
          heard_(static_cast<std::size_t>(chain.size()), PointState::good),
          steps_(heard_.size(), 0.0),
          most_(heard_.size(), 0.0),
          contrasts_(heard_.size()),
          fails_(heard_.size()) {}

    /// Those that show most go first, and what they leave is looked at anew.
    bool convict() {
        begin();
        for (std::ptrdiff_t first = 0; first < chain_.size(); ++first) {
            if (most_[index(first)] == 0.0) continue;
            for (std::ptrdiff_t length = 1; length <= longest_run; ++length)
                if (const double contrast = of(contrasts_, first, length); contrast > 0.0)
                    open_.push_back({first, length, contrast});
        }
        std::sort(open_.begin(), open_.end(), [](const Candidate& a, const Candidate& b) {
            if (a.contrast != b.contrast) return a.contrast > b.contrast;
            return a.first != b.first ? a.first < b.first : a.length < b.length;
        });
        for (const Candidate& candidate : open_)
            for (std::ptrdiff_t runs = 0; runs < longest_run && convict_beside(candidate);)
                ++runs;
        for (std::ptrdiff_t i = 0; i < chain_.size(); ++i)
            heard_[index(i)] = chain_.state(i);
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

    /// What was heard of runs stays known where the points that they were compared with still are what they were.
    void begin() {
        open_.clear();
        bad_.clear();
        take_steps(0, chain_.size() - 1);
        take_contrasts(0, chain_.size() - 1);
        for (std::ptrdiff_t i = 0; i < chain_.size(); ++i)
            if ((chain_.state(i) == PointState::bad) != (heard_[index(i)] == PointState::bad)) forget_near(i, i);
    }

    /// Of the runs beside a candidate that show nearly as much as it does now, the surest, if it is bad. None while
    /// others beside it show far more.
    bool convict_beside(const Candidate& candidate) {
        const double contrast = of(contrasts_, candidate.first, candidate.length);
        if (!(contrast > 0.0) || is_known_to_fail(candidate.first, candidate.length)) return false;
        std::ptrdiff_t low = candidate.first - to_next_run, high = candidate.first + candidate.length;
        if (!chain_.closed()) {
            low = std::max<std::ptrdiff_t>(low, 0);
            high = std::min(high, chain_.size() - 1);
        }
        for (std::ptrdiff_t first = low; first <= high; ++first)
            if (contrast < as_much_as_any * most_[index(first)]) return false;
        LiftedRun surest;
        surest.gain = gain_of_bad_run;
        for (std::ptrdiff_t first = low; first <= high; ++first)
            for (std::ptrdiff_t length = 1; length <= longest_run; ++length) {
                if (of(contrasts_, first, length) < nearly_as_much * contrast) continue;
                if (is_known_to_fail(first, length)) continue;
                const LiftedRun run = look_at({{first, length}, of(contrasts_, first, length)});
                if (run.gain <= gain_of_bad_run) of(fails_, first, length) = run.fails;
                if (run.gain > surest.gain) surest = run;
            }
        if (surest.length == 0) return false;
        set(surest, PointState::bad);
        bad_.push_back(surest);
        const std::ptrdiff_t last = surest.first + surest.length;
        take_steps(surest.first - Flanks::farthest, last + Flanks::farthest);
        take_contrasts(surest.first - Flanks::farthest - longest_run, last + Flanks::farthest);
        forget_near(surest.first, last);
        return true;
    }

    /// What was heard of runs that were compared with one of these points.
    void forget_near(std::ptrdiff_t low, std::ptrdiff_t high) {
        for (std::ptrdiff_t first = low - Flanks::farthest - longest_run; first <= high + Flanks::farthest; ++first)
            if (chain_.exists(first)) fails_[index(first)].fill({});
    }

    bool is_known_to_fail(std::ptrdiff_t first, std::ptrdiff_t length) {
        return of(fails_, first, length).at(sigma_of(first));
    }

    double sigma_of(std::ptrdiff_t first) const { return chain_.largest_sigma(first, longest_run); }

    /// Good ones that lay between bad ones come back when these are not heard any more.
    bool stays_bad(const LiftedRun& run) {
        note(run, PointState::good);
        const LiftedRun now = look_at({run, run.contrast});
        if (now.gain > gain_of_bad_run) {
            note(now, PointState::bad);
            return true;
        }
        set(run, PointState::good);
        return false;
    }

    void note(const LiftedRun& run, PointState state) {
        for (std::ptrdiff_t k = 0; k < run.length; ++k)
            chain_.note(run.first + k, state, {run.off_mm[k], run.sd_mm, true, true, false});
    }

    /// And those around it are tested again.
    void set(const LiftedRun& run, PointState state) {
        note(run, state);
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
            const std::size_t here = index(first);
            auto& contrasts = contrasts_[here];
            contrasts.fill(0.0);
            most_[here] = 0.0;
            const double step = steps_[here];
            if (is_quiet(here)) continue;
            double least = chain_.stride(first) == 1 ? least_single_contrast : least_contrast;
            for (std::ptrdiff_t after = first + 1; after <= first + longest_run; ++after, least = least_contrast) {
                if (!chain_.exists(after) || chain_.state(after - 1) != PointState::good) break;
                const double contrast = std::abs(step - steps_[index(after)]);
                if (contrast <= least) continue;
                contrasts[static_cast<std::size_t>(after - first - 1)] = contrast;
                most_[here] = std::max(most_[here], contrast);
            }
        }
    }

    /// No run that begins there shows enough, as nearly everywhere; told for less work.
    bool is_quiet(std::size_t first) const {
        if (first + longest_run >= steps_.size()) return false;
        double most = 0.0;
        for (std::size_t k = 1; k <= longest_run; ++k)
            most = std::max(most, std::abs(steps_[first] - steps_[first + k]));
        return most <= least_contrast;
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
        Finding found = hear(run, {side, Flanks::highest_degree}, gain_of_bad_run);
        // What is not plain may come out otherwise wherever the scatter changes.
        if (found == Finding::unclear) run.fails = {sigma_of(run.first), sigma_of(run.first)};
        if (found == Finding::unclear)
            found = hear(run, {std::max(shortest_flank, side / 2), short_flank_degree}, gain_of_bad_run);
        if (found != Finding::unclear) return run;
        const LeftOut before = run_beyond(run, -1), after = run_beyond(run, 1);
        if (before.to + after.to > 0) hear(run, {side, Flanks::highest_degree, before, after}, gain_of_two);
        return run;
    }

    /// What such flanks say; `run` has the rest.
    Finding hear(LiftedRun& run, const Flanks& flanks, double least_gain) {
        return need_few_lanes(run, flanks) ? hear_in<few_lanes>(run, flanks, least_gain)
                                           : hear_in<all_lanes>(run, flanks, least_gain);
    }

    static bool need_few_lanes(const LiftedRun& run, const Flanks& flanks) {
        return 2 * flanks.points + run.length <= few_lanes;
    }

    template <int Lanes>
    Finding hear_in(LiftedRun& run, const Flanks& flanks, double least_gain) {
        const double sigma = sigma_of(run.first);
        RunAmongOthers<Lanes> among(chain_, run, flanks, sigma);
        if (among.is_plain()) {
            // Among others that were heard after these it says nothing of other scatters.
            if (!run.fails.at(sigma)) run.fails = {among.plain_sigma_mm(), HUGE_VAL};
            return Finding::plain;
        }
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
        return std::min(Flanks::most_points, usual_flank * chain_.stride(run.first));
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
        flanks.most_degree = Flanks::highest_degree;
        flanks.before.next = flanks.after.next = 1;
        const double lift =
            need_few_lanes(run, flanks) ? lift_in<few_lanes>(run, flanks) : lift_in<all_lanes>(run, flanks);
        return lift * std::copysign(1.0, lift_mm) >= same_without * std::abs(lift_mm);
    }

    template <int Lanes>
    double lift_in(const LiftedRun& run, const Flanks& flanks) {
        return RunAmongOthers<Lanes>(chain_, run, flanks, sigma_of(run.first)).lift_mm();
    }

    ChainState& chain_;
    std::vector<PointState> heard_;     // as they were when the last runs were heard
    std::vector<double> steps_, most_;  // most_: of the contrasts of the runs that begin there
    std::vector<Candidate> open_;
    std::vector<LiftedRun> bad_;  // the surest first
    ByRun<double> contrasts_;     // as the states and the steps are now
    ByRun<Fails> fails_;          // since nothing changed near it
};

LiftedRuns::LiftedRuns(ChainState& chain) : search_(std::make_unique<Search>(chain)) {}
LiftedRuns::~LiftedRuns() = default;

bool LiftedRuns::convict() {
    return search_->convict();
}

}  // namespace cmm::fitting
