// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/detection/beam_index.hpp"
#include "core/detection/hypothesis.hpp"
#include "core/detection/learned_air.hpp"
#include "swiftlet/core/detection/euclidean_clusters.hpp"
#include "swiftlet/core/detection/track_before_detect_config.hpp"

namespace swiftlet {

/// Return that may be of a target: the clutter share of its voxel is low.
struct Candidate {
  Eigen::Vector3f p_local_m;
  std::uint32_t point;  ///< index of the point in the cloud
  bool in_free_air;     ///< the voxels around are free air too
  bool taken;           ///< assigned to a target
};

/// Returns assigned to one target.
struct TargetMeasurement {
  Vector3 p_local_m = Vector3::Zero();
  Vector3 extent_m = Vector3::Zero();
  Matrix3 covariance = Matrix3::Identity();
  TimeNs t = 0;
  int num_returns = 0;
  double reflectivity = 0.0;
  bool in_free_air = false;

  /// Stores the measurement as the newest one of a hypothesis.
  void keep_in(Hypothesis& h) const {
    h.num_returns = num_returns;
    h.extent_m = extent_m;
    h.measured_local_m = p_local_m;
    h.measured_covariance = covariance;
    h.reflectivity = reflectivity;
  }
};

/// Returns of one sweep outside of known background, their assignment to hypotheses, and the resulting measurements.
/// Reuses its memory.
class SweepReturns {
 public:
  explicit SweepReturns(const TrackBeforeDetectConfig& config);

  /// @param empty_lidar  directions without return, for a driver that reports points only
  void begin_sweep(const LocalCloud& cloud, std::span<const Eigen::Vector3f> empty_lidar);
  const BeamIndex& beams() const { return beams_; }
  /// Candidates are the returns where no background is expected; the others become background at once.
  void find(const LocalCloud& cloud, LearnedAir& air);
  /// Each return goes to the nearest target, so that targets flying side by side stay apart. The remaining ones are
  /// clustered; each other hypothesis takes its most likely cluster. @param hypotheses  the likeliest first
  void assign(const LocalCloud& cloud, std::span<const Hypothesis> hypotheses);

  const Eigen::Vector3f& position_m(std::uint32_t candidate) const { return candidates_[candidate].p_local_m; }
  /// Candidates assigned to a hypothesis.
  std::span<const std::uint32_t> of(std::size_t hypothesis) const { return of_[hypothesis]; }
  /// Assigns the candidates of `other` to `hypothesis` too.
  void add_to(std::size_t hypothesis, std::size_t other) {
    of_[hypothesis].insert(of_[hypothesis].end(), of_[other].begin(), of_[other].end());
  }
  void positions_of(std::size_t hypothesis, std::vector<Vector3>& positions_local_m) const;

  int num_clusters() const { return clusters_.size(); }
  bool is_assigned(int cluster) const { return cluster_taken_[static_cast<std::size_t>(cluster)] != 0; }
  /// Candidates of a cluster; valid until the next call.
  std::span<const std::uint32_t> members(int cluster);

  /// @param size_m  diameter of a body merged from parts; 0: not known to be large
  TargetMeasurement measure(const LocalCloud& cloud, std::span<const std::uint32_t> candidates, double size_m) const;
  /// Covariance [m^2] of a return at a position, by the noise of pose and range: J Sigma_w J^T [Vrba 2025, eq. 44].
  Matrix3 pose_covariance(const Vector3& p_local_m) const;

 private:
  void assign_to_targets(const LocalCloud& cloud, std::span<const Hypothesis> hypotheses);
  void assign_clusters(const LocalCloud& cloud, std::span<const Hypothesis> hypotheses);
  double sampling_sq(double size_m) const;

  Eigen::Matrix<double, 7, 7> Sigma_w_;
  double sigma_attitude_rad_, cluster_distance_m_, seen_side_m_;
  BeamIndex beams_;
  std::vector<Candidate> candidates_;
  std::vector<std::vector<std::uint32_t>> of_;  // candidates, by hypothesis
  std::vector<Eigen::Vector3f> loose_m_;        // positions [m] of the candidates that no target took
  std::vector<std::uint32_t> loose_, members_;  // their numbers; candidates of the cluster of the last members()
  std::vector<Matrix3> gate_information_;
  // Log determinant of the spread of the returns of each hypothesis, relative to kSmallest_m. Added to the distance, so
  // that a wide gate does not take returns from a narrow one.
  std::vector<double> spread_;
  EuclideanClusters clusters_;
  std::vector<char> cluster_taken_;
};

}  // namespace swiftlet
