// SPDX-License-Identifier: Apache-2.0
#include "tests/support/linuxcnc_peer.hpp"

#include <net/if.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstring>

namespace cmm::test {
namespace {

/// One interface, the loopback, of this process and its children.
bool alone_on_the_network() {
    if (::unshare(CLONE_NEWNET) != 0) return false;
    const int fd = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    ifreq loopback{};
    std::strncpy(loopback.ifr_name, "lo", IFNAMSIZ - 1);
    loopback.ifr_flags = IFF_UP | IFF_RUNNING;
    const bool up = ::ioctl(fd, SIOCSIFFLAGS, &loopback) == 0;
    ::close(fd);
    return up;
}

}  // namespace

std::string LinuxcncPeer::obstacle() {
    if (run({"/bin/sh", "-c", "command -v linuxcnc setpriv unshare"}).exit_code != 0)
        return "LinuxCNC (linuxcnc-uspace) is not installed";
    if (::geteuid() != 0) return "LinuxCNC is started in namespaces of its own, which needs root";
    if (!alone_on_the_network()) return "no network namespace can be made here";
    return {};
}

LinuxcncPeer::LinuxcncPeer(const std::string& log_stem)
    : process_({"/bin/sh", "tests/peers/linuxcnc/start.sh"}, log_stem) {}

}  // namespace cmm::test
