// SPDX-License-Identifier: Apache-2.0
#include "sim/serial_line.hpp"

#include <fcntl.h>
#include <pty.h>
#include <termios.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <utility>

namespace cmm::sim {
namespace {

using Speed = std::pair<int, speed_t>;
constexpr std::array speeds{Speed{300, B300},         Speed{600, B600},         Speed{1200, B1200},
                            Speed{2400, B2400},       Speed{4800, B4800},       Speed{9600, B9600},
                            Speed{19200, B19200},     Speed{38400, B38400},     Speed{57600, B57600},
                            Speed{115200, B115200},   Speed{230400, B230400},   Speed{460800, B460800},
                            Speed{500000, B500000},   Speed{576000, B576000},   Speed{921600, B921600},
                            Speed{1000000, B1000000}, Speed{1152000, B1152000}, Speed{1500000, B1500000},
                            Speed{2000000, B2000000}, Speed{3000000, B3000000}, Speed{4000000, B4000000}};

core::Status set_line(int fd, const SerialLine& line) {
    const Speed* found = nullptr;
    for (const Speed& speed : speeds)
        if (speed.first == line.baud) found = &speed;
    if (found == nullptr) {
        return core::fail(core::ErrorCode::usage, std::to_string(line.baud) + " baud is no speed of serial ports");
    }
    termios settings{};
    if (::tcgetattr(fd, &settings) != 0) {
        return core::fail(core::ErrorCode::transport_connect,
                          line.path + " is no serial line: " + std::strerror(errno));
    }
    ::cfmakeraw(&settings);
    settings.c_cflag |= CLOCAL | CREAD;
    settings.c_cflag &= ~static_cast<tcflag_t>(CSTOPB | PARENB | PARODD | CRTSCTS);
    if (line.stop_bits == 2) settings.c_cflag |= CSTOPB;
    if (line.parity != SerialLine::Parity::none) settings.c_cflag |= PARENB;
    if (line.parity == SerialLine::Parity::odd) settings.c_cflag |= PARODD;
    ::cfsetispeed(&settings, found->second);
    ::cfsetospeed(&settings, found->second);
    // A pty takes no parity; nothing is lost by it.
    if (::tcsetattr(fd, TCSANOW, &settings) != 0 && !line.pty) {
        return core::fail(core::ErrorCode::transport_connect,
                          "cannot set up " + line.path + ": " + std::strerror(errno));
    }
    return {};
}

void make_nonblocking(int fd) {
    ::fcntl(fd, F_SETFL, ::fcntl(fd, F_GETFL, 0) | O_NONBLOCK);
    ::fcntl(fd, F_SETFD, FD_CLOEXEC);
}

}  // namespace

OpenLine::OpenLine(OpenLine&& other) noexcept
    : ours_(std::move(other.ours_)), hosts_(std::move(other.hosts_)), link_(std::exchange(other.link_, {})) {}

OpenLine& OpenLine::operator=(OpenLine&& other) noexcept {
    std::swap(ours_, other.ours_);
    std::swap(hosts_, other.hosts_);
    std::swap(link_, other.link_);
    return *this;
}

OpenLine::~OpenLine() {
    std::error_code ignored;
    if (!link_.empty()) std::filesystem::remove(link_, ignored);
}

core::Result<OpenLine> OpenLine::open(const SerialLine& line) {
    OpenLine opened;
    const auto failed = [&] {
        return core::fail(core::ErrorCode::transport_connect, "cannot open " + line.path + ": " + std::strerror(errno));
    };
    if (line.pty) {
        int ours = -1;
        int hosts = -1;
        std::array<char, 256> name{};
        if (::openpty(&ours, &hosts, name.data(), nullptr, nullptr) != 0) return failed();
        opened.ours_ = Descriptor(ours);
        opened.hosts_ = Descriptor(hosts);
        std::error_code error;
        // A link that an earlier simulator left behind gives way, nothing else does.
        if (std::filesystem::is_symlink(line.path, error)) std::filesystem::remove(line.path, error);
        std::filesystem::create_symlink(name.data(), line.path, error);
        if (error) {
            return core::fail(core::ErrorCode::transport_connect,
                              "cannot link " + line.path + " to the pseudo-terminal: " + error.message());
        }
        opened.link_ = line.path;
        if (auto set = set_line(hosts, line); !set) return tl::unexpected(set.error());
    } else {
        opened.ours_ = Descriptor(::open(line.path.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
        if (opened.fd() < 0) return failed();
        if (auto set = set_line(opened.fd(), line); !set) return tl::unexpected(set.error());
        ::tcflush(opened.fd(), TCIOFLUSH);
    }
    make_nonblocking(opened.fd());
    return opened;
}

}  // namespace cmm::sim
