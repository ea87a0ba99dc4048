// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace cmm::web {

/// A folder with a run file, and the name it has in the page: that of the folder.
struct RunFolder {
    std::string id, path;
    std::string run_file() const { return path + "/run.cmmrun"; }
};

/// The run folders that a server shows: those in `folder` (empty: none), and `live`, that of the running job (empty:
/// none). What a request names is looked up among these names and never made part of a path.
class RunFolders {
  public:
    RunFolders(std::string folder, const std::string& live);
    /// Another running job.
    void begin(const std::string& live);
    /// By name; read anew each time, at most 1000.
    std::vector<RunFolder> list() const;
    std::optional<RunFolder> find(const std::string& id) const;
    const std::optional<RunFolder>& live() const { return live_; }

  private:
    std::string folder_;
    std::optional<RunFolder> live_;
};

}  // namespace cmm::web
