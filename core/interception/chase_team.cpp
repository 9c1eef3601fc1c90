// SPDX-License-Identifier: BSD-3-Clause
#include "core/interception/chase_team.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "swiftlet/core/messages/kind.hpp"

namespace swiftlet {
namespace {

using Word = ChaseReport::Word;

constexpr double kSilent_s = 1.0;  // age beyond which a report is ignored
// Plausible interval between path points in a report; reports with other intervals are rejected.
constexpr double kShortest_s = 0.01, kLongest_s = 10.0;
// Bounds of plausible times, coordinates and velocities in a report.
constexpr double kLatest_s = 1e4, kFarthest_m = 1e6, kFastest_mps = 1e3;
constexpr double kSay_s = 0.1;       // period of reports
constexpr double kLeadHold_s = 0.3;  // advantage in arrival time that another interceptor needs to take the lead
// Distance between a report and a track up to which the track is that interceptor, for any track and for the own
// target's.
constexpr double kSeenAt_m = 2.5, kIs_m = 1.0;
constexpr double kLeaderShare = 0.5;  // share of the clearance that a leader keeps from yielding interceptors

/// Rejects implausible reports, since a radio may deliver anything.
bool makes_sense(const ChaseReport& report) {
  const auto is_near = [](const auto& p_m) { return p_m.cwiseAbs().maxCoeff() < kFarthest_m; };
  return !report.places.empty() && report.interval_s >= kShortest_s && report.interval_s <= kLongest_s &&
         std::abs(report.arrival_s) <= kLatest_s && is_near(report.target_world_m) &&
         report.target_world_mps.cwiseAbs().maxCoeff() < kFastest_mps &&
         std::all_of(report.places.begin(), report.places.end(),
                     [&](const ChaseReport::Place& place) { return is_near(place.p_world_m); });
}

}  // namespace

PointState Fellow::target_at(TimeNs now) const {
  return {target.p_m + to_seconds(now - t) * target.v_mps, target.v_mps, Vector3::Zero()};
}

ChaseTeam::ChaseTeam(VehicleId self, int num_vehicles) : self_(self) {
  if (num_vehicles > 1) fellows_.resize(static_cast<std::size_t>(num_vehicles));
}

void ChaseTeam::listen(const Observation& observation, const FrameChange& to_local) {
  for (const Message& message : observation.messages) {
    if (message.from == self_ || message.from < 0 || message.from >= static_cast<VehicleId>(fellows_.size())) continue;
    if (read_message(message, heard_) != Reading::kDone) continue;
    if (heard_.t > observation.t || heard_.t < observation.t - from_seconds(kSilent_s) || !makes_sense(heard_))
      continue;
    Heard& heard = fellows_[static_cast<std::size_t>(message.from)];
    if (heard.fresh && heard_.t < heard.fellow.t) continue;
    heard.fresh = true;
    Fellow& fellow = heard.fellow;
    fellow.word = heard_.word;
    fellow.t = heard_.t;
    fellow.arrival_s = heard_.arrival_s;
    fellow.target.p_m = to_local.point(heard_.target_world_m);
    fellow.target.v_mps = to_local.direction(heard_.target_world_mps);
    fellow.path.interval_s = heard_.interval_s;
    fellow.path.num_places = std::min(static_cast<int>(heard_.places.size()), PathAhead::kMaxPlaces);
    for (int i = 0; i < fellow.path.num_places; ++i) {
      const auto place = static_cast<std::size_t>(i);
      fellow.path.places_local_m[place] = to_local.point(heard_.places[place].p_world_m.cast<double>());
    }
  }
  for (Heard& heard : fellows_) heard.fresh = heard.fresh && to_seconds(observation.t - heard.fellow.t) < kSilent_s;
}

void ChaseTeam::recognize(std::span<const Track> tracks, std::uint32_t target) {
  for (Heard& heard : fellows_) {
    heard.track = 0;
    heard.fellow.off_local_m.setZero();
    if (!heard.fresh) continue;
    double nearest_m = std::numeric_limits<double>::infinity();
    for (const Track& track : tracks) {
      const Vector3 off_m = track.position_m - heard.fellow.at(track.t);
      if (off_m.norm() > (track.id == target ? kIs_m : kSeenAt_m) || off_m.norm() >= nearest_m) continue;
      nearest_m = off_m.norm();
      heard.track = track.id;
      heard.fellow.off_local_m = off_m;
    }
  }
}

bool ChaseTeam::is_fellow(std::uint32_t track) const {
  return std::any_of(fellows_.begin(), fellows_.end(),
                     [track](const Heard& heard) { return heard.fresh && heard.track != 0 && heard.track == track; });
}

bool ChaseTeam::is_led(const Vector3& p_local_m, TimeNs now) const {
  return std::any_of(fellows_.begin(), fellows_.end(), [&](const Heard& heard) {
    return heard.fresh && heard.fellow.word == Word::kLeads &&
           (heard.fellow.target_at(now).p_m - p_local_m).norm() < kSameTarget_m;
  });
}

void ChaseTeam::compare_targets(const Vector3& target_local_m, TimeNs now, double tolerance_m) {
  for (Heard& heard : fellows_) {
    Fellow& fellow = heard.fellow;
    if (!heard.fresh || !fellow.has_target()) continue;
    fellow.same_target = (fellow.target_at(now).p_m - target_local_m).norm() < tolerance_m;
  }
}

void ChaseTeam::decide(TimeNs now, std::optional<double> arrival_s) {
  const auto rank_s = [](double arrives_s, bool leads) { return arrives_s - (leads ? kLeadHold_s : 0.0); };
  leader_ = arrival_s ? self_ : kNoVehicle;
  double least_s = arrival_s ? rank_s(*arrival_s, leads_) : std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < fellows_.size(); ++i) {
    const Fellow& fellow = fellows_[i].fellow;
    if (!fellows_[i].fresh || !fellow.same_target || !fellow.chases()) continue;
    // A leader has come nearer since its report, a yielding interceptor has not.
    const bool led = fellow.word == Word::kLeads;
    const double its_s = rank_s(fellow.arrival_s - (led ? to_seconds(now - fellow.t) : 0.0), led);
    const auto id = static_cast<VehicleId>(i);
    if (its_s > least_s || (its_s == least_s && leader_ != kNoVehicle && leader_ < id)) continue;
    least_s = its_s;
    leader_ = id;
  }
  leads_ = leader_ == self_;
}

void ChaseTeam::append_bystanders(TimeNs now, double clearance_m, double yield_clearance_m,
                                  std::vector<Bystander>& bystanders) const {
  for (std::size_t i = 0; i < fellows_.size(); ++i) {
    const Fellow& fellow = fellows_[i].fellow;
    if (!fellows_[i].fresh || bystanders.size() == bystanders.capacity()) continue;
    const double age_s = to_seconds(now - fellow.t);
    const bool yields = leads_ && fellow.same_target && fellow.word != Word::kCaught;
    Bystander bystander;
    bystander.p_local_m = fellow.at(now) + fellow.off_local_m;
    bystander.v_local_mps = fellow.path.velocity_mps(age_s);
    bystander.radius_m = yields ? kLeaderShare * clearance_m : clearance_m;
    if (leader_ == static_cast<VehicleId>(i)) bystander.plan_room_m = std::max(0.0, yield_clearance_m - clearance_m);
    bystander.path = &fellow.path;
    bystander.path_age_s = age_s;
    bystanders.push_back(bystander);
  }
}

bool ChaseTeam::has_caught() const {
  return std::any_of(fellows_.begin(), fellows_.end(), [](const Heard& heard) {
    return heard.fresh && heard.fellow.same_target && heard.fellow.word == Word::kCaught;
  });
}

const Fellow* ChaseTeam::chasing(const Vector3& own_local_m, TimeNs now) const {
  for (const Heard& heard : fellows_) {
    if (!heard.fresh || !heard.fellow.chases()) continue;
    if ((heard.fellow.target_at(now).p_m - own_local_m).norm() > kSameTarget_m) return &heard.fellow;
  }
  return nullptr;
}

void ChaseTeam::tell(ChaseReport::Word word, TimeNs now, double arrival_s, const PointState& target,
                     const PathAhead& path, const FrameChange& to_world, Outbox& outbox) {
  next_word_ = now + from_seconds(kSay_s);
  said_.t = now;
  said_.word = word;
  said_.arrival_s = arrival_s;
  said_.target_world_m = to_world.point(target.p_m);
  said_.target_world_mps = to_world.direction(target.v_mps);
  said_.interval_s = path.interval_s;
  said_.places.clear();
  for (int i = 0; i < path.num_places; ++i) {
    said_.places.push_back({to_world.point(path.places_local_m[static_cast<std::size_t>(i)]).cast<float>()});
  }
  write_message(said_, outbox.say());
}

}  // namespace swiftlet
