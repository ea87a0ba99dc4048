// SPDX-License-Identifier: Apache-2.0
#include "acquisition/html.hpp"

#include "acquisition/report_style.hpp"
#include "acquisition/svg.hpp"

namespace cmm::acquisition::html {

std::string element(const std::string& tag, const std::string& content) {
    return "<" + tag + ">" + content + "</" + tag.substr(0, tag.find(' ')) + ">\n";
}

std::string figure(const std::string& css, const std::string& caption, const std::string& picture) {
    if (picture.empty()) return {};
    return "<figure class=\"" + css + "\"><figcaption>" + caption + "</figcaption>\n" + picture + "</figure>\n";
}

std::string fact(const std::string& name, const std::string& value) {
    return "<div><dt>" + name + "</dt><dd>" + svg::escape(value) + "</dd></div>\n";
}

std::string page(const std::string& title, const std::string& body) {
    return "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n"
           "<meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">\n<title>" +
           svg::escape(title) + "</title>\n<style>" + std::string(report_style()) + std::string(svg::figure_style()) +
           "</style></head>\n<body><main>\n" + body + "</main></body></html>\n";
}

}  // namespace cmm::acquisition::html
