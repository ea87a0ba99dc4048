// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <map>
#include <vector>

namespace cmm::drivers::test {

using Bytes = std::vector<std::uint8_t>;

/// 16 bits, high byte first, as Modbus has them.
std::uint16_t word(const Bytes& bytes, std::size_t at);
void add_word(Bytes& bytes, std::size_t value);

/// Registers of a controller that behaves as docs/protocol-modbus.md says, written from that page and in the simplest
/// way. It has no time of its own: motions go on by one step with every FIFO exchange. No lock, no wire: one owner.
class ScriptedMachine {
  public:
    ScriptedMachine();

    /// One request without its header; the reply likewise.
    Bytes execute(const Bytes& pdu);

    void set_register(std::size_t address, std::uint16_t value, bool mend_crc);
    std::uint16_t register_at(std::size_t address) const { return registers_[address]; }
    /// Ends the present motion with a result code, as the watchdog, an overflow or a collision would.
    void end_motion(std::uint16_t result, std::uint16_t state);
    void restart();  ///< another boot id, nothing in the FIFO
    void motions_take(int exchanges) { exchanges_per_motion_ = exchanges; }

    int executed(int opcode) const;
    std::uint32_t acknowledged() const { return acknowledged_; }
    std::uint32_t newest() const { return static_cast<std::uint32_t>(samples_.size()); }
    std::chrono::steady_clock::time_point stop_arrived() const { return stop_arrived_; }
    std::uint16_t stop_value() const { return stop_value_; }

  private:
    struct StoredSample {
        std::array<std::int32_t, 3> counts;
        std::uint16_t path;
        bool touch;
    };

    void seed_identity();
    Bytes read_registers(std::size_t function, std::size_t address, std::size_t count);
    bool write_registers(std::size_t address, const std::vector<std::uint16_t>& values, int& exception);
    void command();
    void begin_motion(std::uint16_t state);
    void finish(std::uint16_t command_state, std::uint16_t result);
    bool take_window(const std::vector<std::uint16_t>& values, int& exception);
    void step();
    void advance_scan();
    void exchange();
    void refresh_status();
    void stop(std::uint16_t kind);
    void set_crc(std::size_t first, std::size_t count, std::size_t at);
    void put32(std::size_t at, std::uint32_t value);
    std::uint32_t get32(std::size_t at) const;

    int exchanges_per_motion_ = 3;
    std::array<std::uint16_t, 1024> registers_{};
    std::vector<std::vector<std::uint16_t>> path_;  // raw points
    std::vector<StoredSample> samples_;             // sample k has number k + 1
    std::map<int, int> executed_;
    std::uint32_t acknowledged_ = 0;
    std::uint32_t owner_ = 0;
    std::uint16_t running_opcode_ = 0;
    int steps_left_ = 0;
    std::size_t passed_ = 0;
    std::uint16_t path_id_ = 0;
    std::chrono::steady_clock::time_point stop_arrived_{};
    std::uint16_t stop_value_ = 0;
};

}  // namespace cmm::drivers::test
