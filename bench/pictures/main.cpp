// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <utility>

#include "bench/pictures/pictures.hpp"

namespace cmm::pictures {

namespace {

/// A picture that stands alone brings its style along.
std::string with_style(std::string picture) {
    const auto head = picture.find('\n') + 1;
    picture.insert(head, "<style>" + std::string(svg::figure_style()) + "</style>\n");
    return picture;
}

int draw_all(const std::filesystem::path& folder) {
    std::filesystem::create_directories(folder);
    const std::pair<const char*, std::function<std::string()>> pictures[] = {
        {"bad-points.svg", bad_points}, {"compensation.svg", compensation},
        {"edge-fit.svg", edge_fit},     {"live-error.svg", live_error},
        {"offset.svg", offset},         {"sample-cost.svg", sample_cost}};
    bool complete = true;
    for (const auto& [name, draw] : pictures) {
        const std::string picture = draw();
        if (picture.empty()) {
            std::fprintf(stderr, "%s: there is nothing to draw; the picture stays as it was\n", name);
            complete = false;
            continue;
        }
        const auto file = folder / name;
        std::ofstream out(file, std::ios::binary);
        out << with_style(picture);
        if (!out.flush()) {
            std::fprintf(stderr, "cannot write %s\n", file.c_str());
            return 1;
        }
        std::printf("%s\n", file.c_str());
    }
    return complete ? 0 : 1;
}

}  // namespace
}  // namespace cmm::pictures

int main(int count, char** arguments) {
    return cmm::pictures::draw_all(count > 1 ? arguments[1] : "docs/pictures");
}
