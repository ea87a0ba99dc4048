// SPDX-License-Identifier: Apache-2.0
#include "tests/support/process.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <thread>

namespace cmm::test {
namespace {

std::string content(const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    std::ostringstream text;
    text << in.rdbuf();
    return text.str();
}

void redirect(const std::string& path, int target) {
    const int fd = ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
    ::dup2(fd, target);
    ::close(fd);
}

}  // namespace

Process::Process(const std::vector<std::string>& arguments, const std::string& log_stem) : log_stem_(log_stem) {
    std::vector<char*> argv;
    for (const auto& argument : arguments)
        argv.push_back(const_cast<char*>(argument.c_str()));
    argv.push_back(nullptr);
    pid_ = ::fork();
    if (pid_ < 0) throw std::runtime_error("fork failed");
    if (pid_ == 0) {
        redirect(log_stem + ".out", STDOUT_FILENO);
        redirect(log_stem + ".err", STDERR_FILENO);
        ::execvp(argv[0], argv.data());
        ::_exit(127);
    }
}

Process::~Process() {
    if (running()) {
        signal(SIGKILL);
        ::waitpid(pid_, &status_, 0);
    }
}

void Process::signal(int number) const {
    ::kill(pid_, number);
}

bool Process::running() {
    if (!ended_ && ::waitpid(pid_, &status_, WNOHANG) == pid_) ended_ = true;
    return !ended_;
}

Finished Process::wait(std::chrono::seconds deadline) {
    if (!wait_for([this] { return !running(); }, deadline)) {
        signal(SIGKILL);
        ::waitpid(pid_, &status_, 0);
        ended_ = true;
    }
    Finished finished;
    finished.exit_code = WIFEXITED(status_) ? WEXITSTATUS(status_) : 128 + WTERMSIG(status_);
    finished.out = content(log_stem_ + ".out");
    finished.err = content(log_stem_ + ".err");
    return finished;
}

std::string Process::out() const {
    return content(log_stem_ + ".out");
}

std::string Process::err() const {
    return content(log_stem_ + ".err");
}

Finished run(const std::vector<std::string>& arguments, std::chrono::seconds deadline) {
    const TemporaryFolder folder;
    return Process(arguments, folder / "log").wait(deadline);
}

bool wait_for(const std::function<bool()>& predicate, std::chrono::milliseconds deadline) {
    const auto end = std::chrono::steady_clock::now() + deadline;
    while (!predicate()) {
        if (std::chrono::steady_clock::now() > end) return false;
        std::this_thread::sleep_for(std::chrono::milliseconds(2));  // between two looks at the predicate
    }
    return true;
}

TemporaryFolder::TemporaryFolder() {
    std::string pattern = std::filesystem::temp_directory_path() / "cmmlive-test-XXXXXX";
    if (::mkdtemp(pattern.data()) == nullptr) throw std::runtime_error("no temporary folder");
    path_ = pattern;
}

TemporaryFolder::~TemporaryFolder() {
    std::error_code ignored;
    if (!testing::Test::HasFailure()) std::filesystem::remove_all(path_, ignored);
}

std::string cmmlive() {
    const char* named = std::getenv("CMMLIVE");
    return named != nullptr ? named : CMMLIVE_EXECUTABLE;
}

std::string project_root() {
    return std::filesystem::current_path().string();
}

}  // namespace cmm::test
