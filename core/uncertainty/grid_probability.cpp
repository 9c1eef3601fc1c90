// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/uncertainty/grid_probability.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "swiftlet/core/elementary.hpp"

namespace swiftlet {
namespace {

constexpr double kReach = 7.0;          // truncation in standard deviations; 3e-12 lies beyond
constexpr double kStepsPerSigma = 1.2;  // quadrature steps, of three nodes each
constexpr int kMaxSteps = 512;          // largest number of steps of one cell along one axis

double normal_cdf(double x) { return 0.5 * std::erfc(-x / std::numbers::sqrt2); }

// The distribution with its axes in the order (outer, middle, inner): two coordinates, then the inner one given both.
struct Conditional {
  std::array<int, 3> axis{0, 1, 2};
  Eigen::Vector2d mean;
  Eigen::Matrix2d inverse;  // inverse covariance of the two outer coordinates
  double peak = 0.0;        // peak of their density
  Eigen::Vector2d sigma;    // standard deviation of each outer coordinate
  Eigen::Vector2d least;    // standard deviation of each, given the other
  double inner_mean = 0.0;
  Eigen::Vector2d slope;  // derivative of the inner mean with respect to the outer ones
  double inner_sigma = 0.0;
};

Conditional conditional(const Vector3& mean, const Matrix3& Sigma) {
  Conditional c;
  // 1 / (Sigma^-1)_kk is the variance of coordinate k given the others.
  const Matrix3 information = Sigma.inverse();
  int inner = 0;
  information.diagonal().maxCoeff(&inner);
  c.axis = {(inner + 1) % 3, (inner + 2) % 3, inner};
  const int a = c.axis[0], b = c.axis[1];
  Eigen::Matrix2d S;
  S << Sigma(a, a), Sigma(a, b), Sigma(b, a), Sigma(b, b);
  c.mean = {mean[a], mean[b]};
  c.inverse = S.inverse();
  c.peak = 0.5 * std::numbers::inv_pi / std::sqrt(S.determinant());
  c.sigma = S.diagonal().cwiseSqrt();
  c.least = c.inverse.diagonal().cwiseInverse().cwiseSqrt();
  c.inner_mean = mean[inner];
  c.slope = c.inverse * Eigen::Vector2d(Sigma(inner, a), Sigma(inner, b));
  c.inner_sigma = 1.0 / std::sqrt(information(inner, inner));
  return c;
}

// Number of steps of a cell along outer axis `which`: short compared with the width of the density and of the flank.
int steps_of(const Conditional& c, int which, double cell_m) {
  const double flank = std::abs(c.slope[which]) > 0.0 ? c.inner_sigma / std::abs(c.slope[which]) : c.least[which];
  const double steps = kStepsPerSigma * cell_m / std::min(c.least[which], flank);
  return std::clamp(static_cast<int>(std::ceil(steps)), 1, kMaxSteps);
}

struct Node {
  double x = 0.0, weight = 0.0;
};

// Three-point Gauss-Legendre in each step of [low, low + cell].
std::vector<Node> nodes_of(double low, double cell_m, int steps) {
  std::vector<Node> nodes;
  const double step = cell_m / steps, reach = 0.5 * step * std::sqrt(0.6);
  for (int k = 0; k < steps; ++k) {
    const double center = low + (k + 0.5) * step;
    nodes.push_back({center - reach, step * 5.0 / 18.0});
    nodes.push_back({center, step * 8.0 / 18.0});
    nodes.push_back({center + reach, step * 5.0 / 18.0});
  }
  return nodes;
}

class GridIntegral {
 public:
  GridIntegral(const Vector3& mean, const Matrix3& Sigma, const CellGrid& grid)
      : grid_(grid), c_(conditional(mean, Sigma)), cell_(grid.cell_size_m()) {
    const std::array<std::size_t, 3> strides{
        static_cast<std::size_t>(grid.counts[1]) * static_cast<std::size_t>(grid.counts[2]),
        static_cast<std::size_t>(grid.counts[2]), 1};
    for (std::size_t k = 0; k < 3; ++k) stride_[k] = strides[static_cast<std::size_t>(c_.axis[k])];
  }

  std::vector<double> run() {
    probabilities_.assign(static_cast<std::size_t>(grid_.counts[0]) * static_cast<std::size_t>(grid_.counts[1]) *
                              static_cast<std::size_t>(grid_.counts[2]),
                          0.0);
    const int outer_steps = steps_of(c_, 0, cell_[c_.axis[0]]), middle_steps = steps_of(c_, 1, cell_[c_.axis[1]]);
    for (int i = 0; i < grid_.counts[static_cast<std::size_t>(c_.axis[0])]; ++i) {
      const std::vector<Node> outer = nodes_of(low(0) + i * cell_[c_.axis[0]], cell_[c_.axis[0]], outer_steps);
      for (int j = 0; j < grid_.counts[static_cast<std::size_t>(c_.axis[1])]; ++j) {
        const std::vector<Node> middle = nodes_of(low(1) + j * cell_[c_.axis[1]], cell_[c_.axis[1]], middle_steps);
        column(outer, middle, static_cast<std::size_t>(i) * stride_[0] + static_cast<std::size_t>(j) * stride_[1]);
      }
    }
    return std::move(probabilities_);
  }

 private:
  double low(int k) const { return grid_.box.min()[c_.axis[static_cast<std::size_t>(k)]]; }

  void column(const std::vector<Node>& outer, const std::vector<Node>& middle, std::size_t first) {
    for (const Node& x : outer) {
      if (std::abs(x.x - c_.mean[0]) > kReach * c_.sigma[0]) continue;
      for (const Node& y : middle) {
        const Eigen::Vector2d d(x.x - c_.mean[0], y.x - c_.mean[1]);
        const double distance_sq = d.dot(c_.inverse * d);
        if (distance_sq > kReach * kReach) continue;
        const double weight = x.weight * y.weight * c_.peak * elementary::exp(-0.5 * distance_sq);
        along_inner(first, c_.inner_mean + c_.slope.dot(d), weight);
      }
    }
  }

  // Differences of the normal distribution function at the edges of the cells within reach.
  void along_inner(std::size_t first, double mean, double weight) {
    const double cell = cell_[c_.axis[2]], sigma = c_.inner_sigma;
    const int count = grid_.counts[static_cast<std::size_t>(c_.axis[2])];
    const auto index_at = [&](double x) {
      return static_cast<int>(std::floor(std::clamp((x - low(2)) / cell, -1.0, count + 1.0)));
    };
    const int begin = std::max(0, index_at(mean - kReach * sigma)),
              end = std::min(count, index_at(mean + kReach * sigma) + 1);
    if (begin >= end) return;
    double below = normal_cdf((low(2) + begin * cell - mean) / sigma);
    for (int k = begin; k < end; ++k) {
      const double above = normal_cdf((low(2) + (k + 1) * cell - mean) / sigma);
      probabilities_[first + static_cast<std::size_t>(k) * stride_[2]] += weight * (above - below);
      below = above;
    }
  }

  CellGrid grid_;
  Conditional c_;
  Vector3 cell_;
  std::array<std::size_t, 3> stride_{};
  std::vector<double> probabilities_;
};

}  // namespace

std::vector<double> grid_probabilities(const Vector3& mean, const Matrix3& Sigma, const CellGrid& grid) {
  return GridIntegral(mean, Sigma, grid).run();
}

}  // namespace swiftlet
