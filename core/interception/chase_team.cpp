// SPDX-License-Identifier: BSD-3-Clause
#include "core/interception/chase_team.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "swiftlet/core/messages/kind.hpp"

namespace swiftlet {
namespace {

using Status = ChaseReport::Status;

struct TeamTuning {
  /// [s] Age from which a report is ignored. Larger values bridge longer dropouts of the radio, but keep the vehicle
  /// clear of outdated positions.
  double report_timeout_s = 1.0;
  /// [s] Period of reports. Smaller values give teammates fresher paths, but load the radio.
  double report_period_s = 0.1;
  /// [s] Advantage in arrival time at the target that another interceptor needs to take the lead. At 0 the lead
  /// alternates between vehicles with similar arrival times; larger values keep a slower leader.
  double lead_hold_s = 0.3;
  /// [m] Largest distance between a teammate's reported position and the track associated with the teammate. The second
  /// gate applies to the track of the own target, which may hang in the teammate's net, close to the teammate. Larger
  /// gates mistake intruders near a teammate for the teammate.
  double track_gate_m = 2.5, target_gate_m = 1.0;
  /// [-] Share of the clearance that a leader keeps from yielding interceptors. At 1 they can block its path to the
  /// target; smaller values reduce the margin against collisions.
  double leader_share = 0.5;
  // Bounds of plausible reports; others are rejected. Far beyond any real flight, so that they only reject corrupt
  // ones.
  double min_interval_s = 0.01, max_interval_s = 10.0;  ///< [s] interval between path points
  double max_arrival_s = 1e4;                           ///< [s] magnitude of the time until arrival
  double max_coordinate_m = 1e6;                        ///< [m] magnitude of the coordinates of positions
  double max_speed_mps = 1e3;                           ///< [m/s] magnitude of the components of the target's velocity
};
constexpr TeamTuning kTeam;

/// False for reports that no interceptor sends, such as corrupt ones; received messages are not trusted.
bool is_plausible(const ChaseReport& report) {
  const auto is_near = [](const auto& p_m) { return p_m.cwiseAbs().maxCoeff() < kTeam.max_coordinate_m; };
  return !report.places.empty() && report.interval_s >= kTeam.min_interval_s &&
         report.interval_s <= kTeam.max_interval_s && std::abs(report.arrival_s) <= kTeam.max_arrival_s &&
         is_near(report.target_world_m) && report.target_world_mps.cwiseAbs().maxCoeff() < kTeam.max_speed_mps &&
         std::all_of(report.places.begin(), report.places.end(),
                     [&](const ChaseReport::Place& place) { return is_near(place.p_world_m); });
}

}  // namespace

PointState Teammate::target_at(TimeNs now) const {
  return {target.p_m + to_seconds(now - t) * target.v_mps, target.v_mps, Vector3::Zero()};
}

ChaseTeam::ChaseTeam(VehicleId self, int num_vehicles) : self_(self) {
  if (num_vehicles > 1) teammates_.resize(static_cast<std::size_t>(num_vehicles));
}

void ChaseTeam::listen(const Observation& observation, const FrameChange& to_local) {
  for (const Message& message : observation.messages) {
    if (message.from == self_ || message.from < 0 || message.from >= static_cast<VehicleId>(teammates_.size()))
      continue;
    if (read_message(message, received_) != Reading::kDone) continue;
    if (received_.t > observation.t || received_.t < observation.t - from_seconds(kTeam.report_timeout_s) ||
        !is_plausible(received_))
      continue;
    Received& received = teammates_[static_cast<std::size_t>(message.from)];
    if (received.fresh && received_.t < received.teammate.t) continue;
    received.fresh = true;
    Teammate& teammate = received.teammate;
    teammate.status = received_.status;
    teammate.t = received_.t;
    teammate.arrival_s = received_.arrival_s;
    teammate.target.p_m = to_local.point(received_.target_world_m);
    teammate.target.v_mps = to_local.direction(received_.target_world_mps);
    teammate.path.interval_s = received_.interval_s;
    teammate.path.num_places = std::min(static_cast<int>(received_.places.size()), PathAhead::kMaxPlaces);
    for (int i = 0; i < teammate.path.num_places; ++i) {
      const auto place = static_cast<std::size_t>(i);
      teammate.path.places_local_m[place] = to_local.point(received_.places[place].p_world_m.cast<double>());
    }
  }
  for (Received& received : teammates_)
    received.fresh = received.fresh && to_seconds(observation.t - received.teammate.t) < kTeam.report_timeout_s;
}

void ChaseTeam::recognize(std::span<const Track> tracks, std::uint32_t target) {
  for (Received& received : teammates_) {
    received.track = 0;
    received.teammate.offset_local_m.setZero();
    if (!received.fresh) continue;
    double nearest_m = std::numeric_limits<double>::infinity();
    for (const Track& track : tracks) {
      const Vector3 offset_m = track.position_m - received.teammate.at(track.t);
      if (offset_m.norm() > (track.id == target ? kTeam.target_gate_m : kTeam.track_gate_m) ||
          offset_m.norm() >= nearest_m)
        continue;
      nearest_m = offset_m.norm();
      received.track = track.id;
      received.teammate.offset_local_m = offset_m;
    }
  }
}

bool ChaseTeam::is_teammate(std::uint32_t track) const {
  return std::any_of(teammates_.begin(), teammates_.end(), [track](const Received& received) {
    return received.fresh && received.track != 0 && received.track == track;
  });
}

bool ChaseTeam::has_leader(const Vector3& p_local_m, TimeNs now) const {
  return std::any_of(teammates_.begin(), teammates_.end(), [&](const Received& received) {
    return received.fresh && received.teammate.status == Status::kLeads &&
           (received.teammate.target_at(now).p_m - p_local_m).norm() < kSameTarget_m;
  });
}

void ChaseTeam::compare_targets(const Vector3& target_local_m, TimeNs now, double tolerance_m) {
  for (Received& received : teammates_) {
    Teammate& teammate = received.teammate;
    if (!received.fresh || !teammate.has_target()) continue;
    teammate.same_target = (teammate.target_at(now).p_m - target_local_m).norm() < tolerance_m;
  }
}

void ChaseTeam::decide(TimeNs now, std::optional<double> arrival_s) {
  const auto rank_s = [](double arrives_s, bool leads) { return arrives_s - (leads ? kTeam.lead_hold_s : 0.0); };
  leader_ = arrival_s ? self_ : kNoVehicle;
  double least_s = arrival_s ? rank_s(*arrival_s, leads_) : std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < teammates_.size(); ++i) {
    const Teammate& teammate = teammates_[i].teammate;
    if (!teammates_[i].fresh || !teammate.same_target || !teammate.chases()) continue;
    // Since its report a leader has approached the target; a yielding interceptor has not.
    const bool was_leading = teammate.status == Status::kLeads;
    const double teammate_s =
        rank_s(teammate.arrival_s - (was_leading ? to_seconds(now - teammate.t) : 0.0), was_leading);
    const auto id = static_cast<VehicleId>(i);
    if (teammate_s > least_s || (teammate_s == least_s && leader_ != kNoVehicle && leader_ < id)) continue;
    least_s = teammate_s;
    leader_ = id;
  }
  leads_ = leader_ == self_;
}

void ChaseTeam::append_moving_obstacles(TimeNs now, double clearance_m, double yield_clearance_m,
                                        std::vector<MovingObstacle>& moving_obstacles) const {
  for (std::size_t i = 0; i < teammates_.size(); ++i) {
    const Teammate& teammate = teammates_[i].teammate;
    if (!teammates_[i].fresh || moving_obstacles.size() == moving_obstacles.capacity()) continue;
    const double age_s = to_seconds(now - teammate.t);
    const bool yields = leads_ && teammate.same_target && teammate.status != Status::kCaptured;
    MovingObstacle obstacle;
    obstacle.p_local_m = teammate.at(now) + teammate.offset_local_m;
    obstacle.v_local_mps = teammate.path.velocity_mps(age_s);
    obstacle.radius_m = yields ? kTeam.leader_share * clearance_m : clearance_m;
    if (leader_ == static_cast<VehicleId>(i)) obstacle.plan_room_m = std::max(0.0, yield_clearance_m - clearance_m);
    obstacle.path = &teammate.path;
    obstacle.path_age_s = age_s;
    moving_obstacles.push_back(obstacle);
  }
}

bool ChaseTeam::has_captured() const {
  return std::any_of(teammates_.begin(), teammates_.end(), [](const Received& received) {
    return received.fresh && received.teammate.same_target && received.teammate.status == Status::kCaptured;
  });
}

const Teammate* ChaseTeam::chasing(const Vector3& own_local_m, TimeNs now) const {
  for (const Received& received : teammates_) {
    if (!received.fresh || !received.teammate.chases()) continue;
    if ((received.teammate.target_at(now).p_m - own_local_m).norm() > kSameTarget_m) return &received.teammate;
  }
  return nullptr;
}

void ChaseTeam::report(ChaseReport::Status status, TimeNs now, double arrival_s, const PointState& target,
                       const PathAhead& path, const FrameChange& to_world, Outbox& outbox) {
  next_report_ = now + from_seconds(kTeam.report_period_s);
  sent_.t = now;
  sent_.status = status;
  sent_.arrival_s = arrival_s;
  sent_.target_world_m = to_world.point(target.p_m);
  sent_.target_world_mps = to_world.direction(target.v_mps);
  sent_.interval_s = path.interval_s;
  sent_.places.clear();
  for (int i = 0; i < path.num_places; ++i) {
    sent_.places.push_back({to_world.point(path.places_local_m[static_cast<std::size_t>(i)]).cast<float>()});
  }
  write_message(sent_, outbox.add());
}

}  // namespace swiftlet
