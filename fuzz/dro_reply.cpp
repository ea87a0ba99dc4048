// SPDX-License-Identifier: Apache-2.0
// What a digital readout may print under several formats, whole and cut into pieces. The first byte chooses the format.
#include <cstdlib>

#include "drivers/dro/line_format.hpp"
#include "drivers/dro/line_splitter.hpp"

namespace {

using namespace cmm::drivers::dro;

LineFormat format_of(unsigned choice) {
    DroSettings settings;
    settings.end = "END";
    if (choice % 4 == 1) settings.format = "{x} {y} {z}";
    if (choice % 4 == 2) {
        settings.format = "{tag} {w} X={x};Y={y};Z={z} mm";
        settings.point_tags = "P";
        settings.decimal_comma = true;
        settings.decimals = 3;
    }
    if (choice % 4 == 3) {
        settings.format = "{z},{y},{x},{w}";
        settings.integers = true;
        settings.unit_mm = 25.4;
    }
    return LineFormat::compile(settings).value();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    if (size == 0) return 0;
    const LineFormat format = format_of(data[0]);
    const std::span<const std::uint8_t> bytes(data + 1, size - 1);
    std::vector<LineSplitter::Line> whole;
    std::vector<LineSplitter::Line> pieces;
    LineSplitter first;
    LineSplitter second;
    first.feed(bytes, whole);
    for (const std::uint8_t& byte : bytes)
        second.feed({&byte, 1}, pieces);
    if (whole.size() != pieces.size()) std::abort();
    for (std::size_t k = 0; k < whole.size(); ++k) {
        if (whole[k].text != pieces[k].text || whole[k].text.empty()) std::abort();
        const LineContent content = format.read(whole[k].text);
        if (content.kind == LineContent::Kind::garbled && content.why.empty()) std::abort();
    }
    // A format comes from a file of the user's.
    DroSettings settings;
    settings.format.assign(bytes.begin(), bytes.end());
    if (const auto made = LineFormat::compile(settings)) static_cast<void>(made->read(settings.format));
    return 0;
}
