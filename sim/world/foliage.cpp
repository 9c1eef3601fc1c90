// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/world/foliage.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "swiftlet/core/base/elementary.hpp"

namespace swiftlet::sim {
namespace {

// [-] Range of natural frequencies of trees and leaves, relative to the mean frequency. A wider range makes the
// motion of the plants more different.
constexpr double kSlowest = 0.8, kFastest = 1.25;
// [Hz] Mean natural frequency of the trees, and mean flutter frequency of the leaf clusters. Larger values make leaves
// faster.
constexpr double kSway_hz = 0.3, kFlutter_hz = 2.0;
constexpr double kAcross = 0.5;     // sway across the wind, relative to that along it
constexpr double kFlutterUp = 0.5;  // vertical flutter, relative to that along the other axes
constexpr std::uint32_t kOfTrees = 0, kOfPatterns = 1, kOfLeaves = 2;  // separate random streams
// [-] Random numbers reserved for one tree or pattern.
constexpr std::uint32_t kNumbersOfOne = 8;

double oscillation(const Random& random, std::uint32_t domain, std::uint32_t first, double hz, double t_s) {
  const double own_hz = hz * random.uniform(kSlowest, kFastest, domain, first);
  const double cycles = own_hz * t_s + random.uniform(domain, first + 1);
  return elementary::sin(2.0 * std::numbers::pi * (cycles - std::floor(cycles)));
}

}  // namespace

void FoliageConfig::visit(ConfigVisitor& v) {
  v.field("sway_m", sway_m, "[m] amplitude of a tree's top along the wind, which blows east; 0: trees stand still",
          Range::between(0.0, 5.0));
  v.field("flutter_m", flutter_m,
          "[m] amplitude of a leaf cluster along each horizontal axis; half of it along the vertical",
          Range::between(0.0, 1.0));
}

double FoliageConfig::reach_m() const {
  return std::sqrt(1.0 + kAcross * kAcross) * sway_m + std::sqrt(2.0 + kFlutterUp * kFlutterUp) * flutter_m;
}

FoliageMotion::FoliageMotion(const FoliageConfig& config, std::uint64_t seed)
    : config_(config), random_(seed, "world.foliage") {}

Vector3 FoliageMotion::sway_m(std::uint32_t tree, double t_s) const {
  const std::uint32_t first = kNumbersOfOne * tree;
  const double along = oscillation(random_, kOfTrees, first, kSway_hz, t_s);
  const double across = kAcross * oscillation(random_, kOfTrees, first + 2, kSway_hz, t_s);
  return config_.sway_m * Vector3(along, across, 0.0);
}

double FoliageMotion::share_of_sway(double height) {
  const double within = std::clamp(height, 0.0, 1.0);
  return within * within;
}

Vector3 FoliageMotion::flutter_m(std::uint32_t pattern, double t_s) const {
  const std::uint32_t first = kNumbersOfOne * pattern;
  const auto axis = [&](std::uint32_t k) { return oscillation(random_, kOfPatterns, first + 2 * k, kFlutter_hz, t_s); };
  return config_.flutter_m * Vector3(axis(0), axis(1), kFlutterUp * axis(2));
}

std::uint32_t FoliageMotion::pattern_of(std::uint32_t tree, std::uint32_t leaf) const {
  return random_.bits(kOfLeaves + tree, leaf)[0] % kNumPatterns;
}

}  // namespace swiftlet::sim
