// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/uncertainty/voxel_probability.hpp"

#include <algorithm>
#include <array>
#include <boost/math/quadrature/gauss.hpp>
#include <cmath>
#include <numbers>

#include "swiftlet/core/base/elementary.hpp"

namespace swiftlet {
namespace {

constexpr double kDensityReach = 8.5;  // standard deviations beyond which the density counts as zero (1e-17)
constexpr double kTolerance = 1e-9;    // tolerance of one panel of the outer integral
/// [-] Largest number of successive halvings of a panel. Bounds the time for degenerate covariances; smaller values
/// integrate those less accurately.
constexpr int kMaxDepth = 40;

double normal_pdf(double x) { return elementary::exp(-0.5 * x * x) * std::numbers::inv_sqrtpi / std::numbers::sqrt2; }

// Phi(b) - Phi(a), accurate in both tails.
double normal_between(double a, double b) {
  if (b <= a) return 0.0;
  if (a > 0.0) return 0.5 * (std::erfc(a / std::numbers::sqrt2) - std::erfc(b / std::numbers::sqrt2));
  return 0.5 * (std::erfc(-b / std::numbers::sqrt2) - std::erfc(-a / std::numbers::sqrt2));
}

struct Interval {
  double low, high;
};

// Limits of one standardized coordinate: (limit - mean) / sigma; with sigma = 0, everything or nothing.
Interval standardized(double low, double high, double mean, double sigma) {
  if (sigma > 0.0) return {(low - mean) / sigma, (high - mean) / sigma};
  const bool inside = low <= mean && mean < high;
  return inside ? Interval{-kDensityReach, kDensityReach} : Interval{1.0, 0.0};
}

// x = L z with L lower triangular; box limits are relative to the mean.
struct Factored {
  Matrix3 L;
  Vector3 low, high;
};

// Integral over z3, in closed form.
double innermost(const Factored& f, double z1, double z2) {
  const double mean = f.L(2, 0) * z1 + f.L(2, 1) * z2;
  const Interval i = standardized(f.low[2], f.high[2], mean, f.L(2, 2));
  return normal_between(i.low, i.high);
}

// The integrand over z2 is smooth except at flanks where a limit of z3 is crossed: splits there, and integrates each
// piece by Gauss-Legendre.
double middle(const Factored& f, double z1) {
  Interval i = standardized(f.low[1], f.high[1], f.L(1, 0) * z1, f.L(1, 1));
  i = {std::max(i.low, -kDensityReach), std::min(i.high, kDensityReach)};
  if (i.high <= i.low) return 0.0;

  std::array<double, 16> cuts{};
  std::size_t num_cuts = 0;
  cuts[num_cuts++] = i.low;
  cuts[num_cuts++] = i.high;
  const auto cut = [&](double z2) {
    if (z2 > i.low && z2 < i.high) cuts[num_cuts++] = z2;
  };
  for (const double plain : {-4.0, -1.5, 1.5, 4.0}) cut(plain);
  for (const double limit : {f.low[2], f.high[2]}) {  // infinite or NaN, hence no cut, where z3 does not depend on z2
    for (const double flank : {-6.0, -1.5, 1.5, 6.0}) cut((limit - f.L(2, 0) * z1 - flank * f.L(2, 2)) / f.L(2, 1));
  }
  std::sort(cuts.begin(), cuts.begin() + num_cuts);

  double sum = 0.0;
  for (std::size_t k = 0; k + 1 < num_cuts; ++k) {
    if (cuts[k + 1] - cuts[k] < 1e-14) continue;
    sum += boost::math::quadrature::gauss<double, 15>::integrate(
        [&](double z2) { return normal_pdf(z2) * innermost(f, z1, z2); }, cuts[k], cuts[k + 1]);
  }
  return sum;
}

// Adaptive Gauss-Legendre: a panel is accepted when its halves agree with it.
template <class F>
double adaptive(const F& integrand, double low, double high, double whole, int depth) {
  using Rule = boost::math::quadrature::gauss<double, 10>;
  const double center = 0.5 * (low + high);
  const double left = Rule::integrate(integrand, low, center);
  const double right = Rule::integrate(integrand, center, high);
  if (depth >= kMaxDepth || std::abs(left + right - whole) < kTolerance) return left + right;
  return adaptive(integrand, low, center, left, depth + 1) + adaptive(integrand, center, high, right, depth + 1);
}

// Cholesky for positive semi-definite matrices: a vanishing pivot leaves a column of zeros.
Matrix3 lower_factor(const Matrix3& Sigma) {
  Matrix3 L = Matrix3::Zero();
  const double scale = Sigma.diagonal().maxCoeff();
  for (int j = 0; j < 3; ++j) {
    const double pivot = Sigma(j, j) - L.row(j).head(j).squaredNorm();
    if (pivot <= 1e-15 * scale) continue;
    L(j, j) = std::sqrt(pivot);
    for (int i = j + 1; i < 3; ++i) L(i, j) = (Sigma(i, j) - L.row(i).head(j).dot(L.row(j).head(j))) / L(j, j);
  }
  return L;
}

}  // namespace

double box_probability(const Vector3& mean, const Matrix3& Sigma, const Eigen::AlignedBox3d& box) {
  const Factored f{lower_factor(Sigma), box.min() - mean, box.max() - mean};
  Interval i = standardized(f.low[0], f.high[0], 0.0, f.L(0, 0));
  i = {std::max(i.low, -kDensityReach), std::min(i.high, kDensityReach)};
  if (i.high <= i.low) return 0.0;
  const auto integrand = [&](double z1) { return normal_pdf(z1) * middle(f, z1); };

  // Fixed panels first, so that a narrow peak does not fall between the nodes of a wide one.
  constexpr int kPanels = 16;
  double sum = 0.0;
  for (int k = 0; k < kPanels; ++k) {
    const double low = i.low + (i.high - i.low) * k / kPanels;
    const double high = i.low + (i.high - i.low) * (k + 1) / kPanels;
    sum +=
        adaptive(integrand, low, high, boost::math::quadrature::gauss<double, 10>::integrate(integrand, low, high), 0);
  }
  return std::clamp(sum, 0.0, 1.0);
}

double correct_voxel_probability(const Vector3& p_measured_world_m, const Matrix3& Sigma, double voxel_edge_m) {
  const Vector3 corner = (p_measured_world_m / voxel_edge_m).array().floor() * voxel_edge_m;
  return box_probability(p_measured_world_m, Sigma, {corner, corner + Vector3::Constant(voxel_edge_m)});
}

}  // namespace swiftlet
