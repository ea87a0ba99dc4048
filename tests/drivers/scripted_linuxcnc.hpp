// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <atomic>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <mutex>
#include <set>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace cmm::drivers::test {

/// A linuxcncrsh played over a real socket, with a LinuxCNC of a few lines behind it. Its time is the number of
/// questions about the program: a motion ends after `motion_looks` of them. What it does wrong is up to the test.
class ScriptedLinuxcnc {
  public:
    struct State {
        bool estop = false, machine = true, homed = true;
        bool estop_wired_open = false;  ///< the emergency stop cannot be taken back
        bool never_homes = false;
        std::string mode = "MANUAL", units = "MM", password = "EMC";
        std::string codes = "G38.3 G17 G20 G90 G94 G54 G64";
        double unit_mm = 1.0, rotation_deg = 0.0;
        Eigen::Vector3d position_mm = Eigen::Vector3d::Zero(), offset_mm = Eigen::Vector3d::Zero();
        Eigen::Vector3d ball_mm = Eigen::Vector3d(100.0, 0.0, 0.0);
        double ball_radius_mm = 15.0, x_limit_mm = 500.0;
        int motion_looks = 3;
        int looks_before_motion = 0;  ///< so often the interpreter is idle before a motion begins
        int stolen_reports = 0;       ///< another user interface reads so many of them
        Eigen::Vector3d contact_shift_mm = Eigen::Vector3d::Zero();  ///< added to what #5061... say
        std::string hang_up_on, silent_on;  ///< a line that begins so ends the connection, or is not answered; once
        bool carry_out_first = false;       ///< ... after it was carried out
        std::string error_in_motion;        ///< said in the middle of the next motion, which ends there
        bool estop_in_motion = false;
        std::function<void(const std::string&)> on_line;
    };

    ScriptedLinuxcnc();
    ~ScriptedLinuxcnc();
    ScriptedLinuxcnc(const ScriptedLinuxcnc&) = delete;
    ScriptedLinuxcnc& operator=(const ScriptedLinuxcnc&) = delete;

    std::string url() const { return "linuxcnc://127.0.0.1:" + std::to_string(port_); }
    void change(const std::function<void(State&)>& how);
    State state();
    /// Lines that began so.
    int heard(const std::string& beginning);
    /// Keeps new connections from being answered.
    void hang_up();

  private:
    struct Motion {
        Eigen::Vector3d from_mm, to_mm;
        bool probing = false;
        int looks_before = 0, looks_left = 0;
    };
    void serve();
    /// The reply with its line end; empty: none.
    std::string reply(int fd, const std::string& line);
    std::string reply_to_get(const std::string& what);
    std::string reply_to_set(int fd, const std::string& what, const std::string& value);
    bool mdi(const std::string& code);
    void look_at_motion();
    void end_motion();
    void print_report(const std::string& parameters);
    std::string take_message(const std::string& kind);
    std::string numbers(const Eigen::Vector3d& mm) const;
    double contact_at(const Motion& motion) const;

    std::mutex mutex_;
    State state_;
    bool moving_ = false;
    Motion motion_;
    std::vector<std::string> later_;  // what the interpreter does after the motion
    std::deque<std::pair<std::string, std::string>> queue_;
    std::map<std::string, std::string> told_;  // kind -> message
    std::map<std::string, double> parameters_{{"#5070", 1.0}};
    std::vector<std::string> heard_;
    std::set<int> connections_;
    int in_control_ = -1;
    int listener_ = -1;
    std::uint16_t port_ = 0;
    std::atomic<bool> ending_{false};
    std::thread thread_;
};

}  // namespace cmm::drivers::test
