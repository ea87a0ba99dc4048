// SPDX-License-Identifier: Apache-2.0
// The layer without Cairo, Pango and librsvg.
#include "pdf/pages.hpp"
#include "pdf/png.hpp"

namespace cmm::pdf {

struct Pages::Work {};

Pages::Pages(std::unique_ptr<Work> work) : work_(std::move(work)) {}
Pages::Pages(Pages&& other) noexcept = default;
Pages& Pages::operator=(Pages&& other) noexcept = default;
Pages::~Pages() = default;

core::Result<Pages> Pages::make(const About& about) {
    return core::fail(core::ErrorCode::config_invalid,
                      about.title +
                          " cannot be written: this cmmlive was built without PDF; install librsvg2-dev and "
                          "libpango1.0-dev and build again");
}

void Pages::title(const std::string& /*text*/, const std::string& /*verdict*/, Ink /*ink*/) {}
void Pages::heading(const std::string& /*text*/) {}
void Pages::paragraph(const std::string& /*text*/, Ink /*ink*/) {}
void Pages::facts(std::span<const std::pair<std::string, std::string>> /*facts*/) {}
void Pages::table(std::span<const Column> /*columns*/, std::span<const std::vector<Cell>> /*rows*/) {}
void Pages::pictures(std::span<const Picture> /*pictures*/, int /*beside*/) {}
core::Result<std::string> Pages::finish() {
    return std::string{};
}

core::Result<std::string> png_of(std::string_view /*svg*/, int /*width_px*/) {
    return core::fail(core::ErrorCode::config_invalid,
                      "a PNG cannot be written: this cmmlive was built without Cairo; install librsvg2-dev and "
                      "libpango1.0-dev and build again (--format svg needs none of them)");
}

}  // namespace cmm::pdf
