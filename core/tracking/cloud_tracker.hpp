// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/tracking/cloud_buffer.hpp"
#include "swiftlet/core/base/config.hpp"
#include "swiftlet/core/base/counter.hpp"
#include "swiftlet/core/base/detection.hpp"
#include "swiftlet/core/base/track.hpp"
#include "swiftlet/core/detection/euclidean_clusters.hpp"
#include "swiftlet/core/map/background_query.hpp"
#include "swiftlet/core/math/assignment.hpp"
#include "swiftlet/core/tracking/cloud_tracker_config.hpp"
#include "swiftlet/core/tracking/motion_filter.hpp"
#include "swiftlet/core/uncertainty/point_covariance.hpp"

namespace swiftlet {

/// Tracks any number of flying objects through the clouds of a LiDAR, from detections that may be older than the newest
/// cloud [Vrba 2025, sec. III-F]. Clouds, detections and tracks are in the local frame.
class CloudTracker {
 public:
  CloudTracker(const CloudTrackerConfig& config, std::unique_ptr<MotionFilter> filter);

  /// Routine newPointCloud(). A cloud not newer than the last one is ignored.
  /// @param background  occupied voxels O; null: unknown
  void new_cloud(const LocalCloud& cloud, const BackgroundQuery* background);
  /// Routine newDetections(): each detection is propagated through the buffered clouds that are newer.
  void new_detections(std::span<const Detection> detections, const BackgroundQuery* background);

  /// Tracks with enough detections, in order of their identity.
  void publish(std::vector<Track>& tracks) const;
  /// Mode estimates of the tracks, in the same order; empty when the filter has one model.
  void publish_modes(std::vector<TrackModes>& modes) const;
  int num_tracks() const { return static_cast<int>(targets_.size()); }  ///< including unpublished ones
  void append_counters(std::vector<Counter>& counters) const;

  /// r_unc of eq. (29) [m].
  double uncertainty_radius_m(const Matrix3& position_covariance) const;

 private:
  struct Target {
    std::uint32_t id = 0;
    TimeNs t = 0;  // time of the state
    MotionState state;
    int num_detections = 0;
    bool corrected = false;
    Vector3 measured_local_m = Vector3::Zero();  // newest measurement
    Matrix3 measured_covariance = Matrix3::Identity();
    float reflectivity = 0.0F;
  };
  /// A cluster that may be a target.
  struct Candidate {
    Vector3 position_local_m;
    Matrix3 covariance;  // Z
    TimeNs t;
    float reflectivity;                      // maximum
    std::span<const std::uint32_t> members;  // indices into selected_
  };

  void update(std::span<Target> targets, const BufferedCloud& cloud, const BackgroundQuery* background);
  void find_candidates(std::span<const Target> targets, const BufferedCloud& cloud, const BackgroundQuery* background);
  bool is_background(const Vector3& position_local_m, double size_m, const BufferedCloud& cloud,
                     std::span<const std::uint32_t> members, const BackgroundQuery* background);
  void assign(std::span<const Target> targets);
  Target start(const Detection& detection) const;
  void associate(Target target);
  void merge();
  void forget();
  double search_radius_m(const Target& target) const;
  double association_radius_m(const Target& target) const;
  Matrix3 measurement_covariance(const Vector3& position_local_m, const BufferedCloud& cloud) const;
  Matrix3 position_covariance(const Vector3& position_local_m, const Pose& T_local_lidar) const;

  CloudTrackerConfig config_;
  std::unique_ptr<MotionFilter> filter_;
  Matrix7 Sigma_w_;
  CloudBuffer buffer_;
  std::vector<Target> targets_;
  std::uint32_t next_id_ = 1;
  std::uint64_t num_clouds_ = 0, num_late_clouds_ = 0;
  std::uint64_t num_detections_ = 0, num_late_detections_ = 0;

  // Scratch memory of one update, reused.
  std::vector<Target> predicted_;
  std::vector<std::uint32_t> selected_, around_;
  std::vector<Eigen::Vector3f> selected_points_;
  EuclideanClusters clusters_;
  std::vector<Candidate> candidates_;
  Assignment assignment_;
  std::vector<double> costs_;
  std::vector<int> chosen_;
};

}  // namespace swiftlet
