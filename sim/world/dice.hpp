// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "swiftlet/core/base/elementary.hpp"
#include "swiftlet/core/math/random.hpp"

namespace swiftlet::sim {

/// Sequential random numbers of one object (such as tree 17); numbers of other objects do not depend on how many are
/// drawn here.
class Dice {
 public:
  Dice(const Random& random, std::uint32_t thing) : random_(random), thing_(thing) {}

  double uniform() { return random_.uniform(thing_, next_++); }
  double uniform(double min, double max) { return min + (max - min) * uniform(); }
  double normal() { return random_.normal(thing_, next_++); }
  double angle_rad() { return uniform(0.0, 2.0 * std::numbers::pi); }
  bool chance(double probability) { return uniform() < probability; }
  /// Uniform in 0 ... count - 1.
  int pick(int count) { return static_cast<int>(uniform() * count); }
  /// Uniform on the unit sphere.
  Eigen::Vector3f direction() {
    const double z = uniform(-1.0, 1.0);
    const double angle = angle_rad();
    const double radius = std::sqrt(1.0 - z * z);
    return {static_cast<float>(radius * elementary::cos(angle)), static_cast<float>(radius * elementary::sin(angle)),
            static_cast<float>(z)};
  }

 private:
  Random random_;
  std::uint32_t thing_;
  std::uint32_t next_ = 0;
};

}  // namespace swiftlet::sim
