// SPDX-License-Identifier: BSD-3-Clause
#include "sharing_log.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "detection_flights.hpp"
#include "swiftlet/core/action.hpp"
#include "swiftlet/core/ensure.hpp"
#include "swiftlet/core/tracking/trackers.hpp"
#include "swiftlet/sim/raycast/ray_scene.hpp"

namespace swiftlet::tools {
namespace {

constexpr double kSharedTruePositive_m = 3.0;  // [Vrba 2025, sec. V-A]
constexpr double kSharedFollowed_m = 1.0;      // a track nearer than this follows the vehicle
constexpr double kSharedFarthest_m = 40.0;
constexpr TimeNs kFramesEvery = kNsPerSecond / 2;
const Vector3 kSensor_body_m = {0.0, 0.0, 0.15};

template <class Row>
constexpr std::size_t kFields = sizeof(Row) / sizeof(double);

template <class Row>
void write_rows(const std::vector<Row>& rows, std::vector<double>& numbers) {
  numbers.push_back(static_cast<double>(rows.size()));
  for (const Row& row : rows) {
    const auto* first = reinterpret_cast<const double*>(&row);
    numbers.insert(numbers.end(), first, first + kFields<Row>);
  }
}

template <class Row>
void read_rows(std::span<const double>& numbers, std::vector<Row>& rows) {
  rows.resize(static_cast<std::size_t>(numbers.front()));
  numbers = numbers.subspan(1);
  for (Row& row : rows) {
    std::copy_n(numbers.begin(), kFields<Row>, reinterpret_cast<double*>(&row));
    numbers = numbers.subspan(kFields<Row>);
  }
}

}  // namespace

struct SharingLog::Team {
  struct Member {
    std::size_t vehicle = 0;
    std::unique_ptr<Tracker> tracker;
    Observation observation;
    std::vector<Track> told;
    std::vector<Message> said;
    std::set<std::uint32_t> ids, true_ids;  // identities of reported tracks; true_ids: near a vehicle
  };

  Team(const SharingTeam& team, const sim::Scenario& scenario, const SharedTracksConfig& sharing)
      : radio(team.radio, scenario.seed, names_of(scenario), nullptr) {
    members.resize(team.members.size());
    for (std::size_t k = 0; k < members.size(); ++k) {
      members[k].vehicle = team.members[k];
      AgentSetup setup;
      setup.self = static_cast<VehicleId>(team.members[k]);
      setup.num_vehicles = static_cast<int>(scenario.vehicles.size());
      setup.vehicle_names = names_of(scenario);
      members[k].tracker = make_shared_tracks(sharing, setup, make_detector_tracks(DetectorTracksConfig{}, setup));
    }
  }

  static std::vector<std::string> names_of(const sim::Scenario& scenario) {
    std::vector<std::string> names;
    for (const auto& vehicle : scenario.vehicles) names.push_back(vehicle.name);
    return names;
  }

  sim::Radio radio;
  std::vector<Member> members;
  TimeNs next_frames = 0;
};

SharingLog::SharingLog(const sim::Scenario& scenario, std::vector<std::size_t> observers,
                       std::vector<std::size_t> targets, std::vector<SharingTeam> teams,
                       const SharedTracksConfig& sharing, double ignored_s)
    : observers_(std::move(observers)),
      targets_(std::move(targets)),
      world_(sim::build_world(scenario.world, scenario.seed)),
      ignored_(from_seconds(ignored_s)),
      records_(teams.size()) {
  for (const SharingTeam& team : teams) teams_.push_back(std::make_unique<Team>(team, scenario, sharing));
}

SharingLog::~SharingLog() = default;

void SharingLog::add(const sim::Simulation& simulation) {
  const sim::TickView& view = simulation.view();
  Truth truth;
  truth.t = view.t;
  for (const sim::VehicleState& state : view.states) truth.p_m.push_back(state.p_world_m);
  for (const std::size_t observer : observers_) {
    const sim::VehicleState& own = view.states[observer];
    truth.R_world_body.push_back(own.q_world_body.toRotationMatrix());
    truth.p_sensor_m.push_back(own.p_world_m + truth.R_world_body.back() * kSensor_body_m);
    truth.T_estimate_truth.push_back(view.actions[observer]->estimate.T_world_body() * own.T_world_body().inverse());
  }
  truth_.push_back(std::move(truth));

  for (std::size_t i = 0; i < teams_.size(); ++i) {
    Team& team = *teams_[i];
    for (std::size_t k = 0; k < team.members.size(); ++k) {
      Team::Member& member = team.members[k];
      const Action& action = *view.actions[member.vehicle];
      member.said.clear();
      if (!action.estimate.valid) continue;
      ENSURE(action.estimate.correction_revision == 0);  // world and local frame coincide
      member.observation.t = view.t;
      member.observation.self = static_cast<VehicleId>(member.vehicle);
      member.observation.messages.clear();
      team.radio.deliver(member.observation.self, view.t, member.observation.messages);
      TrackerInput input{.observation = member.observation, .estimate = action.estimate};
      input.has_detections = action.has_detections;
      input.detections = action.detections;
      input.detector_tracks = action.tracks;
      Outbox outbox(member.observation.self);
      const bool told = member.tracker->step(input, member.told, outbox);
      outbox.empty_into(member.said);
      if (told && view.t >= ignored_) judge(i, k, view.t);
    }
    for (const Team::Member& member : team.members) {
      for (const Message& message : member.said) {
        records_[i].largest_message = std::max(records_[i].largest_message, static_cast<double>(message.size_bytes()));
      }
      team.radio.post(static_cast<VehicleId>(member.vehicle), view.t, member.said, view.states);
    }
    if (view.t >= team.next_frames) {
      for (std::size_t k = 0; k < team.members.size(); ++k) judge_frames(i, k, view);
      team.next_frames = view.t + kFramesEvery;
    }
    records_[i].bytes = static_cast<double>(team.radio.statistics().bytes_sent);
    records_[i].flown_s = to_seconds(view.t);
  }
}

const SharingLog::Truth& SharingLog::at(TimeNs t) const {
  const auto after =
      std::lower_bound(truth_.begin(), truth_.end(), t, [](const Truth& truth, TimeNs time) { return truth.t < time; });
  if (after == truth_.end()) return truth_.back();
  if (after == truth_.begin() || after->t - t < t - (after - 1)->t) return *after;
  return *(after - 1);
}

/// Whether the target is in range, in the field of view of a Mid-360, and not occluded.
bool SharingLog::can_see(std::size_t observer, std::size_t target, const Truth& truth) const {
  const Vector3 p_m = truth.p_m[target];
  const Vector3 d_body = truth.R_world_body[observer].transpose() * (p_m - truth.p_sensor_m[observer]);
  const double range_m = d_body.norm(), sine = d_body.z() / range_m;
  constexpr double kRad = std::numbers::pi / 180.0;
  return range_m < kSharedFarthest_m && sine > std::sin(kMid360Bottom_deg * kRad) &&
         sine < std::sin(kMid360Top_deg * kRad) && !world_.static_scene->occluded(truth.p_sensor_m[observer], p_m);
}

void SharingLog::judge(std::size_t i, std::size_t k, TimeNs now) {
  Team::Member& member = teams_[i]->members[k];
  const std::size_t own =
      static_cast<std::size_t>(std::find(observers_.begin(), observers_.end(), member.vehicle) - observers_.begin());
  const TimeNs t = member.told.empty() ? now - kNsPerSecond / 10 : member.told.front().t;  // all tracks have one time
  const Truth& truth = at(t);
  const Pose& T_estimate_truth = truth.T_estimate_truth[own];
  const auto off_m = [&](std::size_t vehicle, const Track& track) {
    return (track.position_m - T_estimate_truth * truth.p_m[vehicle]).norm();
  };

  // Greedy assignment by distance: at most one track for each target.
  constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();
  std::vector<std::size_t> track_of(targets_.size(), kNone);
  std::vector<char> taken(member.told.size(), 0);
  for (std::size_t round = 0; round < targets_.size(); ++round) {
    std::size_t best_target = kNone, best_track = kNone;
    double least_m = kSharedTruePositive_m;
    for (std::size_t a = 0; a < targets_.size(); ++a) {
      for (std::size_t b = 0; b < member.told.size(); ++b) {
        if (track_of[a] != kNone || taken[b] || off_m(targets_[a], member.told[b]) >= least_m) continue;
        least_m = off_m(targets_[a], member.told[b]);
        best_target = a;
        best_track = b;
      }
    }
    if (best_target == kNone) break;
    track_of[best_target] = best_track;
    taken[best_track] = 1;
  }

  SharedScan scan;
  scan.t_s = to_seconds(t);
  scan.receiver = static_cast<double>(member.vehicle);
  scan.told = static_cast<double>(member.told.size());
  for (std::size_t b = 0; b < member.told.size(); ++b) {
    const Track& track = member.told[b];
    member.ids.insert(track.id);
    bool near_any = false, near_target = false, near_mate = false, near_other = false;
    for (std::size_t vehicle = 0; vehicle < truth.p_m.size(); ++vehicle) {
      near_any = near_any || (vehicle != member.vehicle && off_m(vehicle, track) < kSharedFollowed_m);
    }
    for (const std::size_t target : targets_) near_target = near_target || off_m(target, track) < kSharedTruePositive_m;
    for (const std::size_t observer : observers_) {
      const bool is_mate = std::any_of(teams_[i]->members.begin(), teams_[i]->members.end(),
                                       [&](const Team::Member& m) { return m.vehicle == observer; });
      if (off_m(observer, track) < kSharedTruePositive_m) (is_mate ? near_mate : near_other) = true;
    }
    if (near_any) member.true_ids.insert(track.id);
    if (taken[b]) continue;
    if (near_mate) {
      scan.mates += 1.0;
    } else if (near_other) {
      scan.others += 1.0;
    } else {
      (near_target ? scan.second : scan.nobodys) += 1.0;
    }
  }
  TeamRecord& record = records_[i];
  record.scans.push_back(scan);
  record.false_tracks = 0.0;
  for (const Team::Member& each : teams_[i]->members) {
    record.false_tracks += static_cast<double>(each.ids.size() - each.true_ids.size());
  }

  for (std::size_t a = 0; a < targets_.size(); ++a) {
    SharedSighting s;
    s.nearest_m = std::numeric_limits<double>::infinity();
    for (std::size_t observer = 0; observer < observers_.size(); ++observer) {
      const double range_m = (truth.p_m[targets_[a]] - truth.p_sensor_m[observer]).norm();
      const bool sees = can_see(observer, targets_[a], truth);
      if (sees) s.nearest_m = std::min(s.nearest_m, range_m);
      if (observer != own) continue;
      s.in_own_view = sees;
      s.own_range_m = range_m;
    }
    if (!std::isfinite(s.nearest_m)) continue;  // out of view of all observers
    s.t_s = to_seconds(t);
    s.receiver = scan.receiver;
    s.target = static_cast<double>(targets_[a]);
    s.found = track_of[a] != kNone;
    if (track_of[a] != kNone) {
      s.error_m = off_m(targets_[a], member.told[track_of[a]]);
      s.track = member.told[track_of[a]].id;
    }
    record.sightings.push_back(s);
  }
}

void SharingLog::judge_frames(std::size_t i, std::size_t k, const sim::TickView& view) {
  const Team::Member& member = teams_[i]->members[k];
  const auto index = [&](std::size_t vehicle) {
    return static_cast<std::size_t>(std::find(observers_.begin(), observers_.end(), vehicle) - observers_.begin());
  };
  std::vector<RelativeEstimate> relatives;
  member.tracker->append_relatives(view.t, relatives);
  const std::size_t own = index(member.vehicle);
  for (const RelativeEstimate& relative : relatives) {
    const auto other = static_cast<std::size_t>(relative.other);
    const Truth& then = at(relative.heard);  // at the time of its message: its motion since then is no error
    const Pose &T_own = then.T_estimate_truth[own], &T_other = then.T_estimate_truth[index(other)];
    const Vector3 p_m = T_own * then.p_m[other];
    FrameError error;
    error.t_s = to_seconds(view.t);
    error.receiver = static_cast<double>(member.vehicle);
    error.other = static_cast<double>(other);
    error.error_m = (relative.heard_position_m - p_m).norm();
    error.yaw_rad = std::abs(std::remainder(
        relative.heard_yaw_rad - yaw_of(T_own.linear() * then.R_world_body[index(other)]), 2.0 * std::numbers::pi));
    error.sigma_m = std::sqrt(relative.covariance.topLeftCorner<3, 3>().trace());
    error.drifted_m = (T_other * then.p_m[other] - p_m).norm();
    records_[i].frames.push_back(error);
  }
}

std::vector<double> SharingLog::numbers() {
  std::vector<double> numbers;
  for (const TeamRecord& record : records_) {
    write_rows(record.sightings, numbers);
    write_rows(record.scans, numbers);
    write_rows(record.frames, numbers);
    numbers.insert(numbers.end(), {record.false_tracks, record.bytes, record.flown_s, record.largest_message});
  }
  return numbers;
}

void SharingLog::restore(std::span<const double> numbers) {
  for (TeamRecord& record : records_) {
    read_rows(numbers, record.sightings);
    read_rows(numbers, record.scans);
    read_rows(numbers, record.frames);
    record.false_tracks = numbers[0];
    record.bytes = numbers[1];
    record.flown_s = numbers[2];
    record.largest_message = numbers[3];
    numbers = numbers.subspan(4);
  }
}

}  // namespace swiftlet::tools
