// SPDX-License-Identifier: Apache-2.0
#include "cell/modbus_request.hpp"

#include <algorithm>

namespace cmm::cell {
namespace {

constexpr std::size_t length_at = 4, unit_at = 6, function_at = 7;
constexpr std::size_t most_to_read = 125, most_to_write = 123, most_to_write_and_read = 121;
constexpr std::size_t highest_address = 0xFFFF;

/// Reads a request front to back; what is not there is 0 and makes the request broken.
class Fields {
  public:
    explicit Fields(std::span<const std::uint8_t> bytes) : left_(bytes) {}
    std::uint8_t byte() {
        if (left_.empty()) {
            broken_ = true;
            return 0;
        }
        const std::uint8_t value = left_.front();
        left_ = left_.subspan(1);
        return value;
    }
    std::uint16_t word() {
        const unsigned high = byte();
        return static_cast<std::uint16_t>(high << 8U | byte());
    }
    /// All was there and nothing is left.
    bool finished() const { return !broken_ && left_.empty(); }

  private:
    std::span<const std::uint8_t> left_;
    bool broken_ = false;
};

struct Values {
    std::size_t address = 0, count = 0;
    std::array<std::uint16_t, most_to_write> words{};
    std::span<const std::uint16_t> span() const { return {words.data(), count}; }
};

struct Range {
    std::size_t address = 0, count = 0;
};

class Answer {
  public:
    Answer(RegisterAccess& registers, std::span<std::uint8_t> pdu) : registers_(registers), pdu_(pdu) {}

    ModbusException to(std::uint8_t function, Fields fields) {
        pdu_[used_++] = function;
        switch (function) {
            case 3:
            case 4:
                return read(fields);
            case 6:
                return write_one(fields);
            case 16:
                return write_many(fields);
            case 23:
                return write_and_read(fields);
            default:
                return ModbusException::illegal_function;
        }
    }
    std::size_t used() const { return used_; }

  private:
    void put(std::size_t word) {
        pdu_[used_++] = static_cast<std::uint8_t>(word >> 8U & 0xFFU);
        pdu_[used_++] = static_cast<std::uint8_t>(word & 0xFFU);
    }

    ModbusException fetch(const Range& range, std::array<std::uint16_t, most_to_read>& words) {
        if (range.count < 1 || range.count > most_to_read) return ModbusException::illegal_value;
        if (range.address + range.count - 1 > highest_address) return ModbusException::illegal_address;
        return registers_.read(range.address, std::span(words).first(range.count));
    }

    void put_words(std::span<const std::uint16_t> words) {
        pdu_[used_++] = static_cast<std::uint8_t>(2 * words.size());
        for (const auto word : words)
            put(word);
    }

    ModbusException read(Fields& fields) {
        Range range;
        range.address = fields.word();
        range.count = fields.word();
        if (!fields.finished()) return ModbusException::illegal_value;
        std::array<std::uint16_t, most_to_read> words{};
        const auto outcome = fetch(range, words);
        if (outcome == ModbusException::none) put_words(std::span(words).first(range.count));
        return outcome;
    }

    ModbusException write_one(Fields& fields) {
        Values values;
        values.address = fields.word();
        values.words[0] = fields.word();
        values.count = 1;
        if (!fields.finished()) return ModbusException::illegal_value;
        const auto outcome = registers_.write(values.address, values.span());
        put(values.address);
        put(values.words[0]);
        return outcome;
    }

    static ModbusException take(Fields& fields, Values& values, std::size_t most) {
        values.address = fields.word();
        values.count = fields.word();
        const std::size_t bytes = fields.byte();
        if (values.count < 1 || values.count > most || bytes != 2 * values.count) return ModbusException::illegal_value;
        for (std::size_t i = 0; i < values.count; ++i)
            values.words[i] = fields.word();
        if (!fields.finished()) return ModbusException::illegal_value;
        return values.address + values.count - 1 > highest_address ? ModbusException::illegal_address
                                                                   : ModbusException::none;
    }

    ModbusException write_many(Fields& fields) {
        Values values;
        if (const auto wrong = take(fields, values, most_to_write); wrong != ModbusException::none) return wrong;
        const auto outcome = registers_.write(values.address, values.span());
        put(values.address);
        put(values.count);
        return outcome;
    }

    /// The write comes first, and not before it is known that the read will succeed.
    ModbusException write_and_read(Fields& fields) {
        Range range;
        range.address = fields.word();
        range.count = fields.word();
        Values values;
        if (const auto wrong = take(fields, values, most_to_write_and_read); wrong != ModbusException::none)
            return wrong;
        std::array<std::uint16_t, most_to_read> words{};
        if (const auto wrong = fetch(range, words); wrong != ModbusException::none) return wrong;
        auto outcome = registers_.write(values.address, values.span());
        if (outcome == ModbusException::none) outcome = fetch(range, words);
        if (outcome == ModbusException::none) put_words(std::span(words).first(range.count));
        return outcome;
    }

    RegisterAccess& registers_;
    std::span<std::uint8_t> pdu_;
    std::size_t used_ = 0;
};

bool for_us(std::uint8_t asked, std::uint8_t unit) {
    return asked == unit || asked == 0 || asked == 0xFF;
}

}  // namespace

RequestCut cut_request(std::span<const std::uint8_t> bytes) noexcept {
    // Protocol 0, then the number of bytes from the unit on: unit and function code at least.
    if (bytes.size() >= length_at && (bytes[2] != 0 || bytes[3] != 0)) return {RequestCut::Kind::garbled, 0};
    if (bytes.size() < unit_at) return {};
    const std::size_t following = static_cast<std::size_t>(bytes[length_at] << 8U | bytes[length_at + 1]);
    if (following < 2 || unit_at + following > longest_adu) return {RequestCut::Kind::garbled, 0};
    if (bytes.size() < unit_at + following) return {};
    return {RequestCut::Kind::request, unit_at + following};
}

std::size_t answer_request(RegisterAccess& registers, std::uint8_t unit, std::span<const std::uint8_t> request,
                           std::span<std::uint8_t, longest_adu> reply) {
    std::copy_n(request.begin(), function_at, reply.begin());
    Answer answer(registers, reply.subspan(function_at));
    const std::uint8_t function = request[function_at];
    const auto outcome = for_us(request[unit_at], unit) ? answer.to(function, Fields(request.subspan(function_at + 1)))
                                                        : ModbusException::no_target;
    std::size_t used = answer.used();
    if (outcome != ModbusException::none) {
        reply[function_at] = static_cast<std::uint8_t>(function | 0x80U);
        reply[function_at + 1] = static_cast<std::uint8_t>(outcome);
        used = 2;
    }
    reply[length_at] = 0;
    reply[length_at + 1] = static_cast<std::uint8_t>(1 + used);
    return function_at + used;
}

}  // namespace cmm::cell
