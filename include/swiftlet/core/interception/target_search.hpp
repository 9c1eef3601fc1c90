// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>

#include "swiftlet/core/interception/geofence.hpp"
#include "swiftlet/core/map/occupancy_view.hpp"
#include "swiftlet/core/math/random.hpp"

namespace swiftlet {

/// How a lost target is looked for.
struct TargetSearchConfig {
  double timeout_s = 20.0;
  double acceleration_mps2 = 2.0;
  double speed_max_mps = 8.0;
  double range_m = 20.0;
  double fov_bottom_deg = -22.5;
  double fov_top_deg = 22.5;
  double detection_rate_per_s = 3.0;
  std::uint64_t seed = 1;

  void visit(ConfigVisitor& v);
};

/// Where a lost target can be by now: particles that fly on at random from where it was last seen. Those that the
/// vehicle would see, and does not, lose their weight.
class TargetSearch {
 public:
  explicit TargetSearch(const TargetSearchConfig& config);

  /// The target was lost here, with these standard deviations.
  void begin(const PointState& target, double sigma_m, double sigma_mps);
  /// Time goes on; targets stay inside the fence.
  void advance(double dt_s, const Geofence& fence);
  /// The vehicle looks for `dt_s` and sees nothing. `map` may be null.
  void look(const Vector3& eye_local_m, double dt_s, const OccupancyView* map);
  /// Where the target most probably is.
  Vector3 most_probable() const;
  /// Height of the highest place that is still possible, of those within 4 m of here on the level. Far below all when
  /// there is none.
  double highest_near_m(const Vector3& p_local_m) const;
  /// The share of the places that are still possible; falls as more of them are seen to be empty.
  double remaining() const { return remaining_; }
  void append_overlay(std::vector<Overlay>& overlays) const;

 private:
  static constexpr int kParticles = 200;
  struct Particle {
    Vector3 p_local_m = Vector3::Zero(), v_local_mps = Vector3::Zero();
    double weight = 1.0;
  };
  Vector3 draw(std::uint32_t particle);
  bool sees(const Vector3& eye_local_m, const Vector3& p_local_m, const OccupancyView* map) const;

  TargetSearchConfig config_;
  Random random_;
  double tan_bottom_, tan_top_;
  std::uint32_t draws_ = 0;
  double remaining_ = 1.0;
  std::array<Particle, kParticles> particles_;
};

}  // namespace swiftlet
