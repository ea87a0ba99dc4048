// SPDX-License-Identifier: Apache-2.0
#include "web/server/choice_request.hpp"

#include <nlohmann/json.hpp>
#include <utility>

namespace cmm::web {
namespace {

constexpr std::size_t most_choices = 10'000;

std::string list(const std::set<std::uint64_t>& numbers) {
    std::string text;
    for (const auto number : numbers)
        text += (text.empty() ? "" : ",") + std::to_string(number);
    return "[" + text + "]";
}

}  // namespace

std::string choice_document(const acquisition::OperatorChoice& choice) {
    return "{\"rejected\":" + list(choice.rejected()) + ",\"restored\":" + list(choice.restored()) + "}";
}

core::Status apply_choice(const std::string& body, acquisition::OperatorChoice& choice) {
    const auto request = nlohmann::json::parse(body, nullptr, false);
    const auto refuse = [] {
        return core::fail(
            core::ErrorCode::usage,
            "about points: {\"reject\": [SEQ], \"restore\": [SEQ], \"undo\": [SEQ]}, 10000 of them at most");
    };
    if (!request.is_object() || request.empty()) return refuse();
    acquisition::OperatorChoice changed = choice;
    std::size_t count = 0;
    for (const auto& [word, numbers] : request.items()) {
        if (!numbers.is_array() || (count += numbers.size()) > most_choices) return refuse();
        for (const auto& number : numbers) {
            if (!number.is_number_unsigned()) return refuse();
            const auto sequence = number.get<std::uint64_t>();
            if (word == "reject") {
                changed.reject(sequence);
            } else if (word == "restore") {
                changed.restore(sequence);
            } else if (word == "undo") {
                changed.withdraw(sequence);
            } else {
                return refuse();
            }
        }
    }
    choice = std::move(changed);
    return {};
}

}  // namespace cmm::web
