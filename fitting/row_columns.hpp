// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "fitting/vec2.hpp"

namespace cmm::fitting {

/// Places on rows, or directions there, in the rows' planes: column by column along u, row by row in a column; four
/// columns side by side in vector lanes (spare ones are zero).
class RowColumns {
  public:
    using Four = Eigen::Array<double, 4, 2>;  // x and y of four columns

    void reset(std::size_t columns, std::size_t rows) {
        size_ = columns;
        fours_.assign((columns + 3) / 4, std::vector<Four>(rows, Four::Zero()));
    }
    std::size_t size() const { return size_; }
    Vec2 at(std::size_t column, std::size_t row) const {
        const Four& four = fours_[column / 4][row];
        return {four(lane(column), 0), four(lane(column), 1)};
    }
    void set(std::size_t column, std::size_t row, const Vec2& value) {
        fours_[column / 4][row].row(lane(column)) = value.transpose().array();
    }
    const std::vector<std::vector<Four>>& fours() const { return fours_; }

  private:
    static Eigen::Index lane(std::size_t column) { return static_cast<Eigen::Index>(column % 4); }

    std::size_t size_ = 0;
    std::vector<std::vector<Four>> fours_;
};

}  // namespace cmm::fitting
