// SPDX-License-Identifier: Apache-2.0
#include "drivers/line/line_messages.hpp"

#include <charconv>
#include <cmath>
#include <limits>
#include <optional>

#include "core/text.hpp"
#include "core/units.hpp"

namespace cmm::drivers::line {
namespace {

constexpr double normal_scale = 32767.0;
constexpr double speed_step_mm_s = 0.01;
constexpr std::size_t most_samples = 1024;  // of one frame, by its longest length

core::Error invalid(const std::string& what) {
    return core::Error{core::ErrorCode::protocol_invalid, what, {}, core::Motion::not_concerned};
}

/// The words of an answer, read one by one. The first that is missing or does not fit makes it bad for good.
class Words {
  public:
    explicit Words(std::string_view text) : text_(text) {}
    std::string_view next() {
        if (text_.empty()) good_ = false;
        const std::string_view word = text_.substr(0, text_.find(' '));
        text_.remove_prefix(std::min(text_.size(), word.size() + 1));
        return word;
    }
    template <class Integer>
    Integer number() {
        const std::string_view word = next();
        Integer value = 0;
        const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
        if (word.empty() || error != std::errc{} || end != word.data() + word.size()) good_ = false;
        return value;
    }
    bool good() const { return good_; }
    bool at_end() const { return text_.empty(); }

  private:
    std::string_view text_;
    bool good_ = true;
};

/// %XX stands for a byte that the text cannot hold.
std::string unescaped(std::string_view word) {
    std::string text;
    for (std::size_t k = 0; k < word.size(); ++k) {
        unsigned byte = 0;
        if (word[k] == '%' && k + 2 < word.size() + 0 &&
            std::from_chars(word.data() + k + 1, word.data() + k + 3, byte, 16).ptr == word.data() + k + 3) {
            text.push_back(static_cast<char>(byte));
            k += 2;
        } else {
            text.push_back(word[k]);
        }
    }
    return text;
}

/// Takes numbers off the front of a payload, low byte first.
class Bytes {
  public:
    explicit Bytes(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}
    template <class Integer>
    Integer number() {
        std::uint64_t value = 0;
        if (bytes_.size() < sizeof(Integer)) {
            good_ = false;
            return 0;
        }
        for (std::size_t k = 0; k < sizeof(Integer); ++k)
            value |= std::uint64_t{bytes_[k]} << (8 * k);
        bytes_ = bytes_.subspan(sizeof(Integer));
        return static_cast<Integer>(value);
    }
    /// Seven bits a byte, low ones first, the highest bit says that more follow.
    std::uint64_t varint() {
        std::uint64_t value = 0;
        for (unsigned shift = 0; shift < 63; shift += 7) {
            const auto byte = number<std::uint8_t>();
            value |= std::uint64_t{byte & 0x7FU} << shift;
            if (!good_ || (byte & 0x80U) == 0) return value;
        }
        good_ = false;
        return 0;
    }
    bool good() const { return good_; }
    bool at_end() const { return bytes_.empty(); }

  private:
    std::span<const std::uint8_t> bytes_;
    bool good_ = true;
};

/// A row of numbers given by how far each lies from the straight line through the two before it.
class Row {
  public:
    std::optional<std::int64_t> next(Bytes& bytes) {
        const std::uint64_t zigzag = bytes.varint();
        const auto off = static_cast<std::int64_t>(zigzag >> 1U) ^ -static_cast<std::int64_t>(zigzag & 1U);
        constexpr std::int64_t reach = std::int64_t{1} << 40;
        const std::int64_t expected = count_ == 0 ? 0 : count_ == 1 ? last_ : 2 * last_ - before_;
        if (!bytes.good() || off > reach || off < -reach) return std::nullopt;
        const std::int64_t value = expected + off;
        if (value > reach || value < -reach) return std::nullopt;
        before_ = last_;
        last_ = value;
        ++count_;
        return value;
    }

  private:
    std::int64_t last_ = 0, before_ = 0;
    std::size_t count_ = 0;
};

std::optional<std::int32_t> as_count(const std::optional<std::int64_t>& value) {
    using Limits = std::numeric_limits<std::int32_t>;
    if (!value || *value < Limits::min() || *value > Limits::max()) return std::nullopt;
    return static_cast<std::int32_t>(*value);
}

std::string_view name_of(controller::Opcode opcode) {
    using controller::Opcode;
    switch (opcode) {
        case Opcode::claim:
            return "CLAIM";
        case Opcode::release:
            return "RELEASE";
        case Opcode::home:
            return "HOME";
        case Opcode::qualify:
            return "QUALIFY";
        case Opcode::move:
            return "MOVE";
        case Opcode::touch:
            return "TOUCH";
        case Opcode::scan:
            return "SCAN";
        case Opcode::clear_fault:
            return "CLEAR";
        case Opcode::path_begin:
            return "PATH";
    }
    return "";
}

core::Status check_identity(const Capabilities& found) {
    if (!(found.lsb_mm > 0.0)) return tl::unexpected(invalid("the identity says that a count is 0 nm"));
    if (!(found.sample_rate_hz > 0.0))
        return tl::unexpected(invalid("the identity says that the sample clock is 0 Hz"));
    if (found.path_window == 0) return tl::unexpected(invalid("the identity says that a line holds no path point"));
    if (!((found.limit_max_mm - found.limit_min_mm).minCoeff() > 0.0))
        return tl::unexpected(invalid("the identity says that the travel limits are empty"));
    return {};
}

}  // namespace

core::Result<Capabilities> decode_identity(std::string_view text) {
    Words words(text);
    if (words.next() != "CMM1" || words.number<int>() != 1) {
        return core::fail(core::ErrorCode::protocol_mismatch,
                          "the device that answers is no measuring machine of line protocol 1");
    }
    Capabilities found;
    found.lsb_mm = words.number<std::uint32_t>() * 1e-6;
    found.sample_rate_hz = words.number<std::uint32_t>();
    found.fifo_depth = words.number<std::uint32_t>();
    found.path_capacity = words.number<std::uint32_t>();
    found.path_window = words.number<std::uint16_t>();
    found.watchdog_ms = words.number<std::uint32_t>();
    const auto bits = words.number<unsigned>();
    found.scans_paths = (bits & 1U) != 0;
    found.touches = (bits & 2U) != 0;
    found.gives_deflection = (bits & 4U) != 0;
    found.appends_paths = (bits & 8U) != 0;
    found.deflection_lsb_mm = core::mm_from_um(words.number<std::uint32_t>());
    for (Eigen::Vector3d* limit : {&found.limit_min_mm, &found.limit_max_mm})
        for (Eigen::Index axis = 0; axis < 3; ++axis)
            (*limit)[axis] = words.number<std::int32_t>() * found.lsb_mm;
    found.max_speed_mm_s = core::mm_from_um(words.number<std::uint32_t>());
    found.max_acceleration_mm_s2 = core::mm_from_um(words.number<std::uint32_t>());
    found.boot_id = words.number<std::uint16_t>();
    found.firmware = unescaped(words.next());
    found.model = unescaped(words.next());
    found.serial = unescaped(words.next());
    if (!words.good() || !words.at_end()) return tl::unexpected(invalid("the identity is not as the protocol has it"));
    if (auto sane = check_identity(found); !sane) return tl::unexpected(sane.error());
    return found;
}

core::Result<Status> decode_status(std::string_view text) {
    Words words(text);
    Status status;
    controller::StatusBlock& block = status.block;
    status.boot_id = words.number<std::uint16_t>();
    for (std::uint16_t* value : {&block.state, &block.heartbeat, &block.flags, &block.fault, &block.command_sequence,
                                 &block.command_state, &block.result})
        *value = words.number<std::uint16_t>();
    for (std::int32_t& value : block.values)
        value = words.number<std::int32_t>();
    block.path = words.number<std::uint16_t>();
    for (std::uint32_t* value : {&block.path_passed, &block.path_received, &block.newest, &block.acknowledged})
        *value = words.number<std::uint32_t>();
    for (std::int32_t& value : block.position)
        value = words.number<std::int32_t>();
    block.fifo_level = words.number<std::uint16_t>();
    block.time_us = words.number<std::int64_t>();
    block.owner = words.number<std::uint32_t>();
    const bool known = block.state <= static_cast<std::uint16_t>(MachineState::qualifying);
    if (!words.good() || !words.at_end() || !known)
        return tl::unexpected(invalid("the status is not as the protocol has it"));
    return status;
}

core::Result<Samples> decode_samples(std::span<const std::uint8_t> payload) {
    Bytes bytes(payload);
    Samples out;
    controller::FifoBlock& block = out.block;
    bytes.number<std::uint8_t>();   // kind
    bytes.number<std::uint16_t>();  // tag
    out.boot_id = bytes.number<std::uint16_t>();
    block.state = bytes.number<std::uint8_t>();
    block.flags = bytes.number<std::uint8_t>();
    block.path = bytes.number<std::uint16_t>();
    block.first = bytes.number<std::uint32_t>();
    block.newest = bytes.number<std::uint32_t>();
    block.time_us = bytes.number<std::int64_t>();
    block.count = bytes.number<std::uint16_t>();
    if (!bytes.good() || block.count > most_samples)
        return tl::unexpected(invalid("the head of a sample frame is not as the protocol has it"));
    std::array<Row, 4> rows;
    for (std::size_t k = 0; k < block.count; ++k) {
        core::Sample sample;
        sample.sequence = std::uint64_t{block.first} + k;
        sample.path = block.path;
        bool good = true;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const auto count = as_count(rows[axis].next(bytes));
            good = good && count.has_value();
            sample.counts[axis] = count.value_or(0);
        }
        const auto since_us = rows[3].next(bytes);
        const std::uint64_t quality = bytes.varint();
        if (!good || !since_us || !bytes.good() || quality > 0xFFFFFFU)
            return tl::unexpected(invalid("sample " + std::to_string(sample.sequence) + " of a frame is damaged"));
        // The time is that of any clock; wrapping arithmetic, because a foreign number may be anything.
        sample.machine_time_us = static_cast<std::int64_t>(static_cast<std::uint64_t>(block.time_us) +
                                                           static_cast<std::uint64_t>(*since_us));
        sample.flags = static_cast<std::uint16_t>(quality & 0xFFU);
        sample.deflection_counts = static_cast<std::int32_t>(quality >> 8U);
        out.samples.push_back(sample);
    }
    if (!bytes.at_end()) return tl::unexpected(invalid("a sample frame is longer than its samples"));
    return out;
}

std::string command_body(const controller::CommandBlock& command) {
    std::string body = "DO " + std::to_string(command.sequence) + " " + std::to_string(command.owner) + " " +
                       std::string(name_of(command.opcode));
    std::size_t used = command.args.size();
    while (used > 0 && command.args[used - 1] == 0)
        --used;
    for (std::size_t k = 0; k < used; ++k)
        body += " " + std::to_string(command.args[k]);
    return body;
}

std::string window_body(const controller::Window& window, double lsb_mm) {
    std::string body = "PP " + std::to_string(window.path) + " " + std::to_string(window.first_index);
    for (std::size_t k = 0; k < window.points.size(); ++k) {
        const PathPoint& point = window.points[k];
        for (Eigen::Index axis = 0; axis < 3; ++axis)
            body += " " + std::to_string(core::counts_from_mm(point.centre_mm[axis], lsb_mm));
        for (Eigen::Index axis = 0; axis < 3; ++axis)
            body += " " + std::to_string(std::lround(point.normal[axis] * normal_scale));
        body += " " + std::to_string(std::lround(point.speed_mm_s / speed_step_mm_s));
        const bool last = window.last && k + 1 == window.points.size();
        body += " " + std::to_string((point.record ? 1 : 0) + (last ? 2 : 0));
    }
    return body;
}

core::Status check_point(const PathPoint& point, std::uint64_t index, double lsb_mm) {
    return controller::check_point(point, index, lsb_mm, speed_step_mm_s);
}

}  // namespace cmm::drivers::line
