// SPDX-License-Identifier: Apache-2.0
#include "fitting/column_smoother.hpp"

#include <algorithm>
#include <array>

namespace cmm::fitting {
namespace {

// Of the second derivative at the rows, where there are too few of them for a cubic: it only chooses among equals.
constexpr double least_bend = 1e-7;
constexpr std::size_t rows_of_a_cubic = 4;

}  // namespace

ColumnSmoother::ColumnSmoother(std::span<const double> rows, double beyond) {
    const std::size_t n = rows.size();
    std::vector<double> breaks(rows.begin(), rows.end());
    breaks.front() -= beyond;
    breaks.back() += beyond;
    if (auto axis = CubicAxis::on_breaks(breaks, false)) axis_ = std::move(*axis);
    spacing_ = (rows.back() - rows.front()) / static_cast<double>(n - 1);
    std::size_t span = 0;
    for (const double v : rows) {
        span = axis_.span_of(v, span);
        places_.push_back({span, axis_.weights(span, v).value});
    }
    leverage_.resize(n);
}

bool ColumnSmoother::set_weight(double weight) {
    normal_.reset(axis_.controls(), false);
    for (const Place& place : places_)
        for (int a = 0; a < 4; ++a)
            for (int c = 0; c <= a; ++c)
                normal_.add(place.span + static_cast<std::size_t>(a), place.span + static_cast<std::size_t>(c),
                            place.weights[a] * place.weights[c]);
    const auto third = [&](std::size_t k, std::size_t a) {
        const double h = (axis_.high(k) - axis_.low(k)) / spacing_;
        return 6.0 * axis_.basis(k).power[3][a] / (h * h * h);
    };
    for (std::size_t k = 0; k + 1 < axis_.spans(); ++k) {
        std::array<double, 5> jump{};
        for (std::size_t a = 0; a < 5; ++a)
            jump[a] = (a > 0 ? third(k + 1, a - 1) : 0.0) - (a < 4 ? third(k, a) : 0.0);
        for (std::size_t a = 0; a < 5; ++a)
            for (std::size_t c = 0; c <= a; ++c)
                normal_.add(k + a, k + c, weight * jump[a] * jump[c]);
    }
    if (places_.size() < rows_of_a_cubic)
        for (std::size_t k = 0; k < axis_.spans(); ++k)
            for (const double v : {axis_.low(k), axis_.high(k)}) {
                const Eigen::Array4d bend = spacing_ * spacing_ * axis_.weights(k, v).d2;
                for (int a = 0; a < 4; ++a)
                    for (int c = 0; c <= a; ++c)
                        normal_.add(k + static_cast<std::size_t>(a), k + static_cast<std::size_t>(c),
                                    least_bend * bend[a] * bend[c]);
            }
    if (!normal_.factor()) return false;
    normal_.invert(inverse_);
    freedom_ = 0.0;
    for (std::size_t k = 0; k < places_.size(); ++k) {
        const Place& place = places_[k];
        double sum = 0.0;
        for (std::size_t a = 0; a < 4; ++a)
            for (std::size_t c = a; c < 4; ++c)
                sum += (c > a ? 2.0 : 1.0) * place.weights[static_cast<int>(a)] * place.weights[static_cast<int>(c)] *
                       inverse_[place.span + a][c - a];
        leverage_[k] = std::clamp(sum, 0.0, 1.0);
        freedom_ += leverage_[k];
    }
    return true;
}

}  // namespace cmm::fitting
