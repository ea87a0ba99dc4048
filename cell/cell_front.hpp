// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <memory>

#include "cell/cell.hpp"
#include "cell/plc_server.hpp"
#include "core/clock.hpp"
#include "core/error.hpp"

namespace cmm::cell {

/// The cell and its Modbus server on a thread of their own, so that a PLC is answered whatever the runs are busy with.
/// Any thread; nothing here waits.
class CellFront {
  public:
    struct Options {
        CellOptions cell;
        PlcServerOptions server;
    };
    /// Called on the front's thread, after each change that a PLC sees: state, part, outcome, decision.
    using Changed = std::function<void(const CellView&)>;
    /// How long after the arrival of the sample that decided it a rejection was in the registers.
    using Told = std::function<void(core::Duration)>;

    /// Listens when it returns. The host's functions are called on the front's thread; they and the clock outlive it.
    /// Errors: usage.
    static core::Result<std::unique_ptr<CellFront>> start(const Options& options, CellHost host,
                                                          const core::Clock& clock, Changed changed, Told told);
    ~CellFront();
    CellFront(const CellFront&) = delete;
    CellFront& operator=(const CellFront&) = delete;

    void recorded();
    /// `arrived`: when the sample that decided it came in.
    void rejected_for_certain(std::size_t section, core::Duration arrived);
    void progress(double share, std::size_t section);
    void held(Reason reason);
    void ended(const Outcome& outcome);
    void shut_down();

    std::uint16_t port() const;
    /// At most a tick (20 ms) old.
    CellView view() const;
    PlcServerCounts counts() const;

  private:
    struct Impl;
    explicit CellFront(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> impl_;
};

}  // namespace cmm::cell
