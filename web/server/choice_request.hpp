// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "acquisition/operator_choice.hpp"
#include "core/error.hpp"

/// What pages say about single points, and are told.
namespace cmm::web {

/// {"rejected": [SEQ], "restored": [SEQ]}
std::string choice_document(const acquisition::OperatorChoice& choice);
/// The body of a request, {"reject": [SEQ], "restore": [SEQ], "undo": [SEQ]}, applied to a choice. Errors: usage
/// (another form, or more than 10 000 points); the choice is then as it was.
core::Status apply_choice(const std::string& body, acquisition::OperatorChoice& choice);

}  // namespace cmm::web
