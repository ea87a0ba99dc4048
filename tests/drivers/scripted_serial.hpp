// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

#include "scripted_controller.hpp"

namespace cmm::drivers::test {

/// A ScriptedMachine as Modbus RTU unit 1 on a serial port, with the faults a test puts in: `late_reply` comes
/// `late_by` after its request, `bad_crc` and `garbage` spoil the frame, those of a connection do nothing. A thread of
/// its own; all functions may be called from any thread.
class ScriptedSerial {
  public:
    explicit ScriptedSerial(const std::string& port);
    ~ScriptedSerial();
    ScriptedSerial(const ScriptedSerial&) = delete;
    ScriptedSerial& operator=(const ScriptedSerial&) = delete;

    /// Asked for every request, on the thread of the port.
    void on_request(std::function<Fault(const Request&)> rule);
    /// With the machine, while its thread keeps off it.
    template <class Work>
    auto with_machine(Work work) {
        const std::lock_guard lock(mutex_);
        return work(machine_);
    }
    int executed(int opcode) {
        return with_machine([&](const ScriptedMachine& machine) { return machine.executed(opcode); });
    }
    std::atomic<int> late_by_ms{60};
    /// Requests whose CRC did not fit.
    int crc_errors() const { return crc_errors_; }

  private:
    void serve();
    void answer(const Bytes& request);

    int fd_;
    std::mutex mutex_;
    std::function<Fault(const Request&)> rule_;
    ScriptedMachine machine_;
    std::size_t requests_ = 0;
    std::atomic<int> crc_errors_{0};
    std::atomic<bool> quit_{false};
    std::thread thread_;
};

/// CRC-16/MODBUS over bytes, bit by bit.
unsigned crc_of(const Bytes& bytes);

}  // namespace cmm::drivers::test
