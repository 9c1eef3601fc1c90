// SPDX-License-Identifier: BSD-3-Clause
#include "core/interception/chase_team.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "swiftlet/core/messages/kind.hpp"

namespace swiftlet {
namespace {

using Status = ChaseReport::Status;

constexpr double kReportTimeout_s = 1.0;  // age beyond which a report is ignored
// Plausible interval between path points in a report; reports with other intervals are rejected.
constexpr double kShortest_s = 0.01, kLongest_s = 10.0;
// Bounds of plausible times, coordinates and velocities in a report.
constexpr double kLatest_s = 1e4, kFarthest_m = 1e6, kFastest_mps = 1e3;
constexpr double kReportPeriod_s = 0.1;  // period of reports
constexpr double kLeadHold_s = 0.3;      // advantage in arrival time that another interceptor needs to take the lead
// Largest distance between a report and a track for the track to be that interceptor's: of any track, and of the own
// target's.
constexpr double kSeenAt_m = 2.5, kIs_m = 1.0;
constexpr double kLeaderShare = 0.5;  // share of the clearance that a leader keeps from yielding interceptors

/// Rejects implausible reports, since a radio may deliver anything.
bool is_plausible(const ChaseReport& report) {
  const auto is_near = [](const auto& p_m) { return p_m.cwiseAbs().maxCoeff() < kFarthest_m; };
  return !report.places.empty() && report.interval_s >= kShortest_s && report.interval_s <= kLongest_s &&
         std::abs(report.arrival_s) <= kLatest_s && is_near(report.target_world_m) &&
         report.target_world_mps.cwiseAbs().maxCoeff() < kFastest_mps &&
         std::all_of(report.places.begin(), report.places.end(),
                     [&](const ChaseReport::Place& place) { return is_near(place.p_world_m); });
}

}  // namespace

PointState ChasePeer::target_at(TimeNs now) const {
  return {target.p_m + to_seconds(now - t) * target.v_mps, target.v_mps, Vector3::Zero()};
}

ChaseTeam::ChaseTeam(VehicleId self, int num_vehicles) : self_(self) {
  if (num_vehicles > 1) peers_.resize(static_cast<std::size_t>(num_vehicles));
}

void ChaseTeam::listen(const Observation& observation, const FrameChange& to_local) {
  for (const Message& message : observation.messages) {
    if (message.from == self_ || message.from < 0 || message.from >= static_cast<VehicleId>(peers_.size())) continue;
    if (read_message(message, received_) != Reading::kDone) continue;
    if (received_.t > observation.t || received_.t < observation.t - from_seconds(kReportTimeout_s) ||
        !is_plausible(received_))
      continue;
    Received& received = peers_[static_cast<std::size_t>(message.from)];
    if (received.fresh && received_.t < received.peer.t) continue;
    received.fresh = true;
    ChasePeer& peer = received.peer;
    peer.status = received_.status;
    peer.t = received_.t;
    peer.arrival_s = received_.arrival_s;
    peer.target.p_m = to_local.point(received_.target_world_m);
    peer.target.v_mps = to_local.direction(received_.target_world_mps);
    peer.path.interval_s = received_.interval_s;
    peer.path.num_places = std::min(static_cast<int>(received_.places.size()), PathAhead::kMaxPlaces);
    for (int i = 0; i < peer.path.num_places; ++i) {
      const auto place = static_cast<std::size_t>(i);
      peer.path.places_local_m[place] = to_local.point(received_.places[place].p_world_m.cast<double>());
    }
  }
  for (Received& received : peers_)
    received.fresh = received.fresh && to_seconds(observation.t - received.peer.t) < kReportTimeout_s;
}

void ChaseTeam::recognize(std::span<const Track> tracks, std::uint32_t target) {
  for (Received& received : peers_) {
    received.track = 0;
    received.peer.off_local_m.setZero();
    if (!received.fresh) continue;
    double nearest_m = std::numeric_limits<double>::infinity();
    for (const Track& track : tracks) {
      const Vector3 off_m = track.position_m - received.peer.at(track.t);
      if (off_m.norm() > (track.id == target ? kIs_m : kSeenAt_m) || off_m.norm() >= nearest_m) continue;
      nearest_m = off_m.norm();
      received.track = track.id;
      received.peer.off_local_m = off_m;
    }
  }
}

bool ChaseTeam::is_peer(std::uint32_t track) const {
  return std::any_of(peers_.begin(), peers_.end(), [track](const Received& received) {
    return received.fresh && received.track != 0 && received.track == track;
  });
}

bool ChaseTeam::is_led(const Vector3& p_local_m, TimeNs now) const {
  return std::any_of(peers_.begin(), peers_.end(), [&](const Received& received) {
    return received.fresh && received.peer.status == Status::kLeads &&
           (received.peer.target_at(now).p_m - p_local_m).norm() < kSameTarget_m;
  });
}

void ChaseTeam::compare_targets(const Vector3& target_local_m, TimeNs now, double tolerance_m) {
  for (Received& received : peers_) {
    ChasePeer& peer = received.peer;
    if (!received.fresh || !peer.has_target()) continue;
    peer.same_target = (peer.target_at(now).p_m - target_local_m).norm() < tolerance_m;
  }
}

void ChaseTeam::decide(TimeNs now, std::optional<double> arrival_s) {
  const auto rank_s = [](double arrives_s, bool leads) { return arrives_s - (leads ? kLeadHold_s : 0.0); };
  leader_ = arrival_s ? self_ : kNoVehicle;
  double least_s = arrival_s ? rank_s(*arrival_s, leads_) : std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < peers_.size(); ++i) {
    const ChasePeer& peer = peers_[i].peer;
    if (!peers_[i].fresh || !peer.same_target || !peer.chases()) continue;
    // A leader has come nearer since its report, a yielding interceptor has not.
    const bool led = peer.status == Status::kLeads;
    const double its_s = rank_s(peer.arrival_s - (led ? to_seconds(now - peer.t) : 0.0), led);
    const auto id = static_cast<VehicleId>(i);
    if (its_s > least_s || (its_s == least_s && leader_ != kNoVehicle && leader_ < id)) continue;
    least_s = its_s;
    leader_ = id;
  }
  leads_ = leader_ == self_;
}

void ChaseTeam::append_moving_obstacles(TimeNs now, double clearance_m, double yield_clearance_m,
                                        std::vector<MovingObstacle>& moving_obstacles) const {
  for (std::size_t i = 0; i < peers_.size(); ++i) {
    const ChasePeer& peer = peers_[i].peer;
    if (!peers_[i].fresh || moving_obstacles.size() == moving_obstacles.capacity()) continue;
    const double age_s = to_seconds(now - peer.t);
    const bool yields = leads_ && peer.same_target && peer.status != Status::kCaught;
    MovingObstacle obstacle;
    obstacle.p_local_m = peer.at(now) + peer.off_local_m;
    obstacle.v_local_mps = peer.path.velocity_mps(age_s);
    obstacle.radius_m = yields ? kLeaderShare * clearance_m : clearance_m;
    if (leader_ == static_cast<VehicleId>(i)) obstacle.plan_room_m = std::max(0.0, yield_clearance_m - clearance_m);
    obstacle.path = &peer.path;
    obstacle.path_age_s = age_s;
    moving_obstacles.push_back(obstacle);
  }
}

bool ChaseTeam::has_caught() const {
  return std::any_of(peers_.begin(), peers_.end(), [](const Received& received) {
    return received.fresh && received.peer.same_target && received.peer.status == Status::kCaught;
  });
}

const ChasePeer* ChaseTeam::chasing(const Vector3& own_local_m, TimeNs now) const {
  for (const Received& received : peers_) {
    if (!received.fresh || !received.peer.chases()) continue;
    if ((received.peer.target_at(now).p_m - own_local_m).norm() > kSameTarget_m) return &received.peer;
  }
  return nullptr;
}

void ChaseTeam::report(ChaseReport::Status status, TimeNs now, double arrival_s, const PointState& target,
                       const PathAhead& path, const FrameChange& to_world, Outbox& outbox) {
  next_report_ = now + from_seconds(kReportPeriod_s);
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
