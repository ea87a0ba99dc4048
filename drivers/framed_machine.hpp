// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/frame.hpp"
#include "drivers/machine.hpp"

namespace cmm::drivers {

/// A machine whose commands and positions are those of a part that stands on it: places and normals go part to machine
/// on the way down, contacts and positions machine to part on the way up. Samples pass as they are, in counts of the
/// machine, so that what is kept of a run is raw; who needs their places in the part asks part_from_machine().
/// Capabilities (limits of the travel) stay the machine's. Threads and lifetime as of Machine; the one inside outlives
/// this; set_frame on its executor, between motions.
class FramedMachine final : public Machine {
  public:
    explicit FramedMachine(Machine& inside) : inside_(inside) {}

    /// Identity until it is set.
    void set_frame(const core::MachineFromPart& machine_from_part);
    const core::MachineFromPart& machine_from_part() const { return machine_from_part_; }
    const core::PartFromMachine& part_from_machine() const { return part_from_machine_; }

    boost::asio::awaitable<core::Result<Capabilities>> connect() override { return inside_.connect(); }
    boost::asio::awaitable<core::Result<RunOrigin>> begin_run(std::optional<RunOrigin> resume) override {
        return inside_.begin_run(resume);
    }
    boost::asio::awaitable<core::Status> end_run() override { return inside_.end_run(); }
    boost::asio::awaitable<core::Status> home() override { return inside_.home(); }
    boost::asio::awaitable<core::Status> qualify(double ball_radius_mm) override {
        return inside_.qualify(ball_radius_mm);
    }
    boost::asio::awaitable<core::Status> move(Eigen::Vector3d centre_mm, double speed_mm_s) override;
    boost::asio::awaitable<core::Result<Eigen::Vector3d>> touch(Eigen::Vector3d target_mm, double speed_mm_s,
                                                                double retract_mm, SampleSink& sink) override;
    boost::asio::awaitable<core::Result<ScanResult>> scan(ScanPath path, PathSource& source, SampleSink& sink) override;
    boost::asio::awaitable<core::Result<ScanResult>> receive(ScanPath path, HandSink& sink) override {
        return inside_.receive(path, sink);
    }
    void tell(HandSignal signal) noexcept override { inside_.tell(signal); }
    boost::asio::awaitable<core::Result<std::uint64_t>> drain(SampleSink& sink) override { return inside_.drain(sink); }
    boost::asio::awaitable<core::Result<MachineStatus>> state() override;
    boost::asio::awaitable<core::Status> clear_fault(bool emergency_released = false) override {
        return inside_.clear_fault(emergency_released);
    }
    void stop(StopKind kind) noexcept override { inside_.stop(kind); }
    LinkStats link_stats() const override { return inside_.link_stats(); }
    void set_trace(std::function<void(std::string_view)> line) override { inside_.set_trace(std::move(line)); }

  private:
    Eigen::Vector3d to_part(const Eigen::Vector3d& machine_mm) const;
    Eigen::Vector3d to_machine(const Eigen::Vector3d& part_mm) const;

    Machine& inside_;
    core::MachineFromPart machine_from_part_;
    core::PartFromMachine part_from_machine_;
};

}  // namespace cmm::drivers
