// SPDX-License-Identifier: Apache-2.0
#include "app/commands.hpp"
#include "app/console.hpp"
#include "app/scan_runner.hpp"

namespace cmm::app {

int run_scan(const ScanOptions& options) {
    if (options.dry_run) return run_plan({options.part, options.machine, "", options.touch, options.json});
    if (options.out.empty()) {
        return report({core::ErrorCode::usage, "scan needs --out DIR (or --dry-run)", {}, core::Motion::not_concerned},
                      options.json);
    }
    RunnerOptions runner;
    runner.machine = options.machine;
    runner.part = options.part;
    runner.out = options.out;
    runner.events = options.events;
    runner.wait_s = options.wait_s;
    runner.page = options.page;
    runner.resume = options.resume;
    runner.touch = options.touch;
    runner.stop_when_rejected = options.stop_when_rejected;
    runner.json = options.json;
    return run_main_job(runner);
}

}  // namespace cmm::app
