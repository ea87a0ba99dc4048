// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <string_view>

#include "core/text.hpp"

namespace cmm::sim::test {

/// A file of its own in the temporary folder, gone with the object.
class TemporaryFile {
  public:
    explicit TemporaryFile(std::string_view content) {
        path_ = (std::filesystem::temp_directory_path() / "cmmlive-sim-XXXXXX").string();
        const int handle = ::mkstemp(path_.data());
        if (handle < 0) throw std::runtime_error("cannot make " + path_);
        ::close(handle);
        if (!core::write_file(path_, content)) throw std::runtime_error("cannot write " + path_);
    }
    ~TemporaryFile() { std::filesystem::remove(path_); }
    TemporaryFile(const TemporaryFile&) = delete;
    TemporaryFile& operator=(const TemporaryFile&) = delete;

    const std::string& path() const { return path_; }
    std::string content() const { return core::read_file(path_).value(); }

  private:
    std::string path_;
};

}  // namespace cmm::sim::test
