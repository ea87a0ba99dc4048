// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "app/judged_input.hpp"

/// One function a subcommand, each returns the exit code of the contract (docs/cli.md). main.cpp parses, these act.
namespace cmm::app {

/// Where a browser finds the page of a run, and who may do what there.
struct PageSettings {
    std::string listen;      ///< ADDRESS:PORT; empty: no page
    std::string token_file;  ///< empty: a new token each time
    std::string runs;        ///< folder whose runs are listed
    std::vector<std::string> hosts;
    bool stay = false;  ///< the page outlives the run, until Ctrl-C
    bool show = false;  ///< in the user's browser
};

struct DemoOptions {
    std::string out = "demo-out";
    std::string part;    ///< empty: config/parts/demo.toml
    double speed = 1.0;  ///< times real time; 0 = as fast as it goes
    std::uint64_t seed = 1;
    std::string events;    ///< file, "-" = standard output, empty = none
    double wait_s = -1.0;  ///< negative: as the part file says
    PageSettings page;
    bool browser = true;  ///< shows the page, where there is one
    bool json = false;
};
int run_demo(const DemoOptions& options);

struct SimOptions {
    std::string part, machine, map, log, faults;
    std::vector<std::string> listen;
    double speed = 1.0;
    std::uint64_t seed = 1;
    bool json = false;
};
int run_sim(const SimOptions& options);

struct ScanOptions {
    std::string machine, part, out, events;
    double wait_s = -1.0;  ///< negative: as the part file says
    PageSettings page;
    bool resume = false, touch = false, dry_run = false, json = false;
    bool stop_when_rejected = false;  ///< also where the part file does not ask for it
};
int run_scan(const ScanOptions& options);

struct ReplayOptions {
    std::string input;   ///< run file or output folder
    std::string out;     ///< empty: nothing is kept
    double speed = 0.0;  ///< times the recorded pace; 0 = as fast as it goes
    std::string events;
    bool json = false;
};
int run_replay(const ReplayOptions& options);

struct PlanOptions {
    std::string part, machine, out;
    bool touch = false, json = false;
};
int run_plan(const PlanOptions& options);

struct FitOptions {
    JudgedInput input;
    std::string out;
    bool json = false;
};
int run_fit(const FitOptions& options);

struct GateOptions {
    std::string input, gate;
    bool json = false;
};
int run_gate(const GateOptions& options);

struct ExportOptions {
    JudgedInput input;
    std::string format, out;
    bool surface = false;  ///< step: the surface alone, not a solid
    bool json = false;
};
int run_export(const ExportOptions& options);

struct StudyOptions {
    std::vector<std::string> inputs;  ///< run files or folders
    std::string design;               ///< file that says what was measured by whom; empty: as the runs say
    std::string part;                 ///< part file to judge them all by; empty: each by its own
    std::string format, out;          ///< empty: the table alone
    bool json = false;
};
int run_study(const StudyOptions& options);

struct ServeOptions {
    PageSettings page;
    bool json = false;
};
int run_serve(const ServeOptions& options);

struct CellSettings {
    std::string machine, parts, runs;
    std::string plc = "modbus+tcp://127.0.0.1:5020";
    std::vector<std::string> allow;  ///< addresses and networks that may connect there
    double watchdog_ms = 2000.0;
    double wait_s = -1.0;  ///< negative: as the part files say
    PageSettings page;
    std::string mqtt, mqtt_login;  ///< broker, and a file with user and password; empty: none
    bool stop_when_rejected = false, json = false;
};
int run_cell(const CellSettings& options);

struct DevicesOptions {
    std::vector<std::string> devices;  ///< besides those that are found
    bool json = false;
};
int run_devices(const DevicesOptions& options);

struct DoctorOptions {
    std::string machine;
    bool json = false;
};
int run_doctor(const DoctorOptions& options);

struct ConfigOptions {
    std::string action, file;  ///< check, show, explain
    bool json = false;
};
int run_config(const ConfigOptions& options);

}  // namespace cmm::app
