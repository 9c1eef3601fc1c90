// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "core/interception/surroundings.hpp"
#include "core/interception/target_prediction.hpp"
#include "swiftlet/core/base/message.hpp"
#include "swiftlet/core/base/observation.hpp"
#include "swiftlet/core/base/track.hpp"
#include "swiftlet/core/messages/chase_report.hpp"

namespace swiftlet {

/// [m] Largest distance between two estimates of the same target. Larger values mistake another target for it.
inline constexpr double kSameTarget_m = 3.0;

/// Another interceptor, by its newest report. Local frame.
struct Teammate {
  ChaseReport::Status status = ChaseReport::Status::kIdle;
  TimeNs t = 0;  ///< time of the report
  double arrival_s = 0.0;
  PathAhead path;            ///< from the report's time on
  PointState target;         ///< at the report's time
  bool same_target = false;  ///< has the same target as this vehicle
  Vector3 offset_local_m =
      Vector3::Zero();  ///< displacement from the reported position to the track of the interceptor

  Vector3 at(TimeNs now) const { return path.at(to_seconds(now - t)); }
  PointState target_at(TimeNs now) const;
  /// True if the interceptor tracks a target and chases it.
  bool chases() const { return status == ChaseReport::Status::kLeads || status == ChaseReport::Status::kYields; }
  bool has_target() const { return chases() || status == ChaseReport::Status::kSearches; }
};

/// Team of interceptors after one target: the one with the earliest arrival leads, and the others keep clear of it
/// until it has missed. Decentralized: each decides from all reports.
class ChaseTeam {
 public:
  ChaseTeam(VehicleId self, int num_vehicles);

  /// Reads reports and drops interceptors that have been silent.
  void listen(const Observation& observation, const FrameChange& to_local);
  /// Associates tracks with interceptors: the nearest one to the reported position.
  /// @param target  id of the own target; 0: none
  void recognize(std::span<const Track> tracks, std::uint32_t target);
  bool is_teammate(std::uint32_t track) const;
  /// True if another interceptor leads the chase of the target at this position.
  bool has_leader(const Vector3& p_local_m, TimeNs now) const;
  /// Marks interceptors with the same target.
  /// @param tolerance_m  between both estimates
  void compare_targets(const Vector3& target_local_m, TimeNs now, double tolerance_m);

  /// The interceptor with the earliest arrival leads; a leader is replaced only by a clearly earlier one.
  /// @param arrival_s  own; empty: does not chase
  void decide(TimeNs now, std::optional<double> arrival_s);
  bool leads() const { return leads_; }
  bool yields() const { return leader_ != kNoVehicle && leader_ != self_; }
  /// Appends all interceptors as moving obstacles. A leader keeps half the clearance from yielding interceptors, which
  /// plan with more.
  void append_moving_obstacles(TimeNs now, double clearance_m, double yield_clearance_m,
                               std::vector<MovingObstacle>& moving_obstacles) const;
  /// True if a teammate has captured the own target.
  bool has_captured() const;
  /// Interceptor that tracks a target other than this vehicle; null: none.
  const Teammate* chasing(const Vector3& own_local_m, TimeNs now) const;

  bool is_report_due(TimeNs now) const { return !teammates_.empty() && now >= next_report_; }
  /// @param path  predicted path of the vehicle from now on. Local frame, like the target.
  void report(ChaseReport::Status status, TimeNs now, double arrival_s, const PointState& target, const PathAhead& path,
              const FrameChange& to_world, Outbox& outbox);

 private:
  struct Received {
    bool fresh = false;
    std::uint32_t track = 0;  // 0: not seen
    Teammate teammate;
  };

  VehicleId self_;
  std::vector<Received> teammates_;  // indexed by VehicleId; empty: no other vehicle
  VehicleId leader_ = kNoVehicle;
  bool leads_ = true;
  TimeNs next_report_ = 0;
  ChaseReport sent_, received_;  // kept to reuse their memory
};

}  // namespace swiftlet
