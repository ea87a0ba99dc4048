// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace cmm::app {

/// Whether a person sits before this terminal who has a browser: output goes to a terminal, there is a display and
/// xdg-open, and no CI runs this.
bool browser_at_hand();

/// An address shown in the user's browser. The address may hold a secret, and whoever is on this machine can read the
/// arguments of programs: therefore a file of the user's own in `folder` leads there, and is removed with this object.
class ShownPage {
  public:
    /// Nothing happens where the file cannot be written or no browser be started.
    ShownPage(const std::string& url, const std::string& folder);
    ~ShownPage();
    ShownPage(const ShownPage&) = delete;
    ShownPage& operator=(const ShownPage&) = delete;

  private:
    std::string file_;
};

}  // namespace cmm::app
