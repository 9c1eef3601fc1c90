// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>

#include "core/interception/geofence.hpp"
#include "swiftlet/core/interception/intercept_config.hpp"
#include "swiftlet/core/map/occupancy_view.hpp"
#include "swiftlet/core/math/random.hpp"

namespace swiftlet {

/// Distribution of a lost target's position: particles that move at random from the last sighting. Particles that the
/// vehicle should see, and does not, lose weight.
class TargetSearch {
 public:
  explicit TargetSearch(const TargetSearchConfig& config);

  /// Initializes the particles at the last state of the target, with these standard deviations.
  void begin(const PointState& target, double sigma_m, double sigma_mps);
  /// Moves the particles; they stay inside the fence.
  void advance(double dt_s, const Geofence& fence);
  /// Updates the weights after looking for `dt_s` without a detection. `map` may be null.
  void look(const Vector3& eye_local_m, double dt_s, const OccupancyView* map);
  /// Most probable position of the target.
  Vector3 most_probable() const;
  /// Mean weight of the particles: remaining share of the search space; falls as parts of it are observed to be empty.
  double remaining() const { return remaining_; }
  void append_overlay(std::vector<Overlay>& overlays) const;

 private:
  /// [-] Number of particles. More of them find rarely visited positions and cost time.
  static constexpr int kParticles = 200;
  struct Particle {
    Vector3 p_local_m = Vector3::Zero(), v_local_mps = Vector3::Zero();
    double weight = 1.0;
  };
  bool sees(const Vector3& eye_local_m, const Vector3& p_local_m, const OccupancyView* map) const;

  TargetSearchConfig config_;
  Random random_;
  double tan_bottom_, tan_top_;
  std::uint32_t draws_ = 0;
  double remaining_ = 1.0;
  std::array<Particle, kParticles> particles_;
};

}  // namespace swiftlet
