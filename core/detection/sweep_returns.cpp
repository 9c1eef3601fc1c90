// SPDX-License-Identifier: BSD-3-Clause
#include "core/detection/sweep_returns.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "swiftlet/core/base/elementary.hpp"
#include "swiftlet/core/uncertainty/point_covariance.hpp"

namespace swiftlet {
namespace {

using Limits = TrackBeforeDetectLimits;

/// [m] Least range that divides, for returns and targets at the sensor itself. Larger values distort near targets.
constexpr double kLeastRange_m = 1e-3;

/// [m] Standard deviation of single returns about the center of a target, per axis. Larger values trust single returns
/// less, so that tracks follow turns later.
constexpr double kSigmaSampling_m = 0.15;

Matrix7 Sigma_w_of(const ExpectedNoise& config) {
  MeasurementNoise noise;
  noise.sigma_range_m = config.sigma_range_m;
  noise.sigma_position_m.setConstant(config.sigma_position_m);
  noise.sigma_attitude_rad.setConstant(config.sigma_attitude_rad);
  return noise.Sigma_w();
}

}  // namespace

SweepReturns::SweepReturns(const TrackBeforeDetectConfig& config)
    : Sigma_w_(Sigma_w_of(config.noise)),
      sigma_attitude_rad_(config.noise.sigma_attitude_rad),
      cluster_distance_m_(config.cluster_distance_m),
      seen_side_m_(config.target.seen_side_m),
      of_(static_cast<std::size_t>(config.max_hypotheses)) {
  candidates_.reserve(Limits::kMaxCandidates);
}

void SweepReturns::begin_sweep(const LocalCloud& cloud, std::span<const Eigen::Vector3f> empty_lidar) {
  beams_.assign(cloud, empty_lidar);
}

void SweepReturns::find(const LocalCloud& cloud, LearnedAir& air) {
  candidates_.clear();
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Vector3 p_m = cloud.points_local_m[i].cast<double>();
    const double range_m = (p_m - beams_.p_local_lidar_m()).norm();
    if (air.is_background(p_m) || range_m > Limits::kMaxRange_m || candidates_.size() == Limits::kMaxCandidates) {
      air.hit(p_m, 1.0);
      continue;
    }
    const bool in_free_air = air.is_free(p_m, Limits::kReach_sigma * sigma_attitude_rad_ * range_m);
    candidates_.push_back({cloud.points_local_m[i], static_cast<std::uint32_t>(i), in_free_air, false});
  }
}

void SweepReturns::assign(const LocalCloud& cloud, std::span<const Hypothesis> hypotheses) {
  assign_to_targets(cloud, hypotheses);
  assign_clusters(cloud, hypotheses);
}

void SweepReturns::assign_to_targets(const LocalCloud& cloud, std::span<const Hypothesis> hypotheses) {
  gate_information_.clear();
  spread_.clear();
  for (std::size_t k = 0; k < hypotheses.size(); ++k) {
    of_[k].clear();
    const Hypothesis& h = hypotheses[k];
    const Matrix3 S =
        h.position_covariance() + pose_covariance(h.p_local_m()) + sampling_sq(h.size_m) * Matrix3::Identity();
    gate_information_.push_back(S.inverse());
    spread_.push_back(h.size_m > 0.0 ? 3.0 * elementary::log(sampling_sq(h.size_m) / sampling_sq(Limits::kSmallest_m))
                                     : 0.0);
  }
  for (std::size_t c = 0; c < candidates_.size(); ++c) {
    double least = std::numeric_limits<double>::infinity();
    int nearest = -1;
    const Vector3 p_m = candidates_[c].p_local_m.cast<double>();
    const double dt_s = to_seconds(cloud.time_of(candidates_[c].point) - beams_.middle());
    for (std::size_t k = 0; k < hypotheses.size(); ++k) {
      const Hypothesis& h = hypotheses[k];
      if (h.existence < Limits::kTarget) break;  // the likeliest come first
      const Vector3 d_m = p_m - h.p_local_m() - dt_s * h.v_local_mps();
      if (d_m.squaredNorm() > Limits::kGateMost_m * Limits::kGateMost_m) continue;
      const double distance_sq = d_m.dot(gate_information_[k] * d_m);
      if (distance_sq >= Limits::kGate || distance_sq + spread_[k] >= least) continue;
      least = distance_sq + spread_[k];
      nearest = static_cast<int>(k);
    }
    if (nearest < 0) continue;
    of_[static_cast<std::size_t>(nearest)].push_back(static_cast<std::uint32_t>(c));
    candidates_[c].taken = true;
  }
}

void SweepReturns::assign_clusters(const LocalCloud& cloud, std::span<const Hypothesis> hypotheses) {
  loose_m_.clear();
  loose_.clear();
  for (std::size_t c = 0; c < candidates_.size(); ++c) {
    if (candidates_[c].taken) continue;
    loose_m_.push_back(candidates_[c].p_local_m);
    loose_.push_back(static_cast<std::uint32_t>(c));
  }
  clusters_.compute(loose_m_, cluster_distance_m_);
  cluster_taken_.assign(static_cast<std::size_t>(clusters_.size()), 0);
  for (std::size_t k = 0; k < hypotheses.size(); ++k) {
    const Hypothesis& h = hypotheses[k];
    if (h.existence >= Limits::kTarget) continue;
    double least = Limits::kGate;
    int nearest = -1;
    for (int cluster = 0; cluster < clusters_.size(); ++cluster) {
      if (cluster_taken_[static_cast<std::size_t>(cluster)]) continue;
      const std::uint32_t first = clusters_.members(cluster).front();
      const double dt_s = to_seconds(cloud.time_of(candidates_[loose_[first]].point) - beams_.middle());
      const Vector3 d_m = loose_m_[first].cast<double>() - h.p_local_m() - dt_s * h.v_local_mps();
      const double distance_sq = d_m.dot(gate_information_[k] * d_m);
      if (d_m.squaredNorm() > Limits::kGateMost_m * Limits::kGateMost_m || distance_sq >= least) continue;
      least = distance_sq;
      nearest = cluster;
    }
    if (nearest < 0) continue;
    cluster_taken_[static_cast<std::size_t>(nearest)] = 1;
    for (const std::uint32_t member : clusters_.members(nearest)) of_[k].push_back(loose_[member]);
  }
}

void SweepReturns::positions_of(std::size_t hypothesis, std::vector<Vector3>& positions_local_m) const {
  positions_local_m.clear();
  for (const std::uint32_t c : of_[hypothesis]) positions_local_m.push_back(candidates_[c].p_local_m.cast<double>());
}

std::span<const std::uint32_t> SweepReturns::members(int cluster) {
  members_.clear();
  for (const std::uint32_t member : clusters_.members(cluster)) members_.push_back(loose_[member]);
  return members_;
}

TargetMeasurement SweepReturns::measure(const LocalCloud& cloud, std::span<const std::uint32_t> candidates,
                                        double size_m) const {
  TargetMeasurement m;
  Vector3 sum_m = Vector3::Zero();
  Eigen::AlignedBox3d box;
  std::int64_t sum_ns = 0;
  m.in_free_air = true;
  for (const std::uint32_t c : candidates) {
    const Vector3 p_m = candidates_[c].p_local_m.cast<double>();
    sum_m += p_m;
    box.extend(p_m);
    m.in_free_air = m.in_free_air && candidates_[c].in_free_air;
    sum_ns += cloud.time_of(candidates_[c].point) - cloud.stamp();
    m.reflectivity = std::max(m.reflectivity, static_cast<double>(cloud.reflectivity_of(candidates_[c].point)));
  }
  const auto count = static_cast<double>(candidates.size());
  m.num_returns = static_cast<int>(candidates.size());
  m.t = cloud.stamp() + sum_ns / static_cast<std::int64_t>(candidates.size());
  m.extent_m = box.sizes();
  const Vector3 centroid_m = sum_m / count;
  const Vector3 from_lidar_m = centroid_m - beams_.p_local_lidar_m();
  m.p_local_m = centroid_m + seen_side_m_ / std::max(from_lidar_m.norm(), kLeastRange_m) * from_lidar_m;
  m.covariance =
      pose_covariance(centroid_m) + sampling_sq(size_m) * (1.0 / count + Limits::kSameSide) * Matrix3::Identity();
  return m;
}

// Variance [m^2] of single returns about the center, per axis. On a uniform bar, the deviation is 0.29 of its length.
double SweepReturns::sampling_sq(double size_m) const {
  const double sigma_m = std::max(kSigmaSampling_m, 0.25 * size_m);
  return sigma_m * sigma_m;
}

Matrix3 SweepReturns::pose_covariance(const Vector3& p_local_m) const {
  const Vector3 p_lidar_m = beams_.R_local_lidar().transpose() * (p_local_m - beams_.p_local_lidar_m());
  const double range_m = std::max(p_lidar_m.norm(), kLeastRange_m);
  return point_covariance(p_lidar_m / range_m, range_m, beams_.R_local_lidar(), Sigma_w_);
}

}  // namespace swiftlet
