// SPDX-License-Identifier: Apache-2.0
#include "drivers/framed_machine.hpp"

namespace cmm::drivers {
namespace {

class FramedSource final : public PathSource {
  public:
    FramedSource(PathSource& inside, const core::MachineFromPart& frame) : inside_(inside), frame_(frame) {}
    std::size_t next(std::span<PathPoint> room, bool& last) override {
        const std::size_t count = inside_.next(room, last);
        for (auto& point : room.first(count)) {
            point.centre_mm = frame_(core::Position<core::PartFrame>{point.centre_mm}).mm;
            point.normal = frame_.rotate(point.normal);
        }
        return count;
    }

  private:
    PathSource& inside_;
    const core::MachineFromPart& frame_;
};

}  // namespace

void FramedMachine::set_frame(const core::MachineFromPart& machine_from_part) {
    machine_from_part_ = machine_from_part;
    part_from_machine_ = machine_from_part.inverse();
}

Eigen::Vector3d FramedMachine::to_part(const Eigen::Vector3d& machine_mm) const {
    return part_from_machine_(core::Position<core::MachineFrame>{machine_mm}).mm;
}

Eigen::Vector3d FramedMachine::to_machine(const Eigen::Vector3d& part_mm) const {
    return machine_from_part_(core::Position<core::PartFrame>{part_mm}).mm;
}

boost::asio::awaitable<core::Status> FramedMachine::move(Eigen::Vector3d centre_mm, double speed_mm_s) {
    return inside_.move(to_machine(centre_mm), speed_mm_s);
}

boost::asio::awaitable<core::Result<Eigen::Vector3d>> FramedMachine::touch(Eigen::Vector3d target_mm, double speed_mm_s,
                                                                           double retract_mm, SampleSink& sink) {
    auto contact = co_await inside_.touch(to_machine(target_mm), speed_mm_s, retract_mm, sink);
    if (contact) *contact = to_part(*contact);
    co_return contact;
}

boost::asio::awaitable<core::Result<ScanResult>> FramedMachine::scan(ScanPath path, PathSource& source,
                                                                     SampleSink& sink) {
    FramedSource framed(source, machine_from_part_);
    co_return co_await inside_.scan(path, framed, sink);
}

boost::asio::awaitable<core::Result<MachineStatus>> FramedMachine::state() {
    auto status = co_await inside_.state();
    if (status) status->position_mm = to_part(status->position_mm);
    co_return status;
}

}  // namespace cmm::drivers
