// SPDX-License-Identifier: Apache-2.0
#include "sim/fault_plan.hpp"

#include <algorithm>
#include <array>

#include "core/config.hpp"

namespace cmm::sim {
namespace {

using enum FaultKind;

/// A kind's name and the keys it has besides the time.
struct Facts {
    FaultKind kind;
    std::string_view name;
    bool wire;
    bool lasts, repeats;            // for_s, times
    const char* amount;             // key, nullptr: none
    double usual;                   // of the amount
    core::Bounds bounds{0.0, 0.0};  // of the amount
};

constexpr std::array facts{
    Facts{emergency_stop, "emergency_stop", false, true, false, nullptr, 0.0},
    Facts{door, "door", false, true, false, nullptr, 0.0},
    Facts{temperature, "temperature", false, true, false, nullptr, 0.0},
    Facts{over_deflection, "over_deflection", false, false, false, nullptr, 0.0},
    Facts{collision, "collision", false, false, false, nullptr, 0.0},
    Facts{travel_limit, "travel_limit", false, false, false, nullptr, 0.0},
    Facts{encoder_jump, "encoder_jump", false, true, false, nullptr, 0.0},
    Facts{fifo_overflow, "fifo_overflow", false, false, false, nullptr, 0.0},
    Facts{clock_jump, "clock_jump", false, false, false, "by_s", 3600.0, {-1e6, 1e6}},
    Facts{drift, "drift", false, true, false, "um_per_s", 1.0, {-1000.0, 1000.0}},
    Facts{lift_off, "lift_off", false, false, true, "um", 300.0, {1.0, 10000.0}},
    Facts{dirt, "dirt", false, false, true, "um", 100.0, {1.0, 10000.0}},
    Facts{part_shift, "part_shift", false, false, false, "mm", 0.5, {-100.0, 100.0}},
    Facts{restart, "restart", false, true, false, nullptr, 0.0},
    Facts{hang, "hang", false, true, false, nullptr, 0.0},
    Facts{exception, "exception", false, false, true, "code", 6.0, {1.0, 11.0}},
    Facts{delay, "delay", true, false, true, "ms", 300.0, {0.0, 60000.0}},
    Facts{lost_request, "lost_request", true, false, true, nullptr, 0.0},
    Facts{lost_reply, "lost_reply", true, false, true, nullptr, 0.0},
    Facts{bad_crc, "bad_crc", true, false, true, nullptr, 0.0},
    Facts{split, "split", true, false, true, "ms", 10.0, {0.0, 60000.0}},
    Facts{merged, "merged", true, false, true, nullptr, 0.0},
    Facts{duplicated, "duplicated", true, false, true, nullptr, 0.0},
    Facts{stale, "stale", true, false, true, nullptr, 0.0},
    Facts{truncated, "truncated", true, false, true, nullptr, 0.0},
    Facts{reordered, "reordered", true, false, true, nullptr, 0.0},
    Facts{wrong_unit, "wrong_unit", true, false, true, nullptr, 0.0},
    Facts{closed, "closed", true, true, false, nullptr, 0.0},
    Facts{half_open, "half_open", true, false, false, nullptr, 0.0},
    Facts{cable, "cable", true, true, false, nullptr, 0.0},
    Facts{dropped_bytes, "dropped_bytes", true, true, false, "rate", 1e-3, {0.0, 1.0}},
    Facts{flipped_bytes, "flipped_bytes", true, true, false, "rate", 1e-3, {0.0, 1.0}},
    Facts{overrun, "overrun", true, false, true, "bytes", 4.0, {1.0, 256.0}},
};

const Facts& facts_of(FaultKind kind) noexcept {
    return facts[static_cast<std::size_t>(kind)];
}

/// "samples = [100, 400]" or "samples = 250", or the same of requests or seconds.
FaultTime read_time(const core::ConfigTable& in) {
    constexpr std::array counts{"samples", "requests", "seconds"};
    FaultTime when;
    int given = 0;
    for (std::size_t i = 0; i < counts.size(); ++i) {
        const char* key = counts[i];
        if (!in.has(key)) continue;
        ++given;
        when.count = static_cast<FaultTime::Count>(i);
        const auto range = in.is_list(key) ? in.numbers(key) : std::vector<double>{in.number(key, 0.0)};
        const bool sound = (range.size() == 1 || range.size() == 2) && range.front() >= 0.0 &&
                           range.back() >= range.front() && range.back() <= 1e9;
        if (!sound) {
            in.complain(key, "must be a number from 0 on, or two of them, the smaller first");
            continue;
        }
        when.from = range.front();
        when.to = range.back();
    }
    if (given != 1) in.complain("what", "needs one of samples, requests, seconds to say when");
    return when;
}

Fault read_fault(const core::ConfigTable& in) {
    std::vector<std::string_view> names;
    for (const Facts& entry : facts)
        names.push_back(entry.name);
    Fault fault;
    fault.when = read_time(in);
    fault.again = in.boolean("again", false);
    if (!in.has("what")) in.complain("what", "is missing");
    const std::string name = in.word("what", "", names);
    const auto* const found = std::find_if(facts.begin(), facts.end(), [&](const Facts& f) { return f.name == name; });
    if (found == facts.end()) {
        if (in.has("what")) in.ignore_rest();
        return fault;
    }
    fault.kind = found->kind;
    if (found->lasts) fault.for_s = in.number("for_s", 0.0, {0.0, 1e6});
    if (found->repeats) fault.times = static_cast<int>(in.integer("times", 1, {1, 1e6}));
    if (found->amount != nullptr) fault.amount = in.number(found->amount, found->usual, found->bounds);
    return fault;
}

}  // namespace

std::string_view to_string(FaultKind kind) noexcept {
    return facts_of(kind).name;
}

bool on_the_wire(FaultKind kind) noexcept {
    return facts_of(kind).wire;
}

core::Result<FaultPlan> load_fault_plan(const std::string& file) {
    const auto root = core::ConfigTable::load(file);
    if (!root) return tl::unexpected(root.error());
    FaultPlan plan;
    if (root->has("seed")) plan.seed = static_cast<std::uint64_t>(root->integer("seed", 0, {0, 9e15}));
    for (const core::ConfigTable& table : root->tables("fault"))
        plan.faults.push_back(read_fault(table));
    if (const auto status = root->finish(); !status) return tl::unexpected(status.error());
    return plan;
}

}  // namespace cmm::sim
