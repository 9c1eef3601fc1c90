// SPDX-License-Identifier: BSD-3-Clause
#include "detection_log.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "sim/raycast/ray_scene.hpp"
#include "sim/sensors/lidar.hpp"
#include "sim/world/vehicle_state.hpp"
#include "swiftlet/core/action.hpp"
#include "swiftlet/sim/recorder.hpp"

namespace swiftlet::tools {
namespace {

constexpr double kTruePositive_m = 3.0;  // 000, sec. V-A
constexpr double kFollowed_m = 1.0;      // nearer than this, a track is this target's
constexpr double kSlow_mps = 0.3;        // below, a velocity has no direction
const double kNan = std::numeric_limits<double>::quiet_NaN();

}  // namespace

DetectionLog::DetectionLog(const sim::Scenario& scenario, double fov_bottom_deg, double fov_top_deg, double ignored_s,
                           std::size_t observer)
    : observer_(observer),
      world_(sim::build_world(scenario.world, scenario.seed)),
      sin_bottom_(std::sin(fov_bottom_deg * std::numbers::pi / 180.0)),
      sin_top_(std::sin(fov_top_deg * std::numbers::pi / 180.0)),
      ignored_(from_seconds(ignored_s)) {
  for (const Module& sensor : scenario.vehicles.at(observer).sensors) {
    if (const auto* lidar = dynamic_cast<const sim::LidarConfig*>(sensor.config.get()))
      p_body_lidar_m_ = lidar->mount.position_m;
  }
}

void DetectionLog::add(const sim::Simulation& simulation) {
  const sim::TickView& view = simulation.view();
  Truth truth;
  truth.t = view.t;
  const sim::VehicleState& own = view.states[observer_];
  truth.R_world_body = own.q_world_body.toRotationMatrix();
  truth.p_sensor_m = own.p_world_m + truth.R_world_body * p_body_lidar_m_;
  for (std::size_t i = 0; i < view.states.size(); ++i) {
    if (i == observer_) continue;
    truth.p_m.push_back(view.states[i].p_world_m);
    truth.v_mps.push_back(view.states[i].v_world_mps);
  }
  truth_.push_back(std::move(truth));
  if (view.t < ignored_) return;
  observed_s_ = to_seconds(view.t - ignored_);
  const Action& action = *view.actions[observer_];
  if (action.has_detections && action.detections_stamp >= ignored_) add_detections(action);
  if (action.has_tracks) add_tracks(action);
}

// Truth of the tick nearest to an instant: ticks are milliseconds apart.
const DetectionLog::Truth& DetectionLog::at(TimeNs t) const {
  const auto after =
      std::lower_bound(truth_.begin(), truth_.end(), t, [](const Truth& truth, TimeNs time) { return truth.t < time; });
  if (after == truth_.end()) return truth_.back();
  if (after == truth_.begin() || after->t - t < t - (after - 1)->t) return *after;
  return *(after - 1);
}

Sighting DetectionLog::sighting_of(const Truth& truth, int target, TimeNs t) const {
  const Vector3 p_m = truth.p_m[static_cast<std::size_t>(target)];
  const Vector3 d_body = truth.R_world_body.transpose() * (p_m - truth.p_sensor_m);
  Sighting sighting;
  sighting.t = t;
  sighting.target = target;
  sighting.range_m = d_body.norm();
  const double sine = d_body.z() / sighting.range_m;
  sighting.visible = sine > sin_bottom_ && sine < sin_top_ && !world_.static_scene->occluded(truth.p_sensor_m, p_m);
  sighting.error_m = std::numeric_limits<double>::infinity();
  sighting.direction_error_rad = kNan;
  return sighting;
}

void DetectionLog::add_detections(const Action& action) {
  const int num_targets = static_cast<int>(truth_.back().p_m.size());
  for (int target = 0; target < num_targets; ++target) {
    Sighting sighting = sighting_of(at(action.detections_stamp), target, action.detections_stamp);
    for (const Detection& detection : action.detections) {
      const double error_m = (detection.position_m - at(detection.t).p_m[static_cast<std::size_t>(target)]).norm();
      sighting.error_m = std::min(sighting.error_m, error_m);
    }
    sighting.found = sighting.error_m < kTruePositive_m;
    detections_.push_back(sighting);
  }
  for (const Detection& detection : action.detections) {
    const std::vector<Vector3>& targets = at(detection.t).p_m;
    const bool near_one = std::any_of(targets.begin(), targets.end(), [&](const Vector3& p_m) {
      return (p_m - detection.position_m).norm() < kTruePositive_m;
    });
    if (!near_one) ++num_false_detections_;
  }
}

void DetectionLog::add_tracks(const Action& action) {
  const int num_targets = static_cast<int>(truth_.back().p_m.size());
  for (const Track& track : action.tracks) track_ids_.insert(track.id);
  in_view_since_.resize(static_cast<std::size_t>(num_targets), -1);
  for (int target = 0; target < num_targets; ++target) {
    const TimeNs t = action.tracks.empty() ? truth_.back().t : action.tracks.front().t;
    const Truth& truth = at(t);
    Sighting sighting = sighting_of(truth, target, t);
    TimeNs& since = in_view_since_[static_cast<std::size_t>(target)];
    if (!sighting.visible) since = -1;
    if (sighting.visible && since < 0) since = t;
    sighting.in_view_s = sighting.visible ? to_seconds(t - since) : 0.0;
    const Track* nearest = nullptr;
    for (const Track& track : action.tracks) {
      const double error_m = (track.position_m - truth.p_m[static_cast<std::size_t>(target)]).norm();
      if (error_m >= sighting.error_m) continue;
      sighting.error_m = error_m;
      nearest = &track;
    }
    sighting.found = nearest != nullptr && sighting.error_m < kTruePositive_m;
    if (sighting.found) {
      const Vector3 v_mps = truth.v_mps[static_cast<std::size_t>(target)];
      sighting.track = nearest->id;
      sighting.speed_error_mps = std::abs(nearest->velocity_mps.norm() - v_mps.norm());
      const double product = nearest->velocity_mps.norm() * v_mps.norm();
      if (v_mps.norm() > kSlow_mps && product > 0.0) {
        sighting.direction_error_rad = std::acos(std::clamp(nearest->velocity_mps.dot(v_mps) / product, -1.0, 1.0));
      }
      std::vector<int>& followed = targets_of_track_[nearest->id];
      if (sighting.error_m < kFollowed_m && (followed.empty() || followed.back() != target)) followed.push_back(target);
    }
    tracks_.push_back(sighting);
  }
}

int DetectionLog::num_false_tracks() const {
  return static_cast<int>(std::count_if(track_ids_.begin(), track_ids_.end(),
                                        [&](std::uint32_t id) { return !targets_of_track_.contains(id); }));
}

int DetectionLog::num_cross_associations() const {
  int count = 0;
  for (const auto& [id, followed] : targets_of_track_) count += std::max(0, static_cast<int>(followed.size()) - 1);
  return count;
}

double DistanceBin::recall() const { return count == 0 ? kNan : static_cast<double>(found) / count; }

double DistanceBin::mean_error_m() const {
  if (errors_m.empty()) return kNan;
  double sum = 0.0;
  for (const double error_m : errors_m) sum += error_m;
  return sum / static_cast<double>(errors_m.size());
}

std::vector<DistanceBin> by_distance(const std::vector<const std::vector<Sighting>*>& runs, double width_m,
                                     double farthest_m, double least_in_view_s) {
  std::vector<DistanceBin> bins;
  for (int k = 0; k * width_m < farthest_m; ++k) bins.push_back({k * width_m, (k + 1) * width_m, 0, 0, {}});
  for (const std::vector<Sighting>* sightings : runs) {
    for (const Sighting& sighting : *sightings) {
      const auto k = static_cast<std::size_t>(sighting.range_m / width_m);
      if (!sighting.visible || k >= bins.size() || sighting.in_view_s < least_in_view_s) continue;
      ++bins[k].count;
      if (!sighting.found) continue;
      ++bins[k].found;
      bins[k].errors_m.push_back(sighting.error_m);
    }
  }
  return bins;
}

}  // namespace swiftlet::tools
