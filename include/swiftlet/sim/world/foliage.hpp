// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "swiftlet/core/base/config.hpp"
#include "swiftlet/core/base/frames.hpp"
#include "swiftlet/core/math/random.hpp"

namespace swiftlet::sim {

/// Motion of leaves in wind. Off by default.
struct FoliageConfig {
  double sway_m = 0.0;
  double flutter_m = 0.0;

  void visit(ConfigVisitor& v);
  bool moves() const { return sway_m > 0.0 || flutter_m > 0.0; }
  /// Largest displacement of any leaf from its rest position [m].
  double reach_m() const;
};

/// Motion of leaves: a pure function of (config, seed, tree, leaf, time). A tree sways as a clamped beam in its first
/// mode, with the square of the height, along the wind (east) and by half of that across it. Each tree has its own
/// frequencies near 0.3 Hz (conifers: 0.1 to 0.6 Hz, Moore and Maguire 2004). Each leaf cluster additionally flutters
/// along all three axes. All motions are harmonic. Leaves do not rotate.
class FoliageMotion {
 public:
  static constexpr int kNumPatterns = 256;  ///< number of flutter patterns; each leaf cluster uses one of them

  FoliageMotion(const FoliageConfig& config, std::uint64_t seed);

  /// Displacement of the top of tree number `tree` [m].
  Vector3 sway_m(std::uint32_t tree, double t_s) const;
  /// Share of the top's sway for a leaf at this height. @param height 0: foot, 1: top
  static double share_of_sway(double height);
  /// Displacement of a leaf cluster by its flutter [m]. @param pattern index of the pattern, 0 to kNumPatterns - 1
  Vector3 flutter_m(std::uint32_t pattern, double t_s) const;
  /// Flutter pattern of a leaf cluster of a tree.
  std::uint32_t pattern_of(std::uint32_t tree, std::uint32_t leaf) const;

 private:
  FoliageConfig config_;
  Random random_;
};

}  // namespace swiftlet::sim
