// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "scripted_machine.hpp"

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
    old_status,     ///< FC 3: the last status from before the present command
    garbage,        ///< bytes that are no Modbus
    last_first,     ///< executed, answered after those that came together with it
    alone,          ///< answered, and what came together with it is thrown away unread
};

/// A ScriptedMachine on the wire, with the faults a test puts in. A thread of its own serves one connection after
/// another on 127.0.0.1; all public functions may be called from any thread.
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
    void motions_take(int exchanges);
    void restart();  ///< another boot id, nothing in the FIFO, connections closed
    void close_listener();

    int executed(int opcode);
    std::uint32_t acknowledged();
    std::uint32_t newest();
    int connections();
    std::chrono::steady_clock::time_point stop_arrived();
    std::uint16_t stop_value();

  private:
    void serve();
    bool serve_client(int fd);
    bool answer(int fd, const Bytes& frame);
    void spoil(Fault fault, Bytes& reply);
    void keep_status(const Bytes& body);
    void answer_held_back(int fd);

    std::mutex mutex_;
    std::function<Fault(const Request&)> rule_;
    ScriptedMachine machine_;
    std::size_t requests_ = 0;
    int connections_ = 0;
    Bytes held_back_, last_block_, status_, status_before_;
    std::size_t last_block_from_ = 0;
    std::vector<Bytes> last_first_;  // the newest is sent first
    bool drop_connection_ = false;

    int listener_ = -1;
    std::uint16_t port_ = 0;
    int wake_[2] = {-1, -1};
    std::atomic<bool> quit_{false};
    std::thread thread_;
};

}  // namespace cmm::drivers::test
