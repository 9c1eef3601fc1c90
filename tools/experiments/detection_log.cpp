// SPDX-License-Identifier: BSD-3-Clause
#include "detection_log.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "swiftlet/core/action.hpp"
#include "swiftlet/sim/raycast/ray_scene.hpp"
#include "swiftlet/sim/sensors/lidar.hpp"
#include "swiftlet/sim/view/recorder.hpp"
#include "swiftlet/sim/world/vehicle_state.hpp"

namespace swiftlet::tools {
namespace {

constexpr double kTruePositive_m = 3.0;  // [Vrba 2025, sec. V-A]
constexpr double kFollowed_m = 1.0;      // a track nearer than this follows the target
constexpr double kSlow_mps = 0.3;        // below this speed, no direction error
const double kNan = std::numeric_limits<double>::quiet_NaN();

// One function writes the numbers with NumberWriter and reads them with NumberReader.
struct NumberWriter {
  std::vector<double> numbers;
  template <class T>
  void number(T& value) {
    numbers.push_back(static_cast<double>(value));
  }
  template <class T, class Each>
  void list(std::vector<T>& items, Each each) {
    numbers.push_back(static_cast<double>(items.size()));
    for (T& item : items) each(item);
  }
};

struct NumberReader {
  std::span<const double> numbers;
  std::size_t next = 0;
  template <class T>
  void number(T& value) {
    value = static_cast<T>(numbers[next++]);
  }
  template <class T, class Each>
  void list(std::vector<T>& items, Each each) {
    items.resize(static_cast<std::size_t>(numbers[next++]));
    for (T& item : items) each(item);
  }
};

template <class Stream>
void exchange_sighting(Stream& stream, Sighting& s) {
  const auto numbers = [&](auto&... values) { (stream.number(values), ...); };
  numbers(s.t, s.told, s.target, s.range_m, s.visible, s.points, s.found, s.error_m, s.drifted_error_m,
          s.speed_error_mps, s.direction_error_rad, s.track, s.in_view_s, s.p_m.x(), s.p_m.y(), s.p_m.z(),
          s.estimate_m.x(), s.estimate_m.y(), s.estimate_m.z());
}

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
  const Action& action = *view.actions[observer_];
  Truth truth;
  truth.t = view.t;
  const sim::VehicleState& own = view.states[observer_];
  truth.R_world_body = own.q_world_body.toRotationMatrix();
  truth.p_sensor_m = own.p_world_m + truth.R_world_body * p_body_lidar_m_;
  truth.T_estimate_truth = action.estimate.T_world_body() * own.T_world_body().inverse();
  for (std::size_t i = 0; i < view.states.size(); ++i) {
    if (i == observer_) continue;
    truth.p_m.push_back(view.states[i].p_world_m);
    truth.v_mps.push_back(view.states[i].v_world_mps);
  }
  truth_.push_back(std::move(truth));
  for (const auto& labeled : view.scans[observer_]) remember(*labeled);
  if (view.t < ignored_) return;
  observed_s_ = to_seconds(view.t - ignored_);
  if (action.has_detections && least_confidence_ > 0.0) find_unsure(action);
  if (action.has_detections && action.detections_stamp >= ignored_) add_detections(action);
  tracks_awaited_ = tracks_awaited_ || !view.scans[observer_].empty();
  if (!action.has_tracks || !tracks_awaited_) return;  // a detector's tracks arrive later than the scan
  tracks_awaited_ = false;
  add_tracks(action);
}

void DetectionLog::remember(const sim::LabeledScan& labeled) {
  SeenScan seen;
  seen.stamp = labeled.scan.stamp;
  seen.middle = labeled.scan.stamp + labeled.scan.duration / 2;
  seen.points.resize(truth_.back().p_m.size());
  const sim::ScanTruth& truth = labeled.truth;
  for (std::size_t k = 0; k < truth.instance.size(); ++k) {
    if (truth.surface_class[k] != static_cast<std::uint16_t>(sim::SurfaceClass::kVehicle)) continue;
    if (!(labeled.scan.range_m[k] > 0.0F)) continue;
    const std::size_t vehicle = truth.instance[k] - 1U;
    if (vehicle == observer_) continue;
    const std::size_t target = vehicle > observer_ ? vehicle - 1 : vehicle;
    if (target < seen.points.size()) ++seen.points[target];
  }
  scans_.push_back(std::move(seen));
}

// Truth of the tick nearest to an instant; ticks are milliseconds apart.
const DetectionLog::Truth& DetectionLog::at(TimeNs t) const {
  const auto after =
      std::lower_bound(truth_.begin(), truth_.end(), t, [](const Truth& truth, TimeNs time) { return truth.t < time; });
  if (after == truth_.end()) return truth_.back();
  if (after == truth_.begin() || after->t - t < t - (after - 1)->t) return *after;
  return *(after - 1);
}

const DetectionLog::SeenScan* DetectionLog::scan_of(TimeNs stamp) const {
  const auto scan = std::find_if(scans_.rbegin(), scans_.rend(), [&](const SeenScan& s) { return s.stamp == stamp; });
  return scan != scans_.rend() ? &*scan : nullptr;
}

Sighting DetectionLog::sighting_of(const SeenScan& scan, int target) const {
  const Truth& truth = at(scan.middle);
  const Vector3 p_m = truth.p_m[static_cast<std::size_t>(target)];
  const Vector3 d_body = truth.R_world_body.transpose() * (p_m - truth.p_sensor_m);
  Sighting sighting;
  sighting.t = scan.middle;
  sighting.told = truth_.back().t;
  sighting.target = target;
  sighting.range_m = d_body.norm();
  const double sine = d_body.z() / sighting.range_m;
  sighting.visible = sine > sin_bottom_ && sine < sin_top_ && !world_.static_scene->occluded(truth.p_sensor_m, p_m);
  sighting.points = scan.points[static_cast<std::size_t>(target)];
  sighting.p_m = truth.T_estimate_truth * p_m;
  sighting.error_m = sighting.drifted_error_m = std::numeric_limits<double>::infinity();
  sighting.direction_error_rad = kNan;
  return sighting;
}

/// Eq. (68): distance of an estimate to the target at the time of the estimate.
double DetectionLog::error_m(int target, TimeNs t, const Vector3& estimate_m) const {
  const Truth& truth = at(t);
  return (estimate_m - truth.T_estimate_truth * truth.p_m[static_cast<std::size_t>(target)]).norm();
}

/// Keeps the nearest estimate, eq. (67).
bool DetectionLog::take(Sighting& sighting, TimeNs t, const Vector3& estimate_m) const {
  const double distance_m = error_m(sighting.target, t, estimate_m);
  if (distance_m >= sighting.error_m) return false;
  sighting.error_m = distance_m;
  sighting.drifted_error_m = (estimate_m - at(t).p_m[static_cast<std::size_t>(sighting.target)]).norm();
  sighting.estimate_m = estimate_m;
  sighting.found = distance_m < kTruePositive_m;
  return true;
}

// In the output of track_before_detect, track i belongs to detection i.
void DetectionLog::find_unsure(const Action& action) {
  unsure_.clear();
  for (std::size_t i = 0; i < std::min(action.tracks.size(), action.detections.size()); ++i) {
    if (action.detections[i].confidence < least_confidence_) unsure_.insert(action.tracks[i].id);
  }
}

std::optional<std::size_t> surest_of(std::span<const Detection> detections, std::span<const double> off_m) {
  std::optional<std::size_t> surest;
  for (std::size_t i = 0; i < detections.size(); ++i) {
    if (off_m[i] >= kTruePositive_m) continue;
    if (!surest || detections[i].confidence > detections[*surest].confidence) surest = i;
  }
  return surest;
}

void DetectionLog::add_detections(const Action& action) {
  const SeenScan* scan = scan_of(action.detections_stamp);
  if (scan == nullptr) return;
  const int num_targets = static_cast<int>(scan->points.size());
  std::vector<char> is_true(action.detections.size(), 0);
  std::vector<char> exists(action.detections.size(), 0);
  for (int target = 0; target < num_targets; ++target) {
    Sighting sighting = sighting_of(*scan, target);
    std::vector<double> off_m;
    for (std::size_t i = 0; i < action.detections.size(); ++i) {
      const Detection& detection = action.detections[i];
      off_m.push_back(error_m(target, detection.t, detection.position_m));
      if (off_m.back() < kTruePositive_m) is_true[i] = 1;
      if (detection.confidence < least_confidence_) continue;
      take(sighting, detection.t, detection.position_m);
    }
    if (const std::optional<std::size_t> surest = surest_of(action.detections, off_m)) exists[*surest] = 1;
    detections_.push_back(sighting);
  }
  for (std::size_t i = 0; i < action.detections.size(); ++i) {
    const double confidence = action.detections[i].confidence;
    if (least_confidence_ > 0.0) told_.push_back({confidence, exists[i] != 0});
    if (confidence < least_confidence_) continue;
    ++num_told_detections_;
    if (!is_true[i]) ++num_false_detections_;
  }
}

void DetectionLog::add_tracks(const Action& action) {
  const SeenScan& scan = scans_.back();
  const int num_targets = static_cast<int>(scan.points.size());
  for (const Track& track : action.tracks) {
    if (unsure_.contains(track.id)) continue;
    track_ids_.insert(track.id);
    bool is_true = false;
    for (int target = 0; target < num_targets; ++target) {
      is_true = is_true || error_m(target, track.t, track.position_m) < kTruePositive_m;
    }
    ++num_told_tracks_;
    if (!is_true) ++num_false_told_tracks_;
  }
  in_view_since_.resize(static_cast<std::size_t>(num_targets), -1);
  for (int target = 0; target < num_targets; ++target) {
    Sighting sighting = sighting_of(scan, target);
    TimeNs& since = in_view_since_[static_cast<std::size_t>(target)];
    if (!sighting.visible) since = -1;
    if (sighting.visible && since < 0) since = sighting.t;
    sighting.in_view_s = sighting.visible ? to_seconds(sighting.t - since) : 0.0;
    const Track* nearest = nullptr;
    for (const Track& track : action.tracks) {
      if (!unsure_.contains(track.id) && take(sighting, track.t, track.position_m)) nearest = &track;
    }
    if (sighting.found) {
      sighting.track = nearest->id;
      const Truth& truth = at(nearest->t);
      const Vector3 v_mps = truth.T_estimate_truth.linear() * truth.v_mps[static_cast<std::size_t>(target)];
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

template <class Stream>
void DetectionLog::exchange(Stream& stream) {
  const auto sighting = [&](Sighting& s) { exchange_sighting(stream, s); };
  stream.list(detections_, sighting);
  stream.list(tracks_, sighting);
  stream.number(num_told_detections_);
  stream.number(num_false_detections_);
  stream.number(num_told_tracks_);
  stream.number(num_false_told_tracks_);
  stream.number(observed_s_);
  const auto number = [&](auto& value) { stream.number(value); };
  std::vector<std::uint32_t> ids(track_ids_.begin(), track_ids_.end());
  stream.list(ids, number);
  track_ids_ = {ids.begin(), ids.end()};
  std::vector<std::pair<std::uint32_t, std::vector<int>>> followed(targets_of_track_.begin(), targets_of_track_.end());
  stream.list(followed, [&](auto& track) {
    stream.number(track.first);
    stream.list(track.second, number);
  });
  targets_of_track_ = {followed.begin(), followed.end()};
  if (least_confidence_ == 0.0) return;
  stream.list(told_, [&](Told& told) {
    stream.number(told.confidence);
    stream.number(told.is_target);
  });
}

std::vector<double> DetectionLog::numbers() {
  NumberWriter writer;
  exchange(writer);
  return std::move(writer.numbers);
}

void DetectionLog::restore(std::span<const double> numbers) {
  NumberReader reader{numbers};
  exchange(reader);
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
