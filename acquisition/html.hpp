// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

/// Pieces of a report as HTML text. Contents are HTML already unless said.
namespace cmm::acquisition::html {

/// `tag` may carry attributes: "p class=\"x\"".
std::string element(const std::string& tag, const std::string& content);
/// Nothing without a picture.
std::string figure(const std::string& css, const std::string& caption, const std::string& picture);
/// A name with its value (plain text) in a list of facts.
std::string fact(const std::string& name, const std::string& value);
/// The whole file with the styles of reports and pictures; the title is plain text.
std::string page(const std::string& title, const std::string& body);

}  // namespace cmm::acquisition::html
