// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <chrono>
#include <functional>
#include <string>
#include <vector>

/// Programs as a user starts them, for tests over the real wire. No sleeping: everything waits for a predicate with a
/// deadline.
namespace cmm::test {

struct Finished {
    int exit_code = -1;  ///< 128 + signal when it was killed
    std::string out, err;
};

/// A running program; killed when it goes out of scope.
class Process {
  public:
    /// Standard output and error go to files `log_stem`.out and .err.
    Process(const std::vector<std::string>& arguments, const std::string& log_stem);
    ~Process();
    Process(const Process&) = delete;
    Process& operator=(const Process&) = delete;

    void signal(int number) const;
    /// Waits for the end; kills it at the deadline (exit code then 128 + SIGKILL).
    Finished wait(std::chrono::seconds deadline);
    bool running();
    std::string out() const;
    std::string err() const;
    pid_t pid() const { return pid_; }

  private:
    pid_t pid_ = -1;
    int status_ = 0;
    bool ended_ = false;
    std::string log_stem_;
};

Finished run(const std::vector<std::string>& arguments, std::chrono::seconds deadline = std::chrono::seconds(120));

/// Calls `predicate` until it holds (true) or the deadline passes (false).
bool wait_for(const std::function<bool()>& predicate, std::chrono::milliseconds deadline = std::chrono::seconds(20));

/// A fresh folder under the system's temporary folder, removed at the end unless the test failed.
class TemporaryFolder {
  public:
    TemporaryFolder();
    ~TemporaryFolder();
    TemporaryFolder(const TemporaryFolder&) = delete;
    TemporaryFolder& operator=(const TemporaryFolder&) = delete;
    std::string operator/(const std::string& name) const { return path_ + "/" + name; }
    const std::string& path() const { return path_; }

  private:
    std::string path_;
};

/// The cmmlive executable under test.
std::string cmmlive();
/// The project's root folder (tests run there).
std::string project_root();

}  // namespace cmm::test
