// SPDX-License-Identifier: Apache-2.0
#include "cell/cell.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace cmm::cell {
namespace {

constexpr auto heartbeat_every = std::chrono::milliseconds(100);

std::uint16_t word(std::size_t number) {
    return static_cast<std::uint16_t>(std::min<std::size_t>(number, 0xFFFF));
}

}  // namespace

Cell::Cell(CellOptions options, CellHost host) : options_(std::move(options)), host_(std::move(host)) {
    order_ = options_.restored.order;
    outcome_ = options_.restored.outcome;
    // What was measured when the service was cut off has no result, and whether the machine had time to stop is its
    // own watchdog's affair: the PLC is told, and acknowledges as always.
    if (options_.restored.phase == CellRecord::Phase::measuring)
        outcome_ = {CellResult::error, Reason::service_restarted, false};
    if (options_.restored.phase != CellRecord::Phase::cleared) state_ = CellState::done;
    show();
}

ModbusException Cell::read(std::size_t address, std::span<std::uint16_t> to) const {
    return read_registers(plc_, cell_, address, to);
}

ModbusException Cell::write(std::size_t address, std::span<const std::uint16_t> from, core::Duration now) {
    const auto before = plc_.words[PlcBlock::heartbeat];
    const auto outcome = write_registers(plc_, address, from);
    if (outcome != ModbusException::none) return outcome;
    commanded_ = commanded_ || (address <= PlcBlock::command && address + from.size() > PlcBlock::command);
    if (plc_.words[PlcBlock::heartbeat] != before) {
        heard_ = now;
        lives_ = true;
    }
    look();
    return outcome;
}

void Cell::tick(core::Duration now) {
    if (lives_ && now - heard_ > options_.watchdog) {
        lives_ = false;
        ++losses_;
    }
    if (now - ticked_ >= heartbeat_every) {
        ticked_ = now;
        ++cell_.words[CellBlock::heartbeat];
    }
    look();
}

void Cell::look() {
    while (const auto input = next_input())
        apply(*input);
    show();
}

std::optional<CellInput> Cell::next_input() {
    const bool asks = plc_.has(command_bit::start | command_bit::abort | command_bit::acknowledge);
    switch (state_) {
        case CellState::waiting:
            if (lives_ && commanded_ && !asks && !shutting_down_) return CellInput::neutral;
            return {};
        case CellState::ready:
            if (!lives_ || shutting_down_ || plc_.has(command_bit::abort | command_bit::acknowledge))
                return CellInput::unready;
            return on_start();
        case CellState::starting:
        case CellState::busy:
            stopped_by_ = cause_to_stop();
            if (stopped_by_) return CellInput::stop;
            return {};
        case CellState::done:
            if (plc_.has(command_bit::acknowledge)) return CellInput::acknowledged;
            return {};
        default:
            return {};
    }
}

std::optional<CellInput> Cell::on_start() {
    if (!plc_.has(command_bit::start)) return {};
    ++order_.run;
    order_.program = plc_.words[PlcBlock::program];
    order_.serial = plc_.serial_text();
    outcome_ = {};
    decided_section_ = section_ = 0;
    share_ = 0.0;
    Reason refusal = Reason::none;
    if (!plc_.has(command_bit::part_present)) refusal = Reason::no_part;
    if (!options_.programs.contains(order_.program)) refusal = Reason::no_program;
    if (!is_serial(order_.serial)) {
        refusal = Reason::serial_invalid;
        order_.serial.clear();
    }
    if (refusal == Reason::none) return CellInput::start;
    outcome_ = {CellResult::error, refusal, false};
    return CellInput::refused;
}

std::optional<Reason> Cell::cause_to_stop() const {
    if (plc_.has(command_bit::abort)) return Reason::aborted;
    if (!lives_) return Reason::plc_silent;
    if (!plc_.has(command_bit::part_present)) return Reason::part_removed;
    if (shutting_down_) return Reason::service_stopped;
    return {};
}

void Cell::apply(CellInput input) {
    const auto next = step(state_, input);
    if (!next.accepted) return;
    if (state_ == CellState::cancelled && input == CellInput::recorded)
        outcome_ = {CellResult::error, stopped_by_.value_or(Reason::internal), false};
    state_ = next.state;
    show();
    act(next.action);
}

void Cell::act(CellAction action) {
    using Phase = CellRecord::Phase;
    switch (action) {
        case CellAction::record_start:
            return host_.record({Phase::measuring, order_, {}});
        case CellAction::run:
            return host_.run(order_);
        case CellAction::stop_run:
            return host_.stop();
        case CellAction::record_result:
            return host_.record({Phase::done, order_, outcome_});
        case CellAction::record_cleared:
            return host_.record({Phase::cleared, order_, outcome_});
        case CellAction::none:
            break;
    }
}

void Cell::recorded() {
    apply(CellInput::recorded);
    look();
}

void Cell::rejected_for_certain(std::size_t section) {
    if (!is_busy(state_) || decided_section_ != 0) return;
    decided_section_ = section;
    show();
}

void Cell::progress(double share, std::size_t section) {
    share_ = share;
    section_ = section;
    show();
}

void Cell::held(Reason reason) {
    held_by_ = state_ == CellState::busy || state_ == CellState::stopping ? reason : Reason::none;
    show();
}

void Cell::ended(const Outcome& outcome) {
    if (state_ != CellState::busy && state_ != CellState::stopping) return;
    held_by_ = Reason::none;
    outcome_ = outcome;
    // What is certain stays so, whatever broke the run off; otherwise a run that was to stop has no verdict.
    if (outcome_.result == CellResult::error && decided_section_ != 0) outcome_.result = CellResult::rejected;
    if (state_ == CellState::stopping) {
        outcome_.result = decided_section_ != 0 ? CellResult::rejected : CellResult::error;
        outcome_.reason = stopped_by_.value_or(Reason::internal);
    }
    apply(CellInput::ended);
    look();
}

void Cell::shut_down() {
    shutting_down_ = true;
    look();
}

bool Cell::at_rest() const {
    return state_ == CellState::waiting || state_ == CellState::done;
}

void Cell::show() {
    auto& w = cell_.words;
    const bool done = is_done(state_);
    unsigned status = lives_ ? status_bit::plc_lives : 0U;
    if (state_ == CellState::ready) status |= status_bit::ready;
    if (is_busy(state_)) status |= status_bit::busy;
    if (done) status |= status_bit::done;
    if (decided_section_ != 0 && (is_busy(state_) || done)) status |= status_bit::rejected_for_certain;
    if (state_ == CellState::busy || state_ == CellState::stopping || outcome_.may_be_moving)
        status |= status_bit::may_be_moving;
    if (held_by_ != Reason::none) status |= status_bit::held;
    const auto result = done ? outcome_.result : CellResult::none;
    const auto certain = decided_section_ != 0 && is_busy(state_) ? CellResult::rejected : result;
    w[CellBlock::status] = static_cast<std::uint16_t>(status);
    w[CellBlock::state] = static_cast<std::uint16_t>(state_);
    w[CellBlock::result] = static_cast<std::uint16_t>(result);
    w[CellBlock::reason] = static_cast<std::uint16_t>(done ? outcome_.reason : held_by_);
    w[CellBlock::decision] = static_cast<std::uint16_t>(certain);
    w[CellBlock::decided_section] = word(is_busy(state_) || done ? decided_section_ : 0);
    cell_.put_run(order_.run);
    w[CellBlock::program] = order_.program;
    w[CellBlock::progress] = word(static_cast<std::size_t>(std::lround(std::clamp(share_, 0.0, 1.0) * 1000.0)));
    w[CellBlock::section] = word(is_busy(state_) ? section_ : 0);
    w[CellBlock::watchdog_ms] = word(static_cast<std::size_t>(std::lround(core::seconds(options_.watchdog) * 1000.0)));
    w[CellBlock::plc_heartbeat] = plc_.words[PlcBlock::heartbeat];
    cell_.put_serial(order_.serial);
}

CellView Cell::view() const {
    return {state_, order_, outcome_, decided_section_ != 0, lives_, losses_, section_, share_, held_by_};
}

}  // namespace cmm::cell
