// SPDX-License-Identifier: Apache-2.0
#include "sim/fault_play.hpp"

#include "core/text.hpp"
#include "core/units.hpp"

namespace cmm::sim {
namespace {

using enum FaultKind;

constexpr core::Duration forever = core::Duration::max();

/// What the controller calls it; ok: it notices nothing.
ResultCode reason_of(FaultKind kind) {
    switch (kind) {
        case emergency_stop:
            return ResultCode::emergency;
        case door:
            return ResultCode::door;
        case temperature:
            return ResultCode::temperature;
        case over_deflection:
            return ResultCode::over_deflection;
        case collision:
            return ResultCode::collision;
        case travel_limit:
            return ResultCode::travel_limit;
        case encoder_jump:
            return ResultCode::position_lost;
        case fifo_overflow:
            return ResultCode::overflow;
        default:
            return ResultCode::ok;
    }
}

bool is_rate(FaultKind kind) {
    return kind == dropped_bytes || kind == flipped_bytes;
}

}  // namespace

FaultPlay::FaultPlay(const FaultPlan& plan, std::uint64_t seed, Controller& controller, const core::Clock& clock,
                     Tell tell)
    : rng_(core::Rng::keyed(plan.seed.value_or(seed), 7, 0)),
      controller_(controller),
      clock_(clock),
      tell_(std::move(tell)) {
    for (const Fault& fault : plan.faults) {
        entries_.push_back(Entry{fault});
        draw(entries_.back(), 0.0);
    }
}

double FaultPlay::count(FaultTime::Count what) const {
    switch (what) {
        case FaultTime::Count::samples:
            return static_cast<double>(samples_);
        case FaultTime::Count::requests:
            return static_cast<double>(requests_);
        case FaultTime::Count::seconds:
            break;
    }
    return requests_ == 0 ? 0.0 : core::seconds(clock_.now() - first_request_);
}

void FaultPlay::draw(Entry& entry, double base) {
    entry.at = base + rng_.uniform(entry.fault.when.from, entry.fault.when.to);
}

bool FaultPlay::due(const Entry& entry) const {
    return entry.armed && requests_ > 0 && count(entry.fault.when.count) >= entry.at && fits_motion(entry.fault.kind);
}

/// What can only happen to a machine in motion waits for it.
bool FaultPlay::fits_motion(FaultKind kind) const {
    if (kind == fifo_overflow) return controller_.state() == MachineState::scanning;
    return moving() || (kind != collision && kind != over_deflection && kind != travel_limit);
}

void FaultPlay::strike(Entry& entry) {
    entry.armed = entry.fault.again;
    if (entry.fault.again) draw(entry, count(entry.fault.when.count));
    entry.under_way = entry.fault.for_s > 0.0;
    const core::Duration now = clock_.now();
    entry.ends = entry.under_way ? now + core::from_ms(1e3 * entry.fault.for_s) : forever;
    watching_ = moving();
    struck_ = now;
    struck_machine_s_ = controller_.machine_time_s();
    tell_("fault " + std::string(to_string(entry.fault.kind)) + " after " + std::to_string(samples_) + " samples, " +
          std::to_string(requests_) + " requests, " + core::fixed(count(FaultTime::Count::seconds), 3) +
          " s, machine " + (watching_ ? "in motion" : "at rest"));
    if (!on_the_wire(entry.fault.kind)) {
        break_machine(entry.fault);
        struck_machine_s_ = controller_.machine_time_s();  // a restart begins it anew
        return;
    }
    if (entry.fault.kind == cable) {
        silent_until_ = entry.ends;
    } else if (is_rate(entry.fault.kind)) {
        entry.under_way = true;
    } else {
        entry.left = entry.fault.times;
    }
}

void FaultPlay::break_machine(const Fault& fault) {
    if (const ResultCode reason = reason_of(fault.kind); reason != ResultCode::ok) {
        return controller_.break_down(reason);
    }
    const core::Duration ends = fault.for_s > 0.0 ? clock_.now() + core::from_ms(1e3 * fault.for_s) : forever;
    switch (fault.kind) {
        case clock_jump:
            return controller_.jump_clock(fault.amount);
        case drift:
            return controller_.drift(core::mm_from_um(fault.amount));
        case lift_off:
            return controller_.lift_off(fault.times, core::mm_from_um(fault.amount));
        case dirt:
            return controller_.soil(fault.times, core::mm_from_um(fault.amount));
        case part_shift:
            return controller_.shift_part(Eigen::Vector3d(fault.amount, 0.0, 0.0));
        case exception:
            return controller_.refuse_next(static_cast<std::uint8_t>(fault.amount), fault.times);
        case restart:
            ++generation_;
            controller_.restart(static_cast<std::uint16_t>(controller_.options().boot_id % 65535U + 1U));
            if (fault.for_s > 0.0) silent_until_ = ends;
            return;
        case hang:
            silent_until_ = ends;
            return;
        default:
            return;
    }
}

void FaultPlay::mend(Entry& entry) {
    entry.under_way = false;
    const ResultCode reason = entry.fault.kind == restart ? ResultCode::position_lost : reason_of(entry.fault.kind);
    controller_.restore(reason);
    if (entry.fault.kind == drift) controller_.drift(0.0);
    tell_("mended " + std::string(to_string(entry.fault.kind)));
}

void FaultPlay::step() {
    for (Entry& entry : entries_) {
        if (entry.under_way && clock_.now() >= entry.ends) mend(entry);
        if (due(entry)) strike(entry);
    }
    watch_rest();
}

void FaultPlay::watch_rest() {
    if (!watching_ || moving()) return;
    watching_ = false;
    tell_("at rest " + core::fixed(core::seconds(clock_.now() - struck_) * 1e3, 1) + " ms later, " +
          core::fixed((controller_.machine_time_s() - struck_machine_s_) * 1e3, 1) + " ms of the machine");
}

const Fault* FaultPlay::next_message(bool arriving) {
    for (Entry& entry : entries_) {
        const bool about_arrivals = entry.fault.kind == lost_request || entry.fault.kind == overrun;
        if (entry.left == 0 || about_arrivals != arriving) continue;
        --entry.left;
        return &entry.fault;
    }
    return nullptr;
}

const Fault* FaultPlay::next_reply() {
    if (requests_++ == 0) first_request_ = clock_.now();
    step();  // what is due at this request meets this one
    return next_message(false);
}

const Fault* FaultPlay::next_arrival() {
    return next_message(true);
}

void FaultPlay::spoil(std::vector<std::uint8_t>& bytes) {
    for (const Entry& entry : entries_) {
        if (!entry.under_way || !is_rate(entry.fault.kind)) continue;
        std::vector<std::uint8_t> kept;
        for (const std::uint8_t byte : bytes) {
            const bool hit = rng_.uniform() < entry.fault.amount;
            if (hit && entry.fault.kind == dropped_bytes) continue;
            kept.push_back(hit ? static_cast<std::uint8_t>(byte ^ (1U << rng_.below(8))) : byte);
        }
        bytes = std::move(kept);
    }
}

}  // namespace cmm::sim
