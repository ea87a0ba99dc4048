// SPDX-License-Identifier: Apache-2.0
#include "sim/line_protocol.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "core/units.hpp"

namespace cmm::sim {
namespace {

constexpr std::size_t longest_line = 4096;
constexpr std::size_t numbers_per_point = 8;
// Codes of a refusal.
constexpr const char* unknown_verb = "1";
constexpr const char* bad_value = "3";
constexpr const char* busy = "6";

// The place in this list is the opcode, as in the register map; 8 is STOP, which has a verb of its own.
constexpr std::array opcodes{"", "CLAIM", "RELEASE", "HOME", "QUALIFY", "MOVE", "TOUCH", "SCAN", "", "CLEAR", "PATH"};

/// All words as numbers of 32 bits, signed or not.
std::optional<std::vector<std::int64_t>> numbers_of(std::span<const std::string> words) {
    std::vector<std::int64_t> numbers;
    for (const std::string& word : words) {
        const auto number = line_number(word);
        if (!number || *number < -2147483648LL || *number > 4294967295LL) return std::nullopt;
        numbers.push_back(*number);
    }
    return numbers;
}

std::int64_t counts(double mm, const MachineSettings& machine) {
    return core::counts_from_mm(mm, machine.lsb_mm);
}

class Text {
  public:
    Text& add(std::int64_t value) { return add(std::to_string(value)); }
    Text& add(const std::string& word) {
        text_ += (text_.empty() ? "" : " ") + word;
        return *this;
    }
    Text& add(const Eigen::Vector3d& mm, const MachineSettings& machine) {
        for (int axis = 0; axis < 3; ++axis)
            add(counts(mm[axis], machine));
        return *this;
    }
    const std::string& text() const { return text_; }

  private:
    std::string text_;
};

}  // namespace

WireProtocol::Progress LineProtocol::answer(std::span<const std::uint8_t> in, core::Duration,
                                            std::vector<std::uint8_t>& out) {
    const auto end = std::find(in.begin(), in.end(), std::uint8_t{'\n'});
    if (end == in.end()) return {in.size() > longest_line ? in.size() : 0, true};
    std::string line(in.begin(), end);
    if (line.ends_with('\r')) line.pop_back();
    if (const auto command = read_line_command(line)) carry_out(*command, out);
    return {static_cast<std::size_t>(end - in.begin()) + 1, true};
}

void LineProtocol::carry_out(const LineCommand& command, std::vector<std::uint8_t>& out) {
    const std::uint8_t refusal = controller_.take_refusal();
    if (refusal == 0 && command.verb == "SA" && exchange(command, out)) return;
    const Outcome outcome = refusal != 0           ? Outcome{'!', std::to_string(refusal)}
                            : command.verb == "SA" ? Outcome{'!', bad_value}
                                                   : reply_to(command);
    const std::string reply = line_reply(outcome.mark, command.tag, outcome.text);
    out.insert(out.end(), reply.begin(), reply.end());
}

LineProtocol::Outcome LineProtocol::reply_to(const LineCommand& command) {
    if (command.verb == "ID") return {'=', identity()};
    if (command.verb == "ST") return {'=', status()};
    if (command.verb == "DO") return give_command(command);
    const auto numbers = numbers_of(command.arguments);
    if (command.verb == "PP") return numbers ? take_points(*numbers) : Outcome{'!', bad_value};
    if (command.verb != "STOP") return {'!', unknown_verb};
    if (!numbers || numbers->size() != 1 || (*numbers)[0] < 1 || (*numbers)[0] > 2) return {'!', bad_value};
    controller_.stop(static_cast<StopKind>((*numbers)[0]));
    return {};
}

LineProtocol::Outcome LineProtocol::give_command(const LineCommand& line) {
    const auto& words = line.arguments;
    if (words.size() < 3) return {'!', bad_value};
    const auto* const opcode = std::find(opcodes.begin() + 1, opcodes.end(), words[2]);
    if (opcode == opcodes.end()) return {'!', unknown_verb};
    const auto head = numbers_of(std::span(words).first(2));
    const auto args = numbers_of(std::span(words).subspan(3));
    Command command;
    if (!head || !args || args->size() > command.args.size() || (*head)[0] < 1 || (*head)[0] > 65535)
        return {'!', bad_value};
    command.seq = static_cast<std::uint16_t>((*head)[0]);
    command.owner = static_cast<std::uint32_t>((*head)[1]);
    command.opcode = static_cast<std::uint16_t>(opcode - opcodes.begin());
    for (std::size_t k = 0; k < args->size(); ++k)
        command.args[k] = static_cast<std::int32_t>((*args)[k]);
    controller_.command(command);
    return {};
}

LineProtocol::Outcome LineProtocol::take_points(const Numbers& numbers) {
    if (numbers.size() < 2 + numbers_per_point || (numbers.size() - 2) % numbers_per_point != 0)
        return {'!', bad_value};
    std::vector<PathPoint> points;
    for (std::size_t at = 2; at < numbers.size(); at += numbers_per_point) {
        const auto of = std::span(numbers).subspan(at, numbers_per_point);
        PathPoint point;
        for (int axis = 0; axis < 3; ++axis) {
            const auto k = static_cast<std::size_t>(axis);
            point.position[axis] = static_cast<double>(of[k]) * controller_.options().machine.lsb_mm;
            point.normal[axis] = static_cast<double>(of[3 + k]) / 32767.0;
        }
        point.speed_mm_s = static_cast<double>(of[6]) * 0.01;
        point.record = (of[7] & 1) != 0;
        point.last = (of[7] & 2) != 0;
        points.push_back(point);
    }
    if (points.size() > points_per_line || numbers[0] < 1 || numbers[0] > 65535) return {'!', bad_value};
    switch (controller_.append_path(static_cast<std::uint16_t>(numbers[0]), static_cast<std::uint32_t>(numbers[1]),
                                    points)) {
        case ScanPath::Append::invalid:
            return {'!', bad_value};
        case ScanPath::Append::full:
            return {'!', busy};
        default:
            return {'=', std::to_string(controller_.path().received())};
    }
}

bool LineProtocol::exchange(const LineCommand& command, std::vector<std::uint8_t>& out) {
    const auto numbers = numbers_of(command.arguments);
    if (!numbers || numbers->size() != 4 || std::any_of(numbers->begin(), numbers->end(), [](auto n) { return n < 0; }))
        return false;
    if (!controller_.acknowledge(static_cast<std::uint32_t>((*numbers)[1]))) return false;
    controller_.feed_watchdog(static_cast<std::uint16_t>((*numbers)[0]));
    const auto most = static_cast<std::size_t>((*numbers)[3]);
    const auto bytes = frame(command.tag, static_cast<std::uint32_t>((*numbers)[2]), std::min(most, most_samples));
    out.insert(out.end(), bytes.begin(), bytes.end());
    return true;
}

std::vector<std::uint8_t> LineProtocol::frame(std::uint16_t tag, std::uint32_t from, std::size_t most) const {
    const SampleFifo& fifo = controller_.fifo();
    const std::uint32_t first = std::clamp(from, fifo.acknowledged() + 1, fifo.newest() + 1);
    const bool some = fifo.holds(first);
    const std::uint16_t path = some ? fifo.at(first).path : controller_.path().id();
    std::uint32_t end = first;
    while (end - first < most && fifo.holds(end) && fifo.at(end).path == path)
        ++end;
    const std::int64_t time_us = some ? fifo.at(first).time_us : controller_.time_us();
    FrameWriter out;
    out.put('S', 1);
    out.put(tag, 2);
    out.put(controller_.options().boot_id, 2);
    out.put(static_cast<std::uint16_t>(controller_.state()), 1);
    out.put(controller_.sample_flags(path, end), 1);
    out.put(path, 2);
    out.put(first, 4);
    out.put(fifo.newest(), 4);
    out.put(static_cast<std::uint64_t>(time_us), 8);
    out.put(end - first, 2);
    std::array<LineRow, 4> rows;
    for (std::uint32_t seq = first; seq < end; ++seq) {
        const FifoSample& sample = fifo.at(seq);
        for (std::size_t axis = 0; axis < 3; ++axis)
            rows[axis].put(out, sample.counts[axis]);
        rows[3].put(out, sample.time_us - time_us);
        out.put_varint(sample.quality);
    }
    return out.finished();
}

std::string LineProtocol::identity() const {
    const ControllerOptions& options = controller_.options();
    const MachineSettings& machine = options.machine;
    Text out;
    out.add("CMM1").add(1).add(std::llround(machine.lsb_mm * 1e6)).add(machine.sample_rate_hz);
    out.add(static_cast<std::int64_t>(machine.fifo_depth)).add(static_cast<std::int64_t>(machine.path_capacity));
    out.add(points_per_line).add(machine.watchdog_ms).add(capability_bits).add(1);
    out.add(machine.limit_min_mm, machine).add(machine.limit_max_mm, machine);
    out.add(std::llround(core::um_from_mm(machine.max_speed_mm_s)));
    out.add(std::llround(core::um_from_mm(machine.max_accel_mm_s2)));
    out.add(options.boot_id).add("1.0").add(line_word(machine.model)).add(line_word(machine.serial));
    return out.text();
}

std::string LineProtocol::status() const {
    const Controller& controller = controller_;
    const CommandStatus& command = controller.command_status();
    const auto code = [](auto value) { return static_cast<std::int64_t>(value); };
    Text out;
    out.add(controller.options().boot_id).add(code(controller.state())).add(controller.heartbeat());
    out.add(controller.flags()).add(code(controller.fault())).add(command.seq).add(code(command.state));
    out.add(code(command.result));
    for (const std::int32_t value : command.values)
        out.add(value);
    out.add(controller.path().id()).add(controller.path_passed()).add(controller.path().received());
    out.add(controller.fifo().newest()).add(controller.fifo().acknowledged());
    out.add(controller.position_mm(), controller.options().machine);
    out.add(std::min<std::int64_t>(65535, static_cast<std::int64_t>(controller.fifo().level())));
    out.add(controller.time_us()).add(controller.owner());
    return out.text();
}

}  // namespace cmm::sim
