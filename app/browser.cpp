// SPDX-License-Identifier: Apache-2.0
#include "app/browser.hpp"

#include <fcntl.h>
#include <spawn.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <filesystem>
#include <sstream>
#include <string_view>

extern char** environ;  // NOLINT(readability-identifier-naming): POSIX

namespace cmm::app {
namespace {

constexpr const char* opener = "xdg-open";
constexpr mode_t owner_only = 0600;

bool is_set(const char* variable) {
    const char* value = std::getenv(variable);
    return value != nullptr && *value != '\0';
}

bool is_in_path(const char* program) {
    const char* path = std::getenv("PATH");
    std::istringstream folders(path == nullptr ? "" : path);
    for (std::string folder; std::getline(folders, folder, ':');)
        if (!folder.empty() && ::access((folder + "/" + program).c_str(), X_OK) == 0) return true;
    return false;
}

bool write_own(const std::string& file, std::string_view text) {
    std::error_code ignored;
    std::filesystem::remove(file, ignored);
    const int out = ::open(file.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, owner_only);
    if (out < 0) return false;
    const auto written = ::write(out, text.data(), text.size());
    return ::close(out) == 0 && written == static_cast<ssize_t>(text.size());
}

/// In a session of its own, so that Ctrl-C is not for the browser, and silent. It is not waited for.
void start(const std::string& file) {
    std::array<std::string, 2> words{opener, file};
    std::array<char*, 3> arguments{words[0].data(), words[1].data(), nullptr};
    posix_spawnattr_t own;
    posix_spawn_file_actions_t silent;
    if (::posix_spawnattr_init(&own) != 0) return;
    if (::posix_spawn_file_actions_init(&silent) == 0) {
        ::posix_spawnattr_setflags(&own, POSIX_SPAWN_SETSID);
        for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
            ::posix_spawn_file_actions_addopen(&silent, stream, "/dev/null", O_RDWR, 0);
        pid_t child = 0;
        static_cast<void>(::posix_spawnp(&child, opener, &silent, &own, arguments.data(), environ));
        ::posix_spawn_file_actions_destroy(&silent);
    }
    ::posix_spawnattr_destroy(&own);
}

}  // namespace

bool browser_at_hand() {
    return ::isatty(STDOUT_FILENO) != 0 && ::isatty(STDERR_FILENO) != 0 && !is_set("CI") &&
           (is_set("DISPLAY") || is_set("WAYLAND_DISPLAY")) && is_in_path(opener);
}

ShownPage::ShownPage(const std::string& url, const std::string& folder)
    : file_(std::filesystem::absolute(folder).string() + "/open.html") {
    const std::string text =
        "<!DOCTYPE html><meta charset=\"utf-8\"><title>cmmlive</title>"
        "<meta http-equiv=\"refresh\" content=\"0;url=" +
        url + "\"><a href=\"" + url + "\">" + "cmmlive</a>\n";
    if (write_own(file_, text)) start(file_);
}

ShownPage::~ShownPage() {
    std::error_code ignored;
    std::filesystem::remove(file_, ignored);
}

}  // namespace cmm::app
