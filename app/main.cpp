// SPDX-License-Identifier: Apache-2.0
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <exception>
#include <functional>
#include <string_view>

#include "app/commands.hpp"
#include "app/console.hpp"
#include "core/memory.hpp"

namespace {

using Action = std::function<int()>;

/// Declares every subcommand; the chosen one's action is left in `action`.
class CommandLine {
  public:
    explicit CommandLine(Action& action) : action_(action) {
        app_.set_version_flag("--version", "cmmlive " + cmm::app::version());
        app_.require_subcommand(1);
        app_.add_flag("--json", json_, json_words);
        app_.footer(
            "Exit codes: 0 accepted or done, 1 rejected, 2 undecided, 3 usage or input, 4 machine, 5 link, 6 storage, "
            "70 internal.\nDocumentation: docs/cli.md");
        add_demo();
        add_sim();
        add_scan();
        add_replay();
        add_plan();
        add_fit();
        add_gate();
        add_export();
        add_study();
        add_serve();
        add_cell();
        add_devices();
        add_doctor();
        add_config();
    }

    CLI::App& app() { return app_; }

  private:
    template <class Options>
    CLI::App* add(const char* name, const char* text, Options& options, int (*run)(const Options&)) {
        CLI::App* command = app_.add_subcommand(name, text);
        command->add_flag("--json", options.json, json_words);
        command->final_callback([this, &options, run] {
            options.json |= json_;
            action_ = [&options, run] { return run(options); };
        });
        return command;
    }

    static void add_judged_input(CLI::App& command, cmm::app::JudgedInput& input) {
        command
            .add_option("input", input.inputs,
                        "a run file (.cmmrun) or an output folder, or point files (.csv .xyz .asc .txt .crv .curve)")
            ->required();
        command
            .add_option("--stylus-radius", input.stylus_radius_mm,
                        "of the ball that recorded points are centres of, in mm; 0: they lie on the part")
            ->check(CLI::NonNegativeNumber);
        command.add_option("--part", input.part, "part file: nominal, stylus and gate (default: the run's)");
        command.add_option("--reject", input.rejected, "points to leave out: sequence numbers, 12,15-18");
        command.add_option("--restore", input.restored,
                           "points to use whatever their neighbours say: sequence numbers");
    }

    static void add_wait(CLI::App& command, double& wait_s) {
        command
            .add_option("--wait-s", wait_s,
                        "how long to wait at rest while a door is open, the temperature out of range or the disk full; "
                        "0 = end at once (default: [scan] wait_s of the part file)")
            ->check(CLI::NonNegativeNumber);
    }

    static void add_page(CLI::App& command, cmm::app::PageSettings& page) {
        command.add_option("--token-file", page.token_file,
                           "the token that changes need (default: a new one each time)");
        command.add_option("--allow-host", page.hosts,
                           "a name by which browsers may ask, beside addresses and localhost");
    }

    static void add_serve_option(CLI::App& command, cmm::app::PageSettings& page, const std::string& what) {
        command
            .add_option_function<std::string>(
                "--serve",
                [&page](const std::string& listen) { page.listen = listen.empty() ? default_listen : listen; },
                what + "; ADDRESS:PORT (" + default_listen + " unless given)")
            ->expected(0, 1)
            ->type_name("[ADDRESS:PORT]");
    }

    /// For commands that run a job.
    static void add_job_page(CLI::App& command, cmm::app::PageSettings& page) {
        add_serve_option(command, page, "serve the page of this run");
        command.add_option("--runs", page.runs, "the page lists the runs in this folder as well");
        command.add_flag("--stay", page.stay, "with --serve: the page stays after the run, until Ctrl-C");
        add_page(command, page);
    }

    void add_serve() {
        auto* c = add("serve", "show runs in a browser", serve_, cmm::app::run_serve);
        serve_.page.listen = default_listen;
        serve_.page.runs = ".";
        c->add_option("--runs", serve_.page.runs, "folder with the folders of the runs")->capture_default_str();
        c->add_option("--listen", serve_.page.listen, "ADDRESS:PORT; port 0: a free one")->capture_default_str();
        add_page(*c, serve_.page);
    }

    void add_demo() {
        auto* c = add("demo", "scan a blade on an embedded simulated machine and judge it", demo_, cmm::app::run_demo);
        c->add_option("--out", demo_.out, "folder for the results")->capture_default_str();
        c->add_option("--part", demo_.part, "part file (default: the demo blade)");
        c->add_option("--speed", demo_.speed, "times real time; 0 = as fast as it goes")
            ->check(CLI::NonNegativeNumber)
            ->capture_default_str();
        c->add_option("--seed", demo_.seed, "of noise and bad points")->capture_default_str();
        c->add_option("--events", demo_.events, "write the event stream as NDJSON to this file, - for standard output");
        add_wait(*c, demo_.wait_s);
        add_job_page(*c, demo_.page);
        c->add_flag("!--no-browser", demo_.browser, "do not open the page in a browser");
    }

    void add_sim() {
        auto* c = add("sim", "be a CMM controller: a process of its own that any Modbus client can drive", sim_,
                      cmm::app::run_sim);
        c->add_option("--part", sim_.part, "what lies on the machine")->required();
        c->add_option("--machine", sim_.machine, "limits, speeds, sample clock (default: config/machines/sim.toml)");
        c->add_option("--map", sim_.map, "register map (default: config/maps/cmm-v1.toml)");
        c->add_option("--listen", sim_.listen,
                      "modbus+tcp://127.0.0.1:1502 (port 0: a free one), modbus+rtu:///dev/ttyS0 or "
                      "line+serial:///dev/ttyS0, several times")
            ->required();
        c->add_option("--speed", sim_.speed, "times real time; 0 = as fast as it goes")
            ->check(CLI::NonNegativeNumber)
            ->capture_default_str();
        c->add_option("--seed", sim_.seed, "of noise and bad points")->capture_default_str();
        c->add_option("--faults", sim_.faults, "fault plan: what breaks, and when (config/faults/)");
        c->add_option("--log", sim_.log, "the simulator's own record of every sample, with the truth, as CSV");
    }

    void add_scan() {
        auto* c = add("scan", "scan a part on a machine and judge it", scan_, cmm::app::run_scan);
        c->add_option("--machine", scan_.machine,
                      "machine file or URL, e.g. modbus+tcp://host:502, dro+serial:///dev/ttyUSB0, replay:run.cmmrun")
            ->required();
        c->add_option("--part", scan_.part, "part file")->required();
        c->add_option("--out", scan_.out, "folder for the run file and the results");
        c->add_flag("--resume", scan_.resume, "go on with the run in --out");
        c->add_flag("--touch", scan_.touch, "measure by single touches, also where the machine could scan");
        c->add_flag("--dry-run", scan_.dry_run, "plan and check, move nothing");
        c->add_option("--events", scan_.events, "write the event stream as NDJSON to this file, - for standard output");
        c->add_flag("--stop-when-rejected", scan_.stop_when_rejected,
                    "end the run as soon as the verdict is certain to be reject");
        add_wait(*c, scan_.wait_s);
        add_job_page(*c, scan_.page);
    }

    void add_replay() {
        auto* c =
            add("replay", "play a recorded run again, its run file as the machine", replay_, cmm::app::run_replay);
        c->add_option("run", replay_.input, "run file or output folder")->required();
        c->add_option("--speed", replay_.speed, "times the recorded pace, a whole number; 0 = as fast as it goes")
            ->check(CLI::NonNegativeNumber)
            ->capture_default_str();
        c->add_option("--out", replay_.out, "folder for the results (default: none are kept)");
        c->add_option("--events", replay_.events,
                      "write the event stream as NDJSON to this file, - for standard output");
    }

    void add_plan() {
        auto* c = add("plan", "plan the paths, check them, say what would happen", plan_, cmm::app::run_plan);
        c->add_option("--part", plan_.part, "part file")->required();
        c->add_option("--machine", plan_.machine, "machine file: its limits are checked as well");
        c->add_flag("--touch", plan_.touch, "for single touches, as scan --touch");
        c->add_option("--out", plan_.out, "write the plan to this file");
    }

    void add_fit() {
        auto* c = add("fit", "fit recorded points or a run file, the same way as a scan", fit_, cmm::app::run_fit);
        add_judged_input(*c, fit_.input);
        c->add_option("--out", fit_.out, "folder for the results")->required();
    }

    void add_gate() {
        auto* c = add("gate", "judge a finished run again", gate_, cmm::app::run_gate);
        c->add_option("run", gate_.input, "run file or output folder")->required();
        c->add_option("--gate", gate_.gate, "file with a [gate] table (a part file will do)")->required();
    }

    void add_export() {
        auto* c = add("export", "write the results of a run or of recorded points in another form", export_,
                      cmm::app::run_export);
        add_judged_input(*c, export_.input);
        c->add_option(
             "--format", export_.format,
             "csv (a folder), json, html, pdf, qif, dfq (Q-DAS), dmis, svg, png (the map of deviations), step, stl")
            ->required()
            ->check(CLI::IsMember({"csv", "json", "html", "pdf", "qif", "dfq", "dmis", "svg", "png", "step", "stl"}));
        c->add_flag("--surface", export_.surface,
                    "step: the surface alone, not the solid; with holes where it was not measured");
        c->add_option("--out", export_.out, "file or, for csv, folder")->required();
    }

    void add_study() {
        auto* c = add("study", "repeatability and reproducibility over runs of the same part program", study_,
                      cmm::app::run_study);
        c->add_option("runs", study_.inputs, "run files or output folders");
        c->add_option("--design", study_.design,
                      "CSV with the columns run, part and appraiser: which runs, and what was measured by whom "
                      "(default: serial number and machine of each run)");
        c->add_option("--part", study_.part, "judge all runs by this part file (default: each by its own)");
        c->add_option("--format", study_.format, "write the study as json, csv or html as well")
            ->check(CLI::IsMember({"json", "csv", "html"}));
        c->add_option("--out", study_.out, "file for it");
    }

    void add_cell() {
        auto* c = add("cell", "measure part after part for a PLC (docs/cell.md)", cell_, cmm::app::run_cell);
        c->add_option("--machine", cell_.machine, "machine file or URL")->required();
        c->add_option("--parts", cell_.parts, "folder of part files whose names begin with a program number")
            ->required();
        c->add_option("--runs", cell_.runs, "folder for the runs, one folder each, and for what survives a restart")
            ->required();
        c->add_option("--plc", cell_.plc, "where the PLC finds its registers; port 0: a free one")
            ->capture_default_str();
        c->add_option("--plc-allow", cell_.allow,
                      "an address or network that may connect there (default: this machine alone), several times");
        c->add_option("--plc-watchdog-ms", cell_.watchdog_ms,
                      "a PLC whose heartbeat stands still for longer is gone, and the machine is stopped")
            ->check(CLI::Range(100.0, 60000.0))
            ->capture_default_str();
        c->add_flag("--stop-when-rejected", cell_.stop_when_rejected,
                    "end a run as soon as its verdict is certain to be reject");
        add_wait(*c, cell_.wait_s);
        c->add_option("--mqtt", cell_.mqtt, "tell a broker as well: mqtt://HOST[:1883][/PREFIX]");
        c->add_option("--mqtt-login", cell_.mqtt_login, "file with user and password for it, a line each");
        add_serve_option(*c, cell_.page, "serve the page of the runs, /api and /metrics");
        add_page(*c, cell_.page);
    }

    void add_devices() {
        auto* c =
            add("devices", "list the serial ports: what they are, and who holds them", devices_, cmm::app::run_devices);
        c->add_option("device", devices_.devices, "show this device as well, e.g. a pseudo-terminal");
    }

    void add_doctor() {
        auto* c = add("doctor", "check this installation and, with --machine, the link to a machine", doctor_,
                      cmm::app::run_doctor);
        c->add_option("--machine", doctor_.machine, "machine file or URL");
    }

    void add_config() {
        auto* c = add("config", "check a configuration file, show it resolved, or explain the keys", config_,
                      cmm::app::run_config);
        c->add_option("action", config_.action, "check, show or explain")
            ->required()
            ->check(CLI::IsMember({"check", "show", "explain"}));
        c->add_option("file", config_.file, "part or machine file");
    }

    static constexpr const char* default_listen = "127.0.0.1:8686";
    static constexpr const char* json_words = "one JSON document on standard output, everything else on standard error";
    CLI::App app_{"cmmlive: drives a coordinate measuring machine and judges the part while it is measured", "cmmlive"};
    Action& action_;
    bool json_ = false;  // before the command
    cmm::app::DemoOptions demo_;
    cmm::app::SimOptions sim_;
    cmm::app::ScanOptions scan_;
    cmm::app::ReplayOptions replay_;
    cmm::app::PlanOptions plan_;
    cmm::app::FitOptions fit_;
    cmm::app::GateOptions gate_;
    cmm::app::ExportOptions export_;
    cmm::app::StudyOptions study_;
    cmm::app::ServeOptions serve_;
    cmm::app::CellSettings cell_;
    cmm::app::DevicesOptions devices_;
    cmm::app::DoctorOptions doctor_;
    cmm::app::ConfigOptions config_;
};

bool processor_suffices() {
#ifdef __AVX2__
    return __builtin_cpu_supports("avx2") != 0 && __builtin_cpu_supports("fma") != 0;
#else
    return true;
#endif
}

}  // namespace

int main(int argc, char** argv) {
    if (!processor_suffices()) {
        std::fputs(
            "cmmlive: built for processors with AVX2 and FMA, which this one has not; build it here, or with "
            "-DCMMLIVE_CPU=baseline\n",
            stderr);
        return 70;
    }
    (void)cmm::core::keep_freed_memory();
    try {
        Action action;
        CommandLine line(action);
        try {
            line.app().parse(argc, argv);
        } catch (const CLI::ParseError& error) {
            if (error.get_exit_code() == 0) return line.app().exit(error);  // help, version
            const bool json = std::find(argv, argv + argc, std::string_view("--json")) != argv + argc;
            return cmm::app::report({cmm::core::ErrorCode::usage, error.what(), {}, cmm::core::Motion::not_concerned},
                                    json);
        }
        return action();
    } catch (const std::exception& error) {
        return cmm::app::report({cmm::core::ErrorCode::internal, error.what(), {}, cmm::core::Motion::unknown}, false);
    }
}
