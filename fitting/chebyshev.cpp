// SPDX-License-Identifier: Apache-2.0
#include "fitting/chebyshev.hpp"

#include <Eigen/LU>
#include <Eigen/QR>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>

namespace cmm::fitting {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int most_exchanges = 2000;
constexpr double no_better = 1e-12;         // of the level: rounding
constexpr double least_independent = 1e-9;  // of an independent row against the first

class Exchange {
  public:
    Exchange(const MatrixXd& rows, const VectorXd& r) : rows_(rows), r_(r), d_(rows.cols()) {}

    core::Result<ChebyshevFit> run() {
        if (rows_.rows() <= d_ || d_ < 1) return refuse("too few points");
        if (!begin()) return refuse("the points do not determine the motion");
        for (fit_.exchanges = 0; fit_.exchanges < most_exchanges; ++fit_.exchanges) {
            level();
            VectorXd::Index worst = 0;
            const VectorXd left = r_ - rows_ * fit_.x;
            const double largest = left.cwiseAbs().maxCoeff(&worst);
            if (largest <= fit_.level * (1.0 + no_better) + std::numeric_limits<double>::min() || is_active(worst))
                return finished();
            if (!exchange(worst, left[worst] < 0.0 ? -1.0 : 1.0)) return finished();
        }
        return refuse("the exchange of points does not end");
    }

  private:
    static tl::unexpected<core::Error> refuse(const char* why) {
        return core::fail(core::ErrorCode::fit_not_evaluable, std::string("min-max fit: ") + why);
    }

    /// Independent rows first, then the one with the largest r among the others.
    bool begin() {
        const Eigen::ColPivHouseholderQR<MatrixXd> qr(rows_.transpose());
        const auto& diagonal = qr.matrixR().diagonal();
        if (!(std::abs(diagonal[d_ - 1]) > least_independent * std::abs(diagonal[0]))) return false;
        for (Eigen::Index k = 0; k < d_; ++k)
            active_.push_back(qr.colsPermutation().indices()[k]);
        Eigen::Index last = -1;
        for (Eigen::Index i = 0; i < rows_.rows(); ++i)
            if (!is_active(i) && (last < 0 || std::abs(r_[i]) > std::abs(r_[last]))) last = i;
        active_.push_back(last);
        signs_ = VectorXd::Ones(d_ + 1);
        orient();
        return true;
    }

    bool is_active(Eigen::Index row) const { return std::find(active_.begin(), active_.end(), row) != active_.end(); }

    /// Signs and weights of the active rows: the weights are positive and the signed rows balance.
    void orient() {
        MatrixXd a(d_ + 1, d_);
        VectorXd r(d_ + 1);
        for (Eigen::Index k = 0; k <= d_; ++k) {
            a.row(k) = rows_.row(active_[static_cast<std::size_t>(k)]);
            r[k] = r_[active_[static_cast<std::size_t>(k)]];
        }
        const Eigen::JacobiSVD<MatrixXd> svd(a.transpose(), Eigen::ComputeFullV);
        VectorXd balance = svd.matrixV().col(d_);
        if (balance.dot(r) < 0.0) balance = -balance;
        for (Eigen::Index k = 0; k <= d_; ++k)
            signs_[k] = balance[k] < 0.0 ? -1.0 : 1.0;
        weights_ = balance.cwiseAbs() / balance.cwiseAbs().sum();
    }

    /// x and the level that all active rows share.
    void level() {
        MatrixXd system(d_ + 1, d_ + 1);
        VectorXd r(d_ + 1);
        for (Eigen::Index k = 0; k <= d_; ++k) {
            const auto row = active_[static_cast<std::size_t>(k)];
            system.row(k).head(d_) = rows_.row(row);
            system(k, d_) = signs_[k];
            r[k] = r_[row];
        }
        inverse_ = system.fullPivLu().inverse();
        const VectorXd solution = inverse_ * r;
        fit_.x = solution.head(d_);
        fit_.level = std::abs(solution[d_]);
    }

    /// The new row comes in, and the one goes for which the weights stay positive.
    bool exchange(Eigen::Index row, double sign) {
        MatrixXd basis(d_ + 1, d_ + 1);
        for (Eigen::Index k = 0; k <= d_; ++k) {
            basis.col(k).head(d_) = signs_[k] * rows_.row(active_[static_cast<std::size_t>(k)]).transpose();
            basis(d_, k) = 1.0;
        }
        VectorXd entering(d_ + 1);
        entering << sign * rows_.row(row).transpose(), 1.0;
        const VectorXd share = basis.fullPivLu().solve(entering);
        Eigen::Index leaves = -1;
        double step = std::numeric_limits<double>::max();
        for (Eigen::Index k = 0; k <= d_; ++k) {
            if (share[k] <= 0.0 || weights_[k] / share[k] >= step) continue;
            step = weights_[k] / share[k];
            leaves = k;
        }
        if (leaves < 0) return false;
        weights_ -= step * share;
        weights_[leaves] = step;
        signs_[leaves] = sign;
        active_[static_cast<std::size_t>(leaves)] = row;
        return true;
    }

    ChebyshevFit finished() {
        fit_.by_active = inverse_.topRows(d_);
        for (const auto row : active_)
            fit_.active.push_back(static_cast<std::size_t>(row));
        return std::move(fit_);
    }

    const MatrixXd& rows_;
    const VectorXd& r_;
    Eigen::Index d_;
    std::vector<Eigen::Index> active_;
    VectorXd signs_, weights_;
    MatrixXd inverse_;
    ChebyshevFit fit_;
};

}  // namespace

core::Result<ChebyshevFit> chebyshev_fit(const MatrixXd& rows, const VectorXd& r) {
    return Exchange(rows, r).run();
}

}  // namespace cmm::fitting
