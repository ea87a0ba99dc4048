// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace cmm::drivers::test {

struct Request {
    int function = 0;
    int address = 0;         ///< of the write for FC 6, 16; of the read otherwise
    std::size_t number = 0;  ///< counts all requests since the start, from 1
};

/// What goes wrong with one request.
enum class Fault {
    none,
    silent,         ///< neither executed nor answered
    lost_reply,     ///< executed, not answered
    late_reply,     ///< executed, answered just before the next request's reply
    wrong_id,       ///< answered with another transaction id
    truncated,      ///< half of the reply, then nothing
    closed_mid,     ///< half of the reply, then the connection is closed
    closed,         ///< not executed, the connection is closed
    busy,           ///< exception 6, not executed
    illegal_value,  ///< exception 3, not executed
    bad_crc,        ///< executed, one bit of the data flipped
    old_block,      ///< FC 23: the block before this one, once more
    garbage,        ///< bytes that are no Modbus
};

/// A controller that behaves as docs/protocol-modbus.md says, written from that page and in the simplest way, but for
/// the faults a test puts in. It has no time of its own: motions go on by one step with every FIFO exchange. A thread
/// of its own serves one connection after another on 127.0.0.1; all public functions may be called from any thread.
class ScriptedController {
  public:
    ScriptedController();
    ~ScriptedController();
    ScriptedController(const ScriptedController&) = delete;
    ScriptedController& operator=(const ScriptedController&) = delete;

    std::string url() const { return "modbus+tcp://127.0.0.1:" + std::to_string(port_); }
    /// Asked for every request, on the server's thread.
    void on_request(std::function<Fault(const Request&)> rule);
    void set_register(std::size_t address, std::uint16_t value, bool mend_crc = true);
    std::uint16_t register_at(std::size_t address);
    /// Ends the present motion with a result code, as the watchdog, an overflow or a collision would.
    void end_motion(std::uint16_t result, std::uint16_t state);
    void restart();  ///< another boot id, nothing in the FIFO, connections closed
    void close_listener();

    int executed(int opcode);
    std::uint32_t acknowledged();
    std::uint32_t newest();
    int connections();
    std::chrono::steady_clock::time_point stop_arrived();
    std::uint16_t stop_value();

    std::atomic<int> exchanges_per_motion{3};
    std::atomic<int> points_per_exchange{5};

  private:
    struct StoredSample {
        std::array<std::int32_t, 3> counts;
        std::uint16_t path;
        bool touch;
    };
    using Bytes = std::vector<std::uint8_t>;

    void serve();
    bool serve_client(int fd);
    bool answer(int fd, const Bytes& frame);
    Bytes execute(const Bytes& pdu);
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
    void spoil(Fault fault, Bytes& reply);
    void seed_identity();

    std::mutex mutex_;
    std::function<Fault(const Request&)> rule_;
    std::array<std::uint16_t, 1024> registers_{};
    std::vector<std::vector<std::uint16_t>> path_;  // raw points
    std::vector<StoredSample> samples_;             // sample k has number k + 1
    std::map<int, int> executed_;
    std::uint32_t acknowledged_ = 0;
    std::uint32_t owner_ = 0;
    std::uint16_t running_opcode_ = 0;
    int steps_left_ = 0;
    std::size_t passed_ = 0;
    std::size_t requests_ = 0;
    int connections_ = 0;
    std::uint16_t path_id_ = 0;
    Bytes held_back_, last_block_;
    std::chrono::steady_clock::time_point stop_arrived_{};
    std::uint16_t stop_value_ = 0;
    bool drop_connection_ = false;

    int listener_ = -1;
    std::uint16_t port_ = 0;
    int wake_[2] = {-1, -1};
    std::atomic<bool> quit_{false};
    std::thread thread_;
};

}  // namespace cmm::drivers::test
