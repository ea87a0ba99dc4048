// SPDX-License-Identifier: Apache-2.0
#include "fitting/row_frames.hpp"

#include <cmath>
#include <optional>
#include <utility>

#include "fitting/cyclic.hpp"
#include "fitting/over_rows.hpp"

namespace cmm::fitting {
namespace {

constexpr double mean_doubt_mm = 1e-4;  // of a row's mean in some micrometres of noise

/// A row's places with the length of the row that each stands for: sums over them hardly depend on where along it they
/// lie, which the alignment of edges knows to some micrometres only.
struct WeighedRow {
    std::vector<Vec2> about_mean;
    std::vector<double> lengths;
    Vec2 mean = Vec2::Zero();
    double gyration_mm = 0.0;  // root mean square distance from the mean

    WeighedRow(const RowColumns& columns, std::size_t row) {
        const std::size_t n = columns.size();
        double length = 0.0;
        for (std::size_t i = 0; i < n; ++i) {
            const Vec2 place = columns.at(i, row);
            const Vec2 after = columns.at(cyclic(i + 1, n), row), before = columns.at(cyclic(i + n - 1, n), row);
            about_mean.push_back(place);
            lengths.push_back(0.5 * ((after - place).norm() + (place - before).norm()));
            mean += lengths.back() * place;
            length += lengths.back();
        }
        mean /= length;
        double squares = 0.0;
        for (std::size_t i = 0; i < n; ++i) {
            about_mean[i] -= mean;
            squares += lengths[i] * about_mean[i].squaredNorm();
        }
        gyration_mm = std::sqrt(squares / length);
    }
};

double turn_of(const WeighedRow& below, const WeighedRow& above) {
    double along = 0.0, across = 0.0;
    for (std::size_t i = 0; i < above.lengths.size(); ++i) {
        along += above.lengths[i] * below.about_mean[i].dot(above.about_mean[i]);
        across += above.lengths[i] * cross(below.about_mean[i], above.about_mean[i]);
    }
    return std::atan2(across, along);
}

}  // namespace

RowFrames::RowFrames(std::span<const double> z, const RowColumns& columns) : RowFrames(z.size()) {
    std::vector<std::optional<Known>> x, y, angle;
    std::optional<WeighedRow> below;
    double turned = 0.0;
    for (std::size_t k = 0; k < z.size(); ++k) {
        WeighedRow row(columns, k);
        if (below) turned += turn_of(*below, row);
        x.push_back(Known{row.mean.x(), mean_doubt_mm});
        y.push_back(Known{row.mean.y(), mean_doubt_mm});
        angle.push_back(Known{turned, mean_doubt_mm / row.gyration_mm});
        below = std::move(row);
    }
    const Smoothed to_x = smoothed_over(z, x), to_y = smoothed_over(z, y), to_angle = smoothed_over(z, angle);
    for (std::size_t k = 0; k < z.size(); ++k)
        frames_[k] = {{to_x.value[k], to_y.value[k]}, {std::cos(to_angle.value[k]), std::sin(to_angle.value[k])}};
}

}  // namespace cmm::fitting
