// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <unistd.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <span>
#include <string>

/// A file of this process alone, in memory where the system has a place for that; gone at the end, with what SQLite
/// puts beside it.
class WorkFile {
  public:
    explicit WorkFile(const std::string& ending) {
        const bool in_memory = std::filesystem::is_directory("/dev/shm");
        const std::filesystem::path folder = in_memory ? "/dev/shm" : std::filesystem::temp_directory_path();
        name_ = folder / ("cmmlive-fuzz-" + std::to_string(::getpid()) + ending);
    }
    ~WorkFile() {
        std::filesystem::remove(name_);
        remove_companions();
    }
    WorkFile(const WorkFile&) = delete;
    WorkFile& operator=(const WorkFile&) = delete;

    const std::string& name() const { return name_; }
    void remove_companions() const {
        for (const char* part : {"-wal", "-shm", "-journal"})
            std::filesystem::remove(name_ + part);
    }
    const std::string& holds(std::span<const std::uint8_t> content) const {
        std::ofstream(name_, std::ios::binary | std::ios::trunc)
            .write(static_cast<const char*>(static_cast<const void*>(content.data())),
                   static_cast<std::streamsize>(content.size()));
        return name_;
    }

  private:
    std::string name_;
};
