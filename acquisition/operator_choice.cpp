// SPDX-License-Identifier: Apache-2.0
#include "acquisition/operator_choice.hpp"

#include <charconv>
#include <string_view>

namespace cmm::acquisition {
namespace {

using core::ErrorCode;

constexpr std::uint64_t most_points = 1'000'000;  // of one range

core::Status add_range(std::string_view text, std::set<std::uint64_t>& out) {
    std::uint64_t first = 0;
    const char* const end = text.data() + text.size();
    auto read = std::from_chars(text.data(), end, first);
    std::uint64_t last = first;
    if (read.ec == std::errc() && read.ptr != end && *read.ptr == '-') read = std::from_chars(read.ptr + 1, end, last);
    if (read.ec != std::errc() || read.ptr != end || last < first || last - first >= most_points)
        return core::fail(ErrorCode::usage,
                          "'" + std::string(text) + "' is no sequence number (12) and no range (15-18)");
    for (std::uint64_t sequence = first; sequence <= last; ++sequence)
        out.insert(sequence);
    return {};
}

core::Status add_list(const std::vector<std::string>& lists, std::set<std::uint64_t>& out) {
    for (const std::string& list : lists) {
        std::string_view rest = list;
        while (true) {
            const auto comma = rest.find(',');
            if (auto status = add_range(rest.substr(0, comma), out); !status) return status;
            if (comma == std::string_view::npos) break;
            rest.remove_prefix(comma + 1);
        }
    }
    return {};
}

}  // namespace

core::Result<OperatorChoice> OperatorChoice::parse(const std::vector<std::string>& rejected,
                                                   const std::vector<std::string>& restored) {
    OperatorChoice choice;
    if (auto status = add_list(rejected, choice.rejected_); !status) return tl::unexpected(status.error());
    if (auto status = add_list(restored, choice.restored_); !status) return tl::unexpected(status.error());
    for (const std::uint64_t sequence : choice.rejected_)
        if (choice.restored_.count(sequence) != 0)
            return core::fail(ErrorCode::usage,
                              "point " + std::to_string(sequence) + " cannot be both rejected and restored");
    return choice;
}

void OperatorChoice::reject(std::uint64_t sequence) {
    restored_.erase(sequence);
    rejected_.insert(sequence);
}

void OperatorChoice::restore(std::uint64_t sequence) {
    rejected_.erase(sequence);
    restored_.insert(sequence);
}

void OperatorChoice::withdraw(std::uint64_t sequence) {
    rejected_.erase(sequence);
    restored_.erase(sequence);
}

void OperatorChoice::apply(std::vector<RecordedPoint>& points) {
    for (RecordedPoint& point : points) {
        const bool reject = rejected_.count(point.sequence) != 0;
        if (!reject && restored_.count(point.sequence) == 0) continue;
        found_.insert(point.sequence);
        point.verdict.reason = reject ? fitting::RejectReason::by_operator : fitting::RejectReason::none;
        point.verdict.kept = !reject;
    }
}

core::Status OperatorChoice::all_found() const {
    for (const auto* wanted : {&rejected_, &restored_})
        for (const std::uint64_t sequence : *wanted)
            if (found_.count(sequence) == 0)
                return core::fail(ErrorCode::usage,
                                  "there is no point with the sequence number " + std::to_string(sequence));
    return {};
}

}  // namespace cmm::acquisition
