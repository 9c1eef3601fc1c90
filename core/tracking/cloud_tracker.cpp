// SPDX-License-Identifier: BSD-3-Clause
#include "core/tracking/cloud_tracker.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "swiftlet/core/base/elementary.hpp"

namespace swiftlet {
namespace {

/// [-] c_r of eq. (29): factor of the radius r_unc of a track's uncertainty. Larger values associate detections farther
/// away and lose tracks sooner.
constexpr double kRadiusScale = 1.5;
/// [m] r_min of eq. (28): least radius of the search for points around a prediction. Smaller values miss the outer
/// points of large targets.
constexpr double kSearchRadiusMin_m = 2.5;
/// [m] P_0,r: initial standard deviation of a track's position, with `noise: constant`. Larger values follow the first
/// measurements more closely.
constexpr double kInitialSigma_m = 0.3;

/// Mean of the points, center of the box around them, and the box's diagonal.
struct Extent {
  Vector3 centroid_m = Vector3::Zero(), box_center_m = Vector3::Zero();
  double diagonal_m = 0.0;
};

Extent extent_of(std::span<const std::uint32_t> members, std::span<const Eigen::Vector3f> points) {
  Eigen::Vector3f min = points[members.front()], max = min;
  Extent extent;
  for (const std::uint32_t i : members) {
    extent.centroid_m += points[i].cast<double>();
    min = min.cwiseMin(points[i]);
    max = max.cwiseMax(points[i]);
  }
  extent.centroid_m /= static_cast<double>(members.size());
  extent.box_center_m = 0.5 * (min + max).cast<double>();
  extent.diagonal_m = (max - min).cast<double>().norm();
  return extent;
}

/// Position of a target, extrapolated with constant velocity. The time is close to that of the belief.
Vector3 position_at(const MotionBelief& belief, TimeNs t_belief, TimeNs t) {
  return belief.position() + belief.velocity() * to_seconds(t - t_belief);
}

/// -2 log of the normal density of a difference `d` with covariance `S`, up to a constant: squared Mahalanobis distance
/// plus log det S.
double statistical_distance(const Vector3& d, const Matrix3& S) {
  const Eigen::LLT<Matrix3> llt(S);
  const Matrix3 L = llt.matrixL();
  const double log_det = 2.0 * elementary::log(L(0, 0) * L(1, 1) * L(2, 2));
  return d.dot(llt.solve(d)) + log_det;
}

}  // namespace

void TrackMeasurementConfig::visit(ConfigVisitor& v) {
  v.choice("noise", noise, {"constant", "sigma_w"},
           "[-] covariance of a measured position: sigma_m^2 I (constant), or that of a point measured by a sensor of "
           "uncertain pose [Vrba 2025, sec. IV-A] plus sigma_sampling_m^2 I (sigma_w)");
  v.field("sigma_m", sigma_m, "[m] Z, with constant noise: standard deviation of a measured position",
          Range::positive());
  v.field("sigma_range_m", sensor.sigma_range_m, "[m] Sigma_w: standard deviation of the range", Range::non_negative());
  v.field("sigma_position_m", sensor.sigma_position_m,
          "[m] Sigma_w: standard deviation of the sensor's position, x y z", Range::non_negative());
  v.field("sigma_attitude_rad", sensor.sigma_attitude_rad,
          "[rad] Sigma_w: standard deviation of the sensor's attitude, about x y z", Range::non_negative());
  v.field("sigma_sampling_m", sigma_sampling_m,
          "[m] with sigma_w: standard deviation of a cluster's centroid about the target's center, because the LiDAR "
          "sees only one side of a target",
          Range::positive());
}

void CloudTrackerConfig::visit(ConfigVisitor& v) {
  v.field("buffer_size", buffer_size,
          "[-] N_buf: number of buffered clouds, through which a late detection is propagated",
          Range::between(1, 1000));
  v.choice("radius_law", radius_law, {"printed", "sphere"},
           "[-] radius of uncertainty r_unc of a position covariance P: c_r det(P)^(1/3), as in the paper and its "
           "released code, though the unit is m^2 (printed); or c_r det(P)^(1/6), the radius of a sphere with the "
           "volume of the c_r sigma ellipsoid (sphere)");
  v.field("radius_max_m", radius_max_m, "[m] r_max: largest r_unc of a track; above it the track is lost",
          Range::positive());
  v.field("cluster_distance_m", cluster_distance_m,
          "[m] d_cluster: largest distance between neighboring points of a cluster (paper: 0.25, released code: 1.0)",
          Range::positive());
  v.field("background_distance_m", background_distance_m,
          "[m] d_min: distance to background below which a cluster is background", Range::non_negative());
  v.choice("background", background, {"map", "cloud", "none"},
           "[-] background within d_min of a cluster: occupied voxels of the detector's map (map; algorithm 2); other "
           "points of the same cloud, within d_min plus half the cluster's size (cloud; released code); not considered "
           "(none)");
  v.field("max_size_m", max_size_m, "[m] diagonal beyond which a cluster is no target; 0: no limit (algorithm 2)",
          Range::non_negative());
  v.choice("position", position, {"centroid", "box_center"},
           "[-] position of a cluster: mean of its points (algorithm 2), or center of the box around it (as in the "
           "released code)");
  v.choice("assignment", assignment, {"exclusive", "nearest"},
           "[-] association of clusters with tracks: global assignment, in which a cluster corrects at most one track "
           "(exclusive); or for each track the cluster nearest to its prediction (nearest; algorithm 2)");
  v.field("association_radius_min_m", association_radius_min_m,
          "[m] minimum radius r_unc; a detection joins a track when they are nearer than the sum of their radii "
          "(algorithm 2: 0, released code: r_min)",
          Range::non_negative());
  v.field("merge_radius_max_m", merge_radius_max_m,
          "[m] upper bound of r_unc in the merging of duplicate tracks: two tracks nearer than the sum of their "
          "bounded radii become one; 0: never (algorithm 2: 0, released code: no bound)",
          Range::non_negative());
  v.field("min_detections", min_detections,
          "[-] number of detections from which a track is reported (released code: 2)", Range::between(1, 1000));
  v.object("measurement", measurement, "uncertainty of measured positions");
  v.check(radius_max_m >= kSearchRadiusMin_m || radius_law == CloudTrackerConfig::RadiusLaw::kPrinted, "radius_max_m",
          "at least 2.5 with radius_law: sphere");
}

CloudTracker::CloudTracker(const CloudTrackerConfig& config, std::unique_ptr<MotionFilter> filter)
    : config_(config),
      filter_(std::move(filter)),
      Sigma_w_(config.measurement.sensor.Sigma_w()),
      buffer_(config.buffer_size) {}

double CloudTracker::uncertainty_radius_m(const Matrix3& position_covariance) const {
  const double det = position_covariance.determinant();
  return kRadiusScale * (config_.radius_law == CloudTrackerConfig::RadiusLaw::kPrinted
                             ? elementary::cbrt(det)
                             : std::sqrt(elementary::cbrt(det)));
}

double CloudTracker::search_radius_m(const Target& target) const {
  return std::max(kSearchRadiusMin_m, uncertainty_radius_m(target.state.belief.position_covariance()));
}

double CloudTracker::association_radius_m(const Target& target) const {
  return std::max(config_.association_radius_min_m, uncertainty_radius_m(target.state.belief.position_covariance()));
}

Matrix3 CloudTracker::position_covariance(const Vector3& position_local_m, const Pose& T_local_lidar) const {
  const Vector3 ray_lidar = T_local_lidar.inverse() * position_local_m;
  const double range_m = ray_lidar.norm();
  const double sampling_m = config_.measurement.sigma_sampling_m;
  const Matrix3 sampling = sampling_m * sampling_m * Matrix3::Identity();
  if (!(range_m > 0.0)) return sampling;
  return sampling + point_covariance(ray_lidar / range_m, range_m, T_local_lidar.linear(), Sigma_w_);
}

void CloudTracker::new_cloud(const LocalCloud& cloud, const BackgroundQuery* background) {
  ++num_clouds_;
  if (buffer_.size() > 0 && cloud.scan->stamp <= buffer_.newest().stamp()) {
    ++num_late_clouds_;
    return;
  }
  buffer_.push().assign(cloud);
  update(targets_, buffer_.newest(), background);
  merge();
  forget();
}

void CloudTracker::new_detections(std::span<const Detection> detections, const BackgroundQuery* background) {
  for (const Detection& detection : detections) {
    if (!detection.position_m.allFinite()) continue;
    ++num_detections_;
    if (buffer_.is_full() && detection.t < buffer_[0].stamp()) ++num_late_detections_;
    Target target = start(detection);
    bool lost = false;
    for (std::size_t i = 0; i < buffer_.size() && !lost; ++i) {
      if (buffer_[i].stamp() <= detection.t) continue;
      update({&target, 1}, buffer_[i], background);
      lost = !(uncertainty_radius_m(target.state.belief.position_covariance()) <= config_.radius_max_m);
    }
    if (!lost) associate(std::move(target));
  }
}

void CloudTracker::append_counters(std::vector<Counter>& counters) const {
  counters.push_back({"sweeps received after a newer one", num_late_clouds_, num_clouds_, "sensor"});
  counters.push_back(
      {"detections older than every buffered cloud", num_late_detections_, num_detections_, "buffer_size"});
}

CloudTracker::Target CloudTracker::start(const Detection& detection) const {
  Target target;
  target.t = detection.t;
  target.num_detections = 1;
  target.corrected = true;
  Matrix3 covariance = kInitialSigma_m * kInitialSigma_m * Matrix3::Identity();
  if (config_.measurement.noise == TrackMeasurementConfig::Noise::kSigmaW && buffer_.size() > 0) {
    // The covariance depends on the sensor's pose: that of the last cloud before the detection, or of the oldest one.
    std::size_t i = buffer_.size() - 1;
    while (i > 0 && buffer_[i].stamp() > detection.t) --i;
    covariance = position_covariance(detection.position_m, buffer_[i].T_local_lidar());
  }
  target.state = filter_->start(detection.position_m, covariance);
  target.measured_local_m = detection.position_m;
  target.measured_covariance = covariance;
  target.reflectivity = static_cast<float>(detection.reflectivity);
  return target;
}

/// Assigns a detection, propagated to the newest cloud, to its track, or begins a new track.
void CloudTracker::associate(Target target) {
  Target* nearest = nullptr;
  double least_m = std::numeric_limits<double>::infinity();
  for (Target& other : targets_) {
    const double distance_m =
        (position_at(other.state.belief, other.t, target.t) - target.state.belief.position()).norm();
    if (distance_m > association_radius_m(other) + association_radius_m(target) || distance_m >= least_m) continue;
    least_m = distance_m;
    nearest = &other;
  }
  if (nearest != nullptr) {
    ++nearest->num_detections;
    return;
  }
  target.id = next_id_++;
  targets_.push_back(std::move(target));
}

// Routine updateTrack() of algorithm 2, for all tracks at once: prediction to mid-sweep, association with clusters of
// the cloud, correction.
void CloudTracker::update(std::span<Target> targets, const BufferedCloud& cloud, const BackgroundQuery* background) {
  predicted_.assign(targets.begin(), targets.end());
  for (Target& target : predicted_) {
    const TimeNs t = std::max(target.t, cloud.middle());
    filter_->predict(target.state, to_seconds(t - target.t));
    target.t = t;
  }
  find_candidates(predicted_, cloud, background);
  assign(predicted_);

  for (std::size_t i = 0; i < targets.size(); ++i) {
    Target& target = targets[i];
    target.corrected = chosen_[i] >= 0;
    if (!target.corrected) {
      target.state = predicted_[i].state;
      target.t = predicted_[i].t;
      continue;
    }
    // A cluster is measured at the mean time of its points, which differs from mid-sweep.
    const Candidate& candidate = candidates_[chosen_[i]];
    const TimeNs t = std::max(target.t, candidate.t);
    filter_->predict(target.state, to_seconds(t - target.t));
    target.t = t;
    filter_->correct(target.state, candidate.position_local_m, candidate.covariance);
    target.measured_local_m = candidate.position_local_m;
    target.measured_covariance = candidate.covariance;
    target.reflectivity = candidate.reflectivity;
  }
}

/// Clusters the points near all predictions. Clusters that are neither background nor too large become candidates_.
void CloudTracker::find_candidates(std::span<const Target> targets, const BufferedCloud& cloud,
                                   const BackgroundQuery* background) {
  selected_.clear();
  for (const Target& target : targets) cloud.select(target.state.belief.position(), search_radius_m(target), selected_);
  std::sort(selected_.begin(), selected_.end());
  selected_.erase(std::unique(selected_.begin(), selected_.end()), selected_.end());
  selected_points_.clear();
  for (const std::uint32_t i : selected_) selected_points_.push_back(cloud.point(i));
  clusters_.compute(selected_points_, config_.cluster_distance_m);

  candidates_.clear();
  for (int c = 0; c < clusters_.size(); ++c) {
    const auto members = clusters_.members(c);
    const Extent extent = extent_of(members, selected_points_);
    if (config_.max_size_m > 0.0 && extent.diagonal_m > config_.max_size_m) continue;
    const Vector3& position_local_m =
        config_.position == CloudTrackerConfig::Position::kCentroid ? extent.centroid_m : extent.box_center_m;
    if (is_background(position_local_m, extent.diagonal_m, cloud, members, background)) continue;
    std::int64_t sum_ns = 0;
    float reflectivity = 0.0F;
    for (const std::uint32_t i : members) {
      sum_ns += cloud.time_of(selected_[i]) - cloud.stamp();
      reflectivity = std::max(reflectivity, cloud.reflectivity(selected_[i]));
    }
    const TimeNs t = cloud.stamp() + sum_ns / static_cast<std::int64_t>(members.size());
    candidates_.push_back(
        {position_local_m, measurement_covariance(position_local_m, cloud), t, reflectivity, members});
  }
}

/// Z of eq. (32): covariance of a measured position.
Matrix3 CloudTracker::measurement_covariance(const Vector3& position_local_m, const BufferedCloud& cloud) const {
  if (config_.measurement.noise == TrackMeasurementConfig::Noise::kSigmaW)
    return position_covariance(position_local_m, cloud.T_local_lidar());
  return config_.measurement.sigma_m * config_.measurement.sigma_m * Matrix3::Identity();
}

bool CloudTracker::is_background(const Vector3& position_local_m, double size_m, const BufferedCloud& cloud,
                                 std::span<const std::uint32_t> members, const BackgroundQuery* background) {
  const double distance_m = config_.background_distance_m;
  if (config_.background == CloudTrackerConfig::Background::kMap)
    return background != nullptr && background->occupied_within(position_local_m, distance_m);
  if (config_.background == CloudTrackerConfig::Background::kNone) return false;
  around_.clear();
  cloud.select(position_local_m, 0.5 * size_m + distance_m, around_);
  return around_.size() > members.size();  // also counts the cluster's own points
}

/// Sets chosen_ to the index of the candidate that corrects each target; -1: none.
void CloudTracker::assign(std::span<const Target> targets) {
  const bool exclusive = config_.assignment == CloudTrackerConfig::Assignment::kExclusive;
  const std::size_t num = candidates_.size();
  costs_.assign(targets.size() * num, Assignment::kForbidden);
  for (std::size_t i = 0; i < targets.size(); ++i) {
    const Target& target = targets[i];
    const MotionBelief& belief = target.state.belief;
    const Vector3 center = belief.position();
    const double radius_sq = search_radius_m(target) * search_radius_m(target);
    for (std::size_t c = 0; c < num; ++c) {
      const Candidate& candidate = candidates_[c];
      const bool in_reach = std::any_of(candidate.members.begin(), candidate.members.end(), [&](std::uint32_t m) {
        return (selected_points_[m].cast<double>() - center).squaredNorm() <= radius_sq;
      });
      if (!in_reach) continue;
      const Vector3 d = candidate.position_local_m - position_at(belief, target.t, candidate.t);
      const double cost =
          exclusive ? statistical_distance(d, belief.position_covariance() + candidate.covariance) : d.norm();
      if (std::isfinite(cost)) costs_[i * num + c] = cost;
    }
  }
  chosen_.assign(targets.size(), -1);
  if (num == 0) return;
  if (exclusive) {
    const auto columns = assignment_.solve(costs_, static_cast<int>(targets.size()), static_cast<int>(num));
    std::copy(columns.begin(), columns.end(), chosen_.begin());
    return;
  }
  for (std::size_t i = 0; i < targets.size(); ++i) {
    const auto row = std::span(costs_).subspan(i * num, num);
    const auto best = std::min_element(row.begin(), row.end());
    if (*best < Assignment::kForbidden) chosen_[i] = static_cast<int>(best - row.begin());
  }
}

/// Merges duplicate tracks: the more certain one stays (released code; not in the paper). The radii are bounded, so
/// that an occluded target with growing uncertainty does not absorb its neighbor.
void CloudTracker::merge() {
  for (std::size_t i = 0; i < targets_.size(); ++i) {
    for (std::size_t j = i + 1; j < targets_.size();) {
      const MotionBelief& a = targets_[i].state.belief;
      const MotionBelief& b = targets_[j].state.belief;
      const double radius_a_m = uncertainty_radius_m(a.position_covariance());
      const double radius_b_m = uncertainty_radius_m(b.position_covariance());
      const double distance_m = (position_at(a, targets_[i].t, targets_[j].t) - b.position()).norm();
      const double most_m = config_.merge_radius_max_m;
      if (!(distance_m < std::min(radius_a_m, most_m) + std::min(radius_b_m, most_m))) {
        ++j;
        continue;
      }
      const int num_detections = std::max(targets_[i].num_detections, targets_[j].num_detections);
      if (radius_b_m < radius_a_m) std::swap(targets_[i], targets_[j]);
      targets_[i].num_detections = num_detections;
      targets_.erase(targets_.begin() + static_cast<std::ptrdiff_t>(j));
    }
  }
}

void CloudTracker::forget() {
  std::erase_if(targets_, [this](const Target& target) {
    return !(uncertainty_radius_m(target.state.belief.position_covariance()) <= config_.radius_max_m) ||
           !target.state.belief.mean.allFinite();
  });
}

void CloudTracker::publish(std::vector<Track>& tracks) const {
  tracks.clear();
  for (const Target& target : targets_) {
    if (target.num_detections < config_.min_detections) continue;
    Track track;
    track.id = target.id;
    track.t = target.t;
    track.position_m = target.state.belief.mean.head<3>();
    track.velocity_mps = target.state.belief.mean.segment<3>(3);
    track.acceleration_mps2 = target.state.belief.mean.tail<3>();
    track.covariance = target.state.belief.covariance;
    track.num_detections = target.num_detections;
    track.corrected = target.corrected;
    track.measured_m = target.measured_local_m;
    track.measured_covariance = target.measured_covariance;
    track.reflectivity = target.reflectivity;
    tracks.push_back(track);
  }
  std::sort(tracks.begin(), tracks.end(), [](const Track& a, const Track& b) { return a.id < b.id; });
}

void CloudTracker::publish_modes(std::vector<TrackModes>& modes) const {
  modes.clear();
  if (!filter_->has_modes()) return;
  for (const Target& target : targets_) {
    if (target.num_detections < config_.min_detections) continue;
    TrackModes& reported = modes.emplace_back();
    reported.id = target.id;
    for (std::size_t m = 0; m < TrackModes::kModels; ++m) {
      reported.probability[m] = target.state.mode_probability[m];
      reported.mean_local_m[m] = target.state.modes[m].mean;
    }
  }
  std::sort(modes.begin(), modes.end(), [](const TrackModes& a, const TrackModes& b) { return a.id < b.id; });
}

}  // namespace swiftlet
