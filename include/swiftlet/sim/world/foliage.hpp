// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "swiftlet/core/config.hpp"
#include "swiftlet/core/frames.hpp"
#include "swiftlet/core/math/random.hpp"

namespace swiftlet::sim {

/// Leaves in wind. By default they hang still.
struct FoliageConfig {
  double sway_m = 0.0;
  double sway_hz = 0.3;
  double flutter_m = 0.0;
  double flutter_hz = 2.0;
  double wind_deg = 0.0;

  void visit(ConfigVisitor& v);
  bool moves() const { return sway_m > 0.0 || flutter_m > 0.0; }
  /// No leaf is ever farther from where it hangs [m].
  double reach_m() const;
};

/// Where leaves are at a time: a pure function of (config, seed, tree, leaf, time). A tree sways as a clamped beam in
/// its first mode, by the square of the height. It does so along the wind, and half as far across it. Its natural
/// frequency is its own (conifers: 0.1 to 0.6 Hz, Moore and Maguire 2004). Its top runs through an ellipse. Each leaf
/// cluster flutters beside that, by all three axes. All of it is harmonic. A leaf keeps its tilt.
class FoliageMotion {
 public:
  static constexpr int kWays = 256;  ///< to flutter; each leaf cluster has one of them

  FoliageMotion(const FoliageConfig& config, std::uint64_t seed);

  /// Displacement of the top of a tree, of which each has a number [m].
  Vector3 sway_m(std::uint32_t tree, double t_s) const;
  /// What a leaf at a share of its tree's height takes of that. @param height  0: foot, 1: top
  static double share_of_sway(double height);
  /// Displacement of a leaf cluster beside that [m]. @param way  0 to kWays - 1
  Vector3 flutter_m(std::uint32_t way, double t_s) const;
  /// The way of a leaf cluster of a tree.
  std::uint32_t way_of(std::uint32_t tree, std::uint32_t leaf) const;

 private:
  FoliageConfig config_;
  Random random_;
  Vector3 along_, across_;
};

}  // namespace swiftlet::sim
