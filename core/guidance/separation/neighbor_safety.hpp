// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "core/guidance/separation/braking_planes.hpp"
#include "core/guidance/separation/encounter.hpp"
#include "core/guidance/separation/guarded_reference.hpp"
#include "core/guidance/separation/neighbor_memory.hpp"
#include "core/guidance/separation/neighbor_sight.hpp"
#include "swiftlet/core/guidance/separation_config.hpp"

namespace swiftlet {

/// Keeps a vehicle apart from its neighbors, for any goals of its guidance.
///
/// Guarantee: two vehicles that both use this class keep the distance D = SeparationConfig::distance_m(), less twice
/// the control error, if
/// - each measures the other before their distance is below its braking path (range, no blind sector on the course),
/// - the other's position at the last sample is within `sigmas` standard deviations,
/// - both start farther apart than D.
/// The pledges give this for any rate and latency of the samples. A neighbor that does not yield is evaded; the
/// distance then depends on its speed and on when it is known (docs/rbl.md). Obstacles are not considered, except as
/// bounds of an evasion.
///
/// Per period: update(), then admit() with the goal that guidance wants. Per tick: step().
class NeighborSafety {
 public:
  struct Vehicle {
    MotionLimits limits;              ///< limits of the reference; those of the configuration apply as well
    std::vector<NeighborView> views;  ///< fields of view of the sensors; empty: omnidirectional, of any range
    double encumbrance_m = 0.5;
    TimeNs period = 0;     ///< between updates
    bool planar = false;   ///< all planes are vertical
    int num_vehicles = 0;  ///< upper bound of neighbors, reserved in memory
    bool turns = true;     ///< the heading serves the sensor of neighbors
  };
  /// State at an update, in the local frame.
  struct Situation {
    const StateEstimate& estimate;
    std::span<const Neighbor> neighbors;
    SampleTiming timing;
    double z_min_m = 0.0, z_max_m = 0.0;  ///< heights of an evasion
    TimeNs now = 0;
  };
  /// Goal for the end of the period. The commanded goal moves linearly to it from the last one.
  struct Goal {
    Vector3 last_local_m = Vector3::Zero();
    Vector3 position_local_m = Vector3::Zero();
    double yaw_rad = 0.0;
    double speed_limit_mps = std::numeric_limits<double>::infinity();
  };

  NeighborSafety(const SeparationConfig& config, const Vehicle& vehicle);

  void start(const StateEstimate& estimate);

  /// Computes the planes of the next period.
  /// @param certain  ignores the uncertainty of neighbors, which may leave a vehicle no room to evade
  void update(const Situation& situation, bool certain = false);

  /// Half-spaces for the choice of a goal, relative to the vehicle. Neighbors unseen for long leave some room in them.
  std::span<const HalfSpace> planes() const { return cell_planes_; }
  /// The vehicle is beyond a plane, and has to leave at once.
  bool evades() const { return evades_; }

  /// Goal and heading that keep the vehicle within the planes. The heading keeps neighbors in view; the goal moves
  /// toward the point of rest until it is admissible.
  /// @param obstacles  further planes, which bound an evasion; relative to the vehicle
  Goal admit(const Situation& situation, Goal wanted, std::span<const HalfSpace> obstacles = {});

  /// Height of a planar vehicle above or below a neighbor that does not brake; empty: no evasion. A crowd may leave no
  /// room to evade in the plane; the horizontal distance to all others is kept meanwhile.
  /// @param height_m  of the plane
  std::optional<double> evasion_height_local_m(const Situation& situation, double height_m);

  /// Largest speed at which the vehicle can stop before a neighbor that enters the range of the sensors.
  double speed_limit_mps(const SampleTiming& timing) const;

  /// Advances the reference by one tick towards the goal; it keeps the motion limits.
  const Reference& step(const Reference& goal, double dt_s, double speed_limit_mps) {
    return reference_.step(goal, dt_s, speed_limit_mps);
  }

 private:
  void add_braking_plane(const Encounter& met, const Braking& other, const Situation& situation);
  void maybe_evade(const Encounter& met, const Braking& other, TimeNs now);
  void add_pledge_plane(const Encounter& met, const Situation& situation);
  void add(const HalfSpace& plane, double cell_offset_m);

  double sample_gap_s(const SampleTiming& timing) const;
  /// Uncertainty of the position at the last sample.
  double seen_reserve_m(const Encounter& met) const {
    return sigmas_ * met.sigma(met.neighbor.seen_covariance_local_m2);
  }
  bool is_pledged(const Neighbor& neighbor, const Situation& situation) const;
  Vector3 level(const Vector3& q_local) const {
    return vehicle_.planar ? Vector3(q_local.x(), q_local.y(), 0.0) : q_local;
  }

  SeparationConfig config_;
  Vehicle vehicle_;
  double distance_m_, vertical_m_;  // to keep
  double reaction_s_;               // delay before braking, including the period
  double range_m_;                  // shortest of the sensors
  GuardedReference reference_;
  NeighborSight sight_;

  // Results of the last update.
  Braking self_;                        // horizontal for a planar vehicle
  double sigmas_ = 0.0;                 // standard deviations by which neighbors count as nearer
  std::vector<HalfSpace> planes_;       // the vehicle comes to rest within them
  std::vector<HalfSpace> cell_planes_;  // for the choice of a goal
  bool evades_ = false;

  struct Passing {
    TimeNs t = -1;  // negative: none yet
    double height_local_m = 0.0;
  };
  Passing passing_;            // nearest neighbor that approached last without braking
  double passing_at_m_ = 0.0;  // its distance
  std::optional<bool> rises_;  // a planar vehicle leaves its plane upwards; empty: it does not
};

}  // namespace swiftlet
