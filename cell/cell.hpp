// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <set>
#include <string>

#include "cell/handshake.hpp"
#include "cell/outcome.hpp"
#include "cell/record.hpp"
#include "cell/registers.hpp"
#include "core/clock.hpp"

namespace cmm::cell {

/// What the cell asks of the service around it. Called on the cell's thread; none of them waits.
struct CellHost {
    std::function<void(const CellRecord&)> record;  ///< answered by `recorded`
    std::function<void(const Order&)> run;          ///< answered by `ended`
    std::function<void()> stop;                     ///< the run; answered by `ended`
};

struct CellOptions {
    std::set<std::uint16_t> programs;
    core::Duration watchdog = std::chrono::seconds(2);
    CellRecord restored;  ///< as the service left it, or was cut off
};

/// What everybody may know of the cell; a value.
struct CellView {
    CellState state = CellState::waiting;
    Order order;      ///< the part under way or the last one; run 0: none
    Outcome outcome;  ///< of that part, none until it is known
    bool rejected_for_certain = false;
    bool plc_lives = false;
    std::uint64_t plc_losses = 0;   ///< how often its heartbeat stood still for too long
    std::size_t section = 0;        ///< under the probe, from 1 on; 0: none
    double share = 0.0;             ///< done of the part
    Reason held_by = Reason::none;  ///< what the run waits for
};

/// One measuring cell between a PLC's registers and the runs: the shell round the table of handshake.hpp. One thread;
/// the time is passed in.
class Cell {
  public:
    Cell(CellOptions options, CellHost host);

    ModbusException read(std::size_t address, std::span<std::uint16_t> to) const;
    /// By whoever may write.
    ModbusException write(std::size_t address, std::span<const std::uint16_t> from, core::Duration now);
    /// Several times within the watchdog's time.
    void tick(core::Duration now);

    /// What was asked to be recorded last is on the disk (or will never be: the handshake goes on).
    void recorded();
    /// The part is out of tolerance whatever comes; while a run goes on.
    void rejected_for_certain(std::size_t section);
    void progress(double share, std::size_t section);
    /// The run waits at rest for what may pass, and goes on by itself; none: it does.
    void held(Reason reason);
    /// The run is over.
    void ended(const Outcome& outcome);
    /// No start is taken any more, a run is stopped. Nothing is under way once `at_rest`.
    void shut_down();
    bool at_rest() const;

    CellView view() const;

  private:
    void look();
    std::optional<CellInput> next_input();
    std::optional<CellInput> on_start();
    std::optional<Reason> cause_to_stop() const;
    void apply(CellInput input);
    void act(CellAction action);
    void show();

    CellOptions options_;
    CellHost host_;
    CellState state_ = CellState::waiting;
    PlcBlock plc_;
    CellBlock cell_;
    Order order_;
    Outcome outcome_;
    std::optional<Reason> stopped_by_;
    std::size_t decided_section_ = 0;  // from 1 on; 0: not decided
    std::size_t section_ = 0;
    Reason held_by_ = Reason::none;
    double share_ = 0.0;
    core::Duration heard_{0}, ticked_{0};  // the PLC's heartbeat changed last; ours
    bool lives_ = false, shutting_down_ = false;
    bool commanded_ = false;  // a PLC has said what it asks for: the zeros of the beginning are nobody's
    std::uint64_t losses_ = 0;
};

}  // namespace cmm::cell
