// SPDX-License-Identifier: Apache-2.0
// What a browser sends: the target of a request, its fields, and what it says about points. The first byte chooses.
#include <cstdint>
#include <cstdlib>
#include <string>

#include "web/server/choice_request.hpp"
#include "web/server/guard.hpp"
#include "web/server/target.hpp"

namespace {

void target(const std::string& text) {
    const auto parsed = cmm::web::parse_target(text);
    if (!parsed) return;
    for (const auto& segment : parsed->path)
        if (segment.empty() || segment == ".." || segment.find('/') != std::string::npos) std::abort();
    for (const auto& [name, value] : parsed->query)
        static_cast<void>(parsed->number(name));
}

/// Host, origin and token by lines. Without the token nothing changes, whatever else is there.
void fields(const std::string& text) {
    static const cmm::web::Guard guard("a token of the fuzzer's", false, {"cell7"});
    cmm::web::Request request;
    request.method = "POST";
    const auto first = text.find('\n'), second = text.find('\n', first + 1);
    request.host = text.substr(0, first);
    if (first != std::string::npos) request.origin = text.substr(first + 1, second - first - 1);
    if (second != std::string::npos && first != std::string::npos) request.token = text.substr(second + 1);
    request.content_type = "application/json";
    static_cast<void>(guard.refuse(request));
    if (!guard.refuse_api(request) && request.token != "a token of the fuzzer's") std::abort();
}

void choice(const std::string& text) {
    cmm::acquisition::OperatorChoice made;
    made.reject(1);
    const std::string before = cmm::web::choice_document(made);
    const auto status = cmm::web::apply_choice(text, made);
    if (!status && cmm::web::choice_document(made) != before) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    if (size == 0) return 0;
    const std::string text(data + 1, data + size);
    switch (data[0] % 3) {
        case 0:
            target(text);
            break;
        case 1:
            fields(text);
            break;
        default:
            choice(text);
    }
    return 0;
}
