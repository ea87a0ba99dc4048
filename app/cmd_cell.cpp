// SPDX-License-Identifier: Apache-2.0
#include <cstdio>

#include "acquisition/json_text.hpp"
#include "app/cell_service.hpp"
#include "app/commands.hpp"
#include "app/console.hpp"
#include "app/stop_signals.hpp"

namespace cmm::app {

int run_cell(const CellSettings& options) {
    const core::SystemClock clock;
    CellService service(options, clock);
    if (const auto status = service.start(); !status) return report(status.error(), options.json);
    if (options.json) {
        std::printf("{%s}\n",
                    acquisition::JsonFields().add("plc", service.url()).add("page", service.page_url()).text().c_str());
    } else {
        for (const auto& [number, file] : service.programs())
            std::printf("program %u: %s\n", number, file.c_str());
        std::printf("plc: %s\n", service.url().c_str());
        if (!service.page_url().empty()) std::printf("page: %s\n", service.page_url().c_str());
    }
    std::fflush(stdout);
    const StopSignals signals([&] { service.end_orderly(); }, [&] { service.abort(); });
    service.serve();
    return 0;
}

}  // namespace cmm::app
