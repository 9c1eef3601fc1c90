// SPDX-License-Identifier: BSD-3-Clause
#include "core/slam/sharing/submap_look.hpp"

#include <algorithm>
#include <cmath>

#include "core/slam/graph/closure_search.hpp"
#include "swiftlet/core/math/angles.hpp"

namespace swiftlet {
namespace {

// [-] Quantile of the points' heights that is taken as the ground. Larger values take low structure for it, smaller
// ones stray points.
constexpr double kGroundShare = 0.05;

/// Histogram of the heights of upright structure above the ground, in bins of 1 m.
std::array<std::uint8_t, SubmapLook::kHeights> heights_of(std::span<const Eigen::Vector3f> points_m, double cell_m,
                                                          double range_max_m) {
  std::array<std::uint8_t, SubmapLook::kHeights> heights{};
  std::vector<float> z_m;
  z_m.reserve(points_m.size());
  for (const Eigen::Vector3f& p : points_m) {
    if (p.head<2>().norm() <= static_cast<float>(range_max_m)) z_m.push_back(p.z());
  }
  if (z_m.empty()) return heights;
  const auto ground = z_m.begin() + static_cast<std::ptrdiff_t>(kGroundShare * static_cast<double>(z_m.size()));
  std::nth_element(z_m.begin(), ground, z_m.end());
  std::array<int, SubmapLook::kHeights> count{};
  for (const Eigen::Vector3f& p : upright_points_m(points_m, cell_m, range_max_m)) {
    const double above_m = static_cast<double>(p.z()) - static_cast<double>(*ground);
    ++count[static_cast<std::size_t>(std::clamp(above_m, 0.0, SubmapLook::kHeights - 1.0))];
  }
  const int most = *std::max_element(count.begin(), count.end());
  for (std::size_t i = 0; i < heights.size(); ++i) {
    heights[i] = static_cast<std::uint8_t>(most > 0 ? 255 * count[i] / most : 0);
  }
  return heights;
}

double cosine(std::span<const std::uint8_t> a, std::span<const std::uint8_t> b) {
  double dot = 0.0, of_a = 0.0, of_b = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    dot += static_cast<double>(a[i]) * b[i];
    of_a += static_cast<double>(a[i]) * a[i];
    of_b += static_cast<double>(b[i]) * b[i];
  }
  return of_a > 0.0 && of_b > 0.0 ? dot / std::sqrt(of_a * of_b) : 0.0;
}

}  // namespace

std::optional<SubmapLook> SubmapLook::from_quantized(std::span<const std::uint8_t> directions,
                                                     std::span<const std::uint8_t> heights) {
  if (directions.size() != RotationalHistogram::kBuckets || heights.size() != kHeights) return std::nullopt;
  SubmapLook look;
  look.directions = RotationalHistogram(directions.first<RotationalHistogram::kBuckets>());
  std::copy(heights.begin(), heights.end(), look.heights.begin());
  return look;
}

SubmapLook look_of(std::span<const Eigen::Vector3f> points_m, double cell_m, double range_max_m) {
  SubmapLook look;
  look.directions = RotationalHistogram(points_m);
  look.heights = heights_of(points_m, cell_m, range_max_m);
  return look;
}

double likeness(const SubmapLook& a, const SubmapLook& b) {
  double best = 0.0;
  for (int i = 0; i < RotationalHistogram::kBuckets; ++i) {
    const double yaw_rad = kPi * i / RotationalHistogram::kBuckets;
    best = std::max(best, a.directions.similarity(b.directions, yaw_rad));
  }
  return best * cosine(a.heights, b.heights);
}

}  // namespace swiftlet
