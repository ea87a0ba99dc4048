// SPDX-License-Identifier: Apache-2.0
#include "scripted_linuxcnc.hpp"

#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <sstream>

namespace cmm::drivers::test {
namespace {

std::string upper(std::string text) {
    for (char& c : text)
        c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
    return text;
}

std::string six_places(double value) {
    std::array<char, 64> text{};
    std::snprintf(text.data(), text.size(), "%f", value);
    return text.data();
}

std::optional<double> word_of(const std::string& code, char letter) {
    const auto at = code.find(std::string(" ") + letter);
    if (at == std::string::npos) return std::nullopt;
    return std::strtod(code.c_str() + at + 2, nullptr);
}

}  // namespace

ScriptedLinuxcnc::ScriptedLinuxcnc() {
    listener_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in name{};
    name.sin_family = AF_INET;
    name.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof name;
    auto* address = static_cast<sockaddr*>(static_cast<void*>(&name));
    ::bind(listener_, address, size);
    ::getsockname(listener_, address, &size);
    ::listen(listener_, 8);
    port_ = ntohs(name.sin_port);
    thread_ = std::thread([this] { serve(); });
}

ScriptedLinuxcnc::~ScriptedLinuxcnc() {
    ending_ = true;
    thread_.join();
    for (const int fd : connections_)
        ::close(fd);
    if (listener_ >= 0) ::close(listener_);
}

void ScriptedLinuxcnc::change(const std::function<void(State&)>& how) {
    const std::lock_guard lock(mutex_);
    how(state_);
}

ScriptedLinuxcnc::State ScriptedLinuxcnc::state() {
    const std::lock_guard lock(mutex_);
    return state_;
}

int ScriptedLinuxcnc::heard(const std::string& beginning) {
    const std::lock_guard lock(mutex_);
    int count = 0;
    for (const auto& line : heard_)
        count += line.starts_with(beginning) ? 1 : 0;
    return count;
}

void ScriptedLinuxcnc::hang_up() {
    const std::lock_guard lock(mutex_);
    for (const int fd : connections_)
        ::close(fd);
    connections_.clear();
    ::close(listener_);
    listener_ = -1;
}

void ScriptedLinuxcnc::serve() {
    std::map<int, std::string> unread;
    while (!ending_) {
        std::vector<pollfd> waiting;
        {
            const std::lock_guard lock(mutex_);
            if (listener_ >= 0) waiting.push_back({listener_, POLLIN, 0});
            for (const int fd : connections_)
                waiting.push_back({fd, POLLIN, 0});
        }
        ::poll(waiting.data(), waiting.size(), 20);
        const std::lock_guard lock(mutex_);
        for (const auto& ready : waiting) {
            if (ready.revents == 0) continue;
            if (ready.fd == listener_) {
                const int fd = ::accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
                if (fd >= 0) connections_.insert(fd);
                unread[fd].clear();
                continue;
            }
            if (!connections_.contains(ready.fd)) continue;
            std::array<char, 1024> bytes{};
            const auto count = ::recv(ready.fd, bytes.data(), bytes.size(), MSG_DONTWAIT);
            if (count <= 0) {
                ::close(ready.fd);
                connections_.erase(ready.fd);
                continue;
            }
            std::string& text = unread[ready.fd];
            text.append(bytes.data(), static_cast<std::size_t>(count));
            for (auto end = text.find("\r\n"); end != std::string::npos; end = text.find("\r\n")) {
                const std::string line = text.substr(0, end);
                text.erase(0, end + 2);
                const std::string answer = reply(ready.fd, line);
                if (!connections_.contains(ready.fd)) break;
                if (!answer.empty()) ::send(ready.fd, answer.data(), answer.size(), MSG_NOSIGNAL);
            }
        }
    }
}

std::string ScriptedLinuxcnc::reply(int fd, const std::string& line) {
    heard_.push_back(line);
    if (state_.on_line) state_.on_line(line);
    const bool hang_up = !state_.hang_up_on.empty() && line.starts_with(state_.hang_up_on);
    const bool silent = !state_.silent_on.empty() && line.starts_with(state_.silent_on);
    if (hang_up) state_.hang_up_on.clear();
    if (silent) state_.silent_on.clear();
    std::string answer;
    if (!(hang_up || silent) || state_.carry_out_first) {
        std::istringstream words(line);
        std::string verb;
        std::string what;
        std::string value;
        words >> verb >> what;
        std::getline(words >> std::ws, value);
        if (verb == "hello") answer = what == state_.password ? "HELLO ACK EMCNETSVR 1.1\r\n" : "HELLO NAK\r\n";
        if (verb == "get") answer = reply_to_get(upper(what));
        if (verb == "set") answer = reply_to_set(fd, upper(what), value);
    }
    if (hang_up) {
        ::close(fd);
        connections_.erase(fd);
    }
    return hang_up || silent ? std::string() : answer;
}

std::string ScriptedLinuxcnc::numbers(const Eigen::Vector3d& mm) const {
    std::string text;
    for (const double value : {mm.x(), mm.y(), mm.z(), 0.0, 0.0, 0.0})
        text += " " + six_places(value / state_.unit_mm);
    return text;
}

/// Each question takes one message out of the queue, of whatever kind, and tells the last one of its own kind.
std::string ScriptedLinuxcnc::take_message(const std::string& kind) {
    if (!queue_.empty()) {
        told_[queue_.front().first] = queue_.front().second;
        queue_.pop_front();
    }
    const std::string text = told_[kind];
    told_[kind].clear();
    return kind + " " + (text.empty() ? "OK" : text);
}

std::string ScriptedLinuxcnc::reply_to_get(const std::string& what) {
    std::string text;
    if (what == "PROGRAM_STATUS") {
        const bool begun = moving_ && motion_.looks_before-- <= 0;
        if (begun) look_at_motion();
        text = moving_ && begun ? "PROGRAM_STATUS RUNNING" : "PROGRAM_STATUS IDLE";
    }
    if (what == "ERROR" || what == "OPERATOR_DISPLAY" || what == "OPERATOR_TEXT") text = take_message(what);
    if (what == "ESTOP") text = std::string("ESTOP ") + (state_.estop ? "ON" : "OFF");
    if (what == "MACHINE") text = std::string("MACHINE ") + (state_.machine ? "ON" : "OFF");
    if (what == "MODE") text = "MODE " + state_.mode;
    if (what == "ENABLE") text = std::string("ENABLE ") + (in_control_ >= 0 ? "ON" : "OFF");
    if (what == "JOINT_HOMED")
        text = state_.homed ? "JOINT_HOMED YES YES YES NO NO NO" : "JOINT_HOMED YES NO YES NO NO NO";
    if (what == "PROBE_VALUE")
        text = (state_.position_mm - state_.ball_mm).norm() < state_.ball_radius_mm ? "PROBE_VALUE 1" : "PROBE_VALUE 0";
    if (what == "TELEOP_ENABLE") text = "TELEOP_ENABLE NO";
    if (what == "USER_LINEAR_UNITS") text = "USER_LINEAR_UNITS " + state_.units;
    if (what == "INIFILE") text = "INIFILE /etc/scripted.ini";
    if (what == "PROGRAM_CODES") text = "PROGRAM_CODES " + state_.codes + " F0 S0";
    if (what == "ABS_CMD_POS" || what == "ABS_ACT_POS" || what == "JOINT_POS")
        text = what + numbers(state_.position_mm);
    if (what == "REL_CMD_POS") text = what + numbers(state_.position_mm - state_.offset_mm);
    return text.empty() ? "GET " + what + " NAK\r\n\r\n" : text + "\r\n";
}

std::string ScriptedLinuxcnc::reply_to_set(int fd, const std::string& what, const std::string& value) {
    const std::string big = upper(value);
    bool done = true;
    if (what == "ECHO") return "set echo off\r\nset verbose on\r\n";  // still echoed, never acknowledged
    if (what == "ENABLE") {
        done = value == "EMCTOO" || value == "off";
        if (done) in_control_ = value == "off" ? -1 : fd;
    } else if (what != "VERBOSE" && fd != in_control_) {
        done = false;
    } else if (what == "ESTOP") {
        if (big == "ON") {
            end_motion();
            state_.estop = true;
            state_.machine = false;
        } else {
            state_.estop = state_.estop_wired_open;
        }
    } else if (what == "MACHINE") {
        if (!state_.estop) state_.machine = big == "ON";
    } else if (what == "MODE") {
        state_.mode = big;
    } else if (what == "HOME") {
        if (!state_.never_homes) state_.homed = true;
    } else if (what == "ABORT") {
        end_motion();
    } else if (what == "MDI") {
        done = mdi(value);
    }
    return "SET " + what + (done ? " ACK\r\n" : " NAK\r\n");
}

bool ScriptedLinuxcnc::mdi(const std::string& code) {
    if (!state_.machine || state_.estop || state_.mode != "MDI") return false;
    if (code.starts_with("(DEBUG,")) {
        const std::string parameters = code.substr(7, code.size() - 8);
        if (moving_) {
            later_.push_back(parameters);
        } else {
            print_report(parameters);
        }
        return true;
    }
    if (code.starts_with("G21")) {
        state_.codes = code;
        return true;
    }
    if (const auto tag = code.find("#<_cmmlive>="); tag != std::string::npos) {
        parameters_["#<_cmmlive>"] = std::strtod(code.c_str() + tag + 12, nullptr);
        parameters_["#5070"] = 0.0;
    }
    motion_.probing = code.find("G38.3") != std::string::npos;
    motion_.from_mm = motion_.to_mm = state_.position_mm;
    const Eigen::Vector3d shift = motion_.probing ? state_.offset_mm : Eigen::Vector3d::Zero().eval();
    const std::string letters = "XYZ";
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto k = static_cast<Eigen::Index>(axis);
        if (const auto value = word_of(code, letters[axis])) motion_.to_mm[k] = *value + shift[k];
    }
    if (motion_.to_mm.x() > state_.x_limit_mm) {
        queue_.emplace_back("ERROR", "Linear move on line 0 would exceed X's positive limit");
        queue_.emplace_back("ERROR", "invalid params in linear command");
        return true;
    }
    motion_.looks_before = state_.looks_before_motion;
    motion_.looks_left = state_.motion_looks;
    moving_ = true;
    return true;
}

/// The share of the way up to the ball; 1: it is not met.
double ScriptedLinuxcnc::contact_at(const Motion& motion) const {
    const Eigen::Vector3d way = motion.to_mm - motion.from_mm;
    const Eigen::Vector3d off = motion.from_mm - state_.ball_mm;
    const double a = way.squaredNorm();
    const double b = way.dot(off);
    const double root = b * b - a * (off.squaredNorm() - state_.ball_radius_mm * state_.ball_radius_mm);
    if (a == 0.0 || root < 0.0) return 1.0;
    const double share = (-b - std::sqrt(root)) / a;
    return share >= 0.0 && share < 1.0 ? share : 1.0;
}

void ScriptedLinuxcnc::look_at_motion() {
    if (!moving_) return;
    const Eigen::Vector3d way = motion_.to_mm - motion_.from_mm;
    if (--motion_.looks_left > 0) {
        state_.position_mm = motion_.from_mm + 0.1 * way;
        if (state_.estop_in_motion) {
            state_.estop = true;
            state_.machine = state_.estop_in_motion = false;
            end_motion();
        } else if (!state_.error_in_motion.empty()) {
            queue_.emplace_back("ERROR", std::exchange(state_.error_in_motion, {}));
            end_motion();
        }
        return;
    }
    moving_ = false;
    const double share = contact_at(motion_);
    const Eigen::Vector3d contact = motion_.from_mm + share * way;
    constexpr double overshoot_mm = 0.006;
    state_.position_mm = share < 1.0 ? Eigen::Vector3d(contact + overshoot_mm * way.normalized()) : motion_.to_mm;
    if (motion_.probing) {
        parameters_["#5070"] = share < 1.0 ? 1.0 : 0.0;
        const Eigen::Vector3d told = contact - state_.offset_mm + state_.contact_shift_mm;
        parameters_["#5061"] = told.x();
        parameters_["#5062"] = told.y();
        parameters_["#5063"] = told.z();
    } else if (share < 1.0) {
        queue_.emplace_back("ERROR", "Probe tripped during non-probe move.");
    }
    for (const auto& parameters : std::exchange(later_, {}))
        print_report(parameters);
}

void ScriptedLinuxcnc::end_motion() {
    moving_ = false;
    later_.clear();
}

void ScriptedLinuxcnc::print_report(const std::string& parameters) {
    if (state_.stolen_reports > 0) {
        --state_.stolen_reports;
        return;
    }
    parameters_["#5230"] = state_.rotation_deg;
    std::istringstream words(parameters);
    std::string text;
    for (std::string word; words >> word;)
        text += (text.empty() ? "" : " ") + (word.front() == '#' ? six_places(parameters_[word]) : word);
    queue_.emplace_back("OPERATOR_DISPLAY", text);
}

}  // namespace cmm::drivers::test
