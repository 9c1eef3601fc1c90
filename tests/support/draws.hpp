// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string_view>

#include "swiftlet/core/math/random.hpp"

namespace swiftlet::testing {

/// Sequence of random numbers for a test. Equal streams, seeds and rounds give equal numbers.
class Draws {
 public:
  explicit Draws(std::string_view stream, std::uint64_t seed = 1, std::uint32_t round = 0)
      : random_(seed, stream), round_(round) {}

  double between(double min, double max) { return random_.uniform(min, max, round_, index_++); }
  int below(int end) { return static_cast<int>(end * between(0.0, 1.0)); }
  bool coin() { return below(2) == 1; }
  /// Uniform in a cube with this half edge.
  Vector3 vector(double half) {
    const double x = between(-half, half), y = between(-half, half);
    return {x, y, between(-half, half)};
  }

 private:
  Random random_;
  std::uint32_t round_, index_ = 0;
};

}  // namespace swiftlet::testing
