// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <filesystem>

#include "acquisition/json_text.hpp"
#include "app/commands.hpp"
#include "app/console.hpp"
#include "app/run_page.hpp"

namespace cmm::app {

int run_serve(const ServeOptions& options) {
    std::error_code ignored;
    if (!std::filesystem::is_directory(options.page.runs, ignored)) {
        return report({core::ErrorCode::input_missing,
                       options.page.runs + ": there is no such folder",
                       {},
                       core::Motion::not_concerned},
                      options.json);
    }
    const auto server = web::PageServer::start(page_options(options.page), {}, nullptr);
    if (!server) return report(server.error(), options.json);
    if (options.json) {
        std::printf("{%s}\n", acquisition::JsonFields().add("url", (*server)->url()).text().c_str());
    } else {
        std::printf("page: %s\n", (*server)->url().c_str());
    }
    std::fflush(stdout);
    wait_for_end();
    return 0;
}

}  // namespace cmm::app
