// SPDX-License-Identifier: Apache-2.0
#include "bench/link_rig.hpp"

#include <unistd.h>

#include <cmath>

#include "tests/support/prism_part.hpp"

namespace cmm::bench {
namespace {

using test::PrismPart;

constexpr double centre_radius_mm = PrismPart::radius_mm + PrismPart::ball_radius_mm;
constexpr double path_height_mm = PrismPart::height_mm / 2.0;
constexpr double pitch_mm = 0.1;
constexpr double scan_speed_mm_s = 50.0;
constexpr double travel_speed_mm_s = 200.0;

}  // namespace

std::vector<drivers::PathPoint> ring(std::size_t count, double start_rad) {
    std::vector<drivers::PathPoint> points(count);
    for (std::size_t k = 0; k < count; ++k) {
        const double angle = start_rad + static_cast<double>(k) * pitch_mm / centre_radius_mm;
        points[k].normal = {std::cos(angle), std::sin(angle), 0.0};
        points[k].centre_mm = centre_radius_mm * points[k].normal + Eigen::Vector3d(0.0, 0.0, path_height_mm);
        points[k].speed_mm_s = scan_speed_mm_s;
    }
    return points;
}

LinkSimulator::LinkSimulator(const std::string& config_folder, const std::vector<sim::Listen>& listen,
                             std::function<void()> on_stop)
    : folder_(std::filesystem::temp_directory_path() / ("cmmlive-bench-link-" + std::to_string(::getpid()))) {
    std::filesystem::create_directories(folder_);
    sim::SimulatorOptions options;
    options.part_file = PrismPart(folder_).file();
    options.machine_file = config_folder + "/machines/sim.toml";
    options.map_file = config_folder + "/maps/cmm-v1.toml";
    options.listen = listen;
    options.speed = 0.0;
    options.on_stop = std::move(on_stop);
    auto started = sim::Simulator::start(options);
    if (!started) throw std::runtime_error(started.error().text());
    simulator_ = std::move(*started);
}

LinkSimulator::~LinkSimulator() {
    simulator_.reset();
    std::filesystem::remove_all(folder_);
}

sim::Listen on_serial(sim::Listen::Kind kind, const std::string& port) {
    sim::Listen listen;
    listen.kind = kind;
    listen.line.path = port;
    return listen;
}

core::Status CountingSink::on_samples(std::span<const core::Sample> samples) {
    ended = SteadyClock::now();
    count += samples.size();
    last = samples.back().sequence;
    if (begun == SteadyClock::time_point{}) {
        begun = ended;
        first_count = count;
        if (first) first();
    }
    if (every) every();
    if (give_up != 0 && count >= give_up) return core::fail(core::ErrorCode::journal_full, "enough");
    return {};
}

double CountingSink::rate() const {
    return static_cast<double>(count - first_count) / seconds();
}

LinkHost::LinkHost(const std::string& url, std::uint64_t seed) {
    const auto settings = drivers::link_settings_from(url);
    if (!settings) throw std::runtime_error(settings.error().text());
    auto made = drivers::standard_registry().make(*settings, {io_.get_executor(), clock_, seed});
    if (!made) throw std::runtime_error(made.error().text());
    machine_ = std::move(*made);
}

void LinkHost::must(boost::asio::awaitable<core::Status> work) {
    const auto status = run(std::move(work));
    if (!status) throw std::runtime_error(status.error().text());
}

void LinkHost::bring_up() {
    must(machine_->connect());
    must(machine_->begin_run(std::nullopt));
    must(machine_->home());
    must(machine_->qualify(PrismPart::ball_radius_mm));
    must(machine_->move({2.0 * PrismPart::radius_mm, 0.0, 60.0}, travel_speed_mm_s));
    must(machine_->move({2.0 * PrismPart::radius_mm, 0.0, path_height_mm}, travel_speed_mm_s));
}

core::Result<drivers::ScanResult> LinkHost::scan(const std::vector<drivers::PathPoint>& path,
                                                 drivers::SampleSink& sink) {
    drivers::PointList source(path);
    return run(machine_->scan(drivers::ScanPath{}, source, sink));
}

}  // namespace cmm::bench
