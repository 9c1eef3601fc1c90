// SPDX-License-Identifier: BSD-3-Clause
#include "core/detection/hypotheses.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace swiftlet {
namespace {

using Limits = TrackBeforeDetectLimits;

/// [-] Largest extent of the returns assigned to a body in a sweep, relative to its known size. Larger values let a
/// body absorb returns from its surroundings.
constexpr double kMaxGrowth = 2.0;
/// [s] Mean duration of an occlusion of a target. Larger values keep targets without returns longer.
constexpr double kHiddenFor_s = 2.0;

}  // namespace

Hypotheses::Hypotheses(const TrackBeforeDetectConfig& config)
    : config_(config),
      empty_(config.field_of_view),
      returns_(config),
      air_(config),
      bodies_(config.target),
      former_(config) {
  const double prior = std::max(config.target.small_prior, Limits::kNeverSmall);
  small_log_odds_ = elementary::log(prior / (1.0 - prior));
  const auto max_hypotheses = static_cast<std::size_t>(config.max_hypotheses);
  hypotheses_.reserve(2 * max_hypotheses);
  born_.reserve(max_hypotheses);
}

void Hypotheses::take(const LocalCloud& cloud) {
  const std::span<const Eigen::Vector3f> empty_lidar = empty_.find(*cloud.scan);
  returns_.begin_sweep(cloud, empty_lidar);
  air_.begin_sweep(cloud, empty_lidar, returns_.beams());
  predict();
  returns_.find(cloud, air_);
  returns_.assign(cloud, hypotheses_);
  correct(cloud);
  bodies_.join_parts(cloud, hypotheses_, returns_);
  begin(cloud);
  former_.inherit(hypotheses_);
  merge();
  forget();
  air_.learn(middle(), hypotheses_);
  air_.clear(cloud, empty_lidar, returns_.beams());
}

void Hypotheses::predict() {
  for (Hypothesis& h : hypotheses_) {
    const double dt_s = to_seconds(middle() - h.t);
    h.predict(middle(), config_.target);
    h.sight.predict(dt_s, 1.0 / config_.target.seen_for_s, 1.0 / kHiddenFor_s);
    h.num_returns = 0;
  }
  former_.predict(middle());
  exposures_.clear();
  for (const Hypothesis& h : hypotheses_) exposures_.push_back(exposure_of(h));
}

void Hypotheses::correct(const LocalCloud& cloud) {
  for (std::size_t k = 0; k < hypotheses_.size(); ++k) {
    Hypothesis& h = hypotheses_[k];
    bool corrected = false;
    const double hidden = h.sight.hidden;
    if (!returns_.of(k).empty()) {
      const TargetMeasurement measurement = returns_.measure(cloud, returns_.of(k), h.size_m);
      if (measurement.extent_m.norm() <= std::max(config_.target.max_size_m, kMaxGrowth * h.size_m)) {
        corrected = correct_by(h, measurement, exposures_[k]);
      }
    }
    if (!corrected) miss(h, exposures_[k]);
    weigh_size(h, exposures_[k], hidden, corrected ? h.num_returns : 0);
    if (h.existence < Limits::kTarget) queue_for_background(returns_.of(k), h.id);
  }
}

// Weighs the number of returns for and against an object too small for a UAV, at ranges where both differ.
void Hypotheses::weigh_size(Hypothesis& h, const BeamExposure& exposure, double hidden, int num_returns) {
  const ExpectedTarget& target = config_.target;
  const double range_m = (h.p_local_m() - returns_.beams().p_local_lidar_m()).norm();
  if (target.small_prior <= 0.0 || range_m > target.small_within_m) return;
  h.small.weigh(num_returns, exposure.shots, hidden, target.small_share, target.least_share, target.return_variation);
}

// Integrated probabilistic data association with one measurement.
bool Hypotheses::correct_by(Hypothesis& h, const TargetMeasurement& measurement, const BeamExposure& exposure) {
  const Eigen::Matrix<double, 3, 6> H = position_at(to_seconds(measurement.t - h.t));
  const Vector3 innovation_m = measurement.p_local_m - H * h.mean;
  const Matrix3 S = H * h.covariance * H.transpose() + measurement.covariance;
  const double distance_sq = innovation_m.dot(S.llt().solve(innovation_m));
  if (!(distance_sq < Limits::kGate)) return false;
  const double p_no_return = h.rate.p_no_return(exposure.shots),
               p_return = std::max(1.0 - p_no_return, Limits::kMinDetection);
  const double clutter = clutter_density_per_m3(measurement, exposure.beams_per_sr);
  const double return_ratio = p_return * normal_density(distance_sq, S) / clutter;
  const double likelihood_ratio = h.sight.weigh(p_no_return + return_ratio);
  h.existence = existence_after(h.existence, likelihood_ratio);

  const double weight = (1.0 - h.sight.hidden) * return_ratio / (p_no_return + return_ratio);
  const Eigen::Matrix<double, 6, 3> K = h.covariance * H.transpose() * S.inverse();
  const Vector6 correction = K * innovation_m;
  h.mean += weight * correction;
  h.covariance -= weight * K * S * K.transpose();
  h.covariance += weight * (1.0 - weight) * correction * correction.transpose();
  h.covariance = 0.5 * (h.covariance + h.covariance.transpose()).eval();
  measurement.keep_in(h);
  h.seen = h.t;
  ++h.num_sweeps;
  if (h.size_m > 0.0)
    h.size_m = std::clamp(h.extent_m.maxCoeff(), Limits::kSizeMemory * h.size_m, bodies_.most_size_m());
  if (h.existence >= Limits::kTarget) h.rate.update(measurement.num_returns, exposure.shots, Limits::kRateMemory);
  return true;
}

void Hypotheses::miss(Hypothesis& h, const BeamExposure& exposure) {
  h.existence = existence_after(h.existence, h.sight.weigh(h.rate.p_no_return(exposure.shots)));
}

// Each unassigned cluster in free air that is not too large begins a hypothesis, unless it is beside a target. Its
// returns, and those of rejected clusters, are queued to become background.
void Hypotheses::begin(const LocalCloud& cloud) {
  born_.clear();
  for (int cluster = 0; cluster < returns_.num_clusters(); ++cluster) {
    if (returns_.is_assigned(cluster)) continue;
    const std::span<const std::uint32_t> members = returns_.members(cluster);
    const TargetMeasurement m = returns_.measure(cloud, members, 0.0);
    if (!m.in_free_air || !(m.extent_m.norm() <= config_.target.max_size_m)) {
      queue_for_background(members, 0);
      continue;
    }
    const bool beside_a_target = std::any_of(hypotheses_.begin(), hypotheses_.end(), [&](const Hypothesis& h) {
      return h.existence >= Limits::kTarget &&
             (h.p_local_m() - m.p_local_m).norm() < std::max(config_.cluster_distance_m, h.size_m);
    });
    if (beside_a_target || born_.size() == static_cast<std::size_t>(config_.max_hypotheses)) continue;
    born_.push_back(newborn(m));
    queue_for_background(members, born_.back().id);
  }
  num_born_ += born_.size();
  hypotheses_.insert(hypotheses_.end(), born_.begin(), born_.end());
}

Hypothesis Hypotheses::newborn(const TargetMeasurement& m) {
  Hypothesis h;
  h.id = h.identity = next_id_++;
  h.t = m.t;
  h.rate = {Limits::kPriorShots * config_.target.return_share, Limits::kPriorShots, config_.target.return_variation};
  h.small.log_odds = small_log_odds_;
  h.mean.head<3>() = m.p_local_m;
  h.covariance.setZero();
  h.covariance.topLeftCorner<3, 3>() = m.covariance;
  h.covariance.bottomRightCorner<3, 3>() =
      config_.target.sigma_velocity_mps * config_.target.sigma_velocity_mps * Matrix3::Identity();
  const BeamExposure exposure = exposure_of(h);
  const double reappearing_per_m3 = former_.remember(hypotheses_, m, h);
  const double p_return = std::max(1.0 - h.rate.p_no_return(exposure.shots), Limits::kMinDetection);
  const double target_per_m3 = (config_.target.birth_per_m3 + reappearing_per_m3) * p_return;
  h.existence = target_per_m3 / (target_per_m3 + clutter_density_per_m3(m, exposure.beams_per_sr));
  m.keep_in(h);
  h.num_sweeps = 1;
  h.move(to_seconds(middle() - h.t), config_.target.acceleration_density);
  h.t = h.begun = h.seen = middle();
  return h;
}

void Hypotheses::queue_for_background(std::span<const std::uint32_t> candidates, std::uint32_t hypothesis) {
  for (const std::uint32_t c : candidates)
    air_.queue_for_background(middle(), returns_.position_m(c), hypothesis, hypotheses_);
}

// Removes duplicates: of two hypotheses at one place, the more likely one stays.
void Hypotheses::merge() {
  std::sort(hypotheses_.begin(), hypotheses_.end(), [](const Hypothesis& a, const Hypothesis& b) {
    return a.existence != b.existence ? a.existence > b.existence : a.id < b.id;
  });
  for (std::size_t i = 0; i < hypotheses_.size(); ++i) {
    for (std::size_t j = i + 1; j < hypotheses_.size(); ++j) {
      Hypothesis& other = hypotheses_[j];
      const double merge_m = (other.existence >= Limits::kTarget ? Limits::kMergeTarget : Limits::kMergeOther) *
                             config_.cluster_distance_m;
      const Vector3 apart_m = other.p_local_m() - hypotheses_[i].p_local_m();
      if (apart_m.squaredNorm() >= merge_m * merge_m) continue;
      other.existence = 0.0;
      other.was_target = false;
    }
  }
}

// Deletes hypotheses that are unlikely or whose position is too uncertain, and the least likely ones above
// max_hypotheses. Former targets are remembered, so that a new hypothesis can continue their identity.
void Hypotheses::forget() {
  std::erase_if(hypotheses_, [&](const Hypothesis& h) {
    const double max_sigma_m = (h.existence >= Limits::kTarget ? 1.0 : Limits::kUnlikelyLost) * config_.sigma_lost_m;
    if (!h.mean.allFinite()) return true;
    if (h.existence >= Limits::kMinExistence &&
        h.position_covariance().diagonal().maxCoeff() <= max_sigma_m * max_sigma_m)
      return false;
    if (h.was_target) former_.add(h);
    return true;
  });
  former_.forget();
  const auto max_hypotheses = static_cast<std::size_t>(config_.max_hypotheses);
  if (hypotheses_.size() <= max_hypotheses) return;
  num_dropped_ += hypotheses_.size() - max_hypotheses;
  hypotheses_.erase(hypotheses_.begin() + static_cast<std::ptrdiff_t>(max_hypotheses), hypotheses_.end());
}

// Probability that at least one of the beams through a voxel returns from something other than a target, divided by the
// volume of the voxel. In free air, the probability for one beam is at most free_air_share.
double Hypotheses::clutter_density_per_m3(const TargetMeasurement& m, double beams_per_sr) const {
  const double edge_m = air_.map().voxel_m();
  const double range_sq = std::max((m.p_local_m - returns_.beams().p_local_lidar_m()).squaredNorm(), edge_m * edge_m);
  const double beams = std::max(beams_per_sr * edge_m * edge_m / range_sq, Limits::kMinBeams);
  const double voxel_share = air_.map().clutter_share(m.p_local_m);
  const double p_clutter = m.in_free_air ? std::min(voxel_share, config_.free_air_share) : voxel_share;
  return (1.0 - elementary::exp(-p_clutter * beams)) / (edge_m * edge_m * edge_m);
}

BeamExposure Hypotheses::exposure_of(const Hypothesis& h) const {
  const double sigma_m = std::sqrt((h.position_covariance() + returns_.pose_covariance(h.p_local_m())).trace() / 3.0);
  return returns_.beams().exposure({h.t, h.p_local_m(), h.v_local_mps(), sigma_m, config_.target.radius_m});
}

void Hypotheses::append_reported(std::vector<Detection>& detections) const {
  for (const Hypothesis& h : hypotheses_) {
    if (!is_reported(h)) continue;
    Detection d;
    d.t = h.t;
    d.position_m = h.p_local_m();
    d.covariance = h.position_covariance();
    d.extent_m = h.extent_m;
    d.num_points = h.num_returns;
    d.confidence = h.confidence();
    d.reflectivity = h.reflectivity;
    detections.push_back(d);
  }
}

void Hypotheses::append_reported(std::vector<Track>& tracks) const {
  for (const Hypothesis& h : hypotheses_) {
    if (!is_reported(h)) continue;
    Track track;
    track.id = h.identity;
    track.t = h.t;
    track.position_m = h.p_local_m();
    track.velocity_mps = h.v_local_mps();
    track.covariance.topLeftCorner<6, 6>() = h.covariance;
    track.num_detections = h.num_sweeps;
    track.corrected = h.num_returns > 0;
    track.measured_m = h.measured_local_m;
    track.measured_covariance = h.measured_covariance;
    track.reflectivity = h.reflectivity;
    tracks.push_back(track);
  }
}

void Hypotheses::append_counters(std::vector<Counter>& counters) const {
  counters.push_back({"hypotheses dropped because there were too many", num_dropped_, num_born_, "max_hypotheses"});
}

}  // namespace swiftlet
