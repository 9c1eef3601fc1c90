// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "swiftlet/core/config.hpp"
#include "swiftlet/core/localization/estimator.hpp"
#include "swiftlet/core/localization/local_poses.hpp"
#include "swiftlet/core/scan.hpp"
#include "swiftlet/core/slam/inertial_filter.hpp"
#include "swiftlet/core/slam/scan_matcher.hpp"
#include "swiftlet/core/slam/surface_matcher.hpp"
#include "swiftlet/core/slam/sweep.hpp"

namespace swiftlet {

/// Covariance of what is wrong with the map where the vehicle is. The vehicle's own filter knows its pose in the map.
///
/// A scan that goes into the map takes the error of its pose along. So the map is off by what its scans were off by,
/// each as far as it has renewed it.
class MapDrift {
 public:
  explicit MapDrift(const Vector3& p_local_m) : p_local_m_(p_local_m) {}
  void move_to(const Vector3& p_local_m);
  /// A scan went into the map. Covariances are of position (local frame) and attitude (body axes).
  void inherit(const Matrix6& covariance, const Matrix3& R_local_body);
  Matrix6 covariance(const Matrix3& R_local_body) const;

 private:
  Vector3 p_local_m_;
  Matrix6 C_ = Matrix6::Zero();  // of position and rotation vector, both in local axes
};

struct LocalSlamConfig : SurfaceMatchingConfig {
  InertialConfig imu;
  double range_max_m = 100.0;
  int start_scans = 10;
  double known_share_min = 0.3;
  double vehicle_radius_m = 1.0;

  void visit(ConfigVisitor& v);
};

/// What one scan did.
struct ScanOutcome {
  bool used = false;  ///< it moved the estimate, or began the map
  ScanFit fit;        ///< at the last iterate
  int num_iterations = 0;
  bool inserted = false;
};

/// Motion from scan to scan and the map nearby. Scans are carried to one instant by the IMU's motion and matched to the
/// map, together with what the IMU says. Then they go into it. It closes no loops, so it drifts, slowly and smoothly.
class LocalSlam {
 public:
  /// @param matcher  by what scans find their pose; none: by surfaces
  LocalSlam(const LocalSlamConfig& config, const Pose& T_local_body_start, double own_radius_m,
            std::unique_ptr<ScanMatcher> matcher = nullptr);

  void add(const ImuSample& sample);
  /// A scan that ended not after the last IMU sample.
  /// @param others  vehicles that fly nearby: what the scan saw of them is left out
  ScanOutcome add(std::shared_ptr<const Scan> scan, std::vector<SeenVehicle> others = {});

  const InertialFilter& filter() const { return filter_; }
  const ScanMatcher& matcher() const { return *matcher_; }
  /// Is the start over, so that what is in the map stays as it is?
  bool started() const { return start_.over; }
  /// When and where the last scan went into the map.
  const TimedPose& inserted_at() const { return inserted_; }
  /// Of the scan that was added last, thinned for the map.
  std::span<const Eigen::Vector3f> points_body_m() const { return matcher_->points_body_m(); }
  /// Of the pose in the local frame: that of a filter, relative to the map, and that of the planes in sight. That of
  /// what the map has drifted is in it, too. The filter is this one, or this one carried on.
  Matrix6 pose_covariance(const InertialFilter& filter) const;

 private:
  /// What the vehicle learns of its biases in the first scans makes them anew.
  struct Start {
    std::vector<ImuSample> imu;
    struct Swept {
      std::size_t after_sample = 0;
      std::shared_ptr<const Scan> scan;
      std::vector<SeenVehicle> others;
    };
    std::vector<Swept> scans;
    bool over = false;
  };
  void begin_again();
  Vector3 velocity_gained(const InertialFilter& learned) const;
  ScanOutcome match(const Scan& scan, std::span<const SeenVehicle> others);
  void gather(const Scan& scan, std::span<const SeenVehicle> others);
  void leave_out(std::span<const SeenVehicle> others);
  void learn_doubt(const ScanFit& fit);
  bool due_for_map() const;
  void insert();

  LocalSlamConfig config_;
  Pose T_local_body_start_;
  double own_radius_m_;
  Start start_;
  InertialFilter filter_;
  MotionHistory motion_;
  std::unique_ptr<ScanMatcher> matcher_;
  ScanMatcher::Admission admission_;
  MapDrift drift_;
  Matrix6 shared_covariance_ = Matrix6::Zero();  // of the pose, by errors of the map that scans share

  TimedPose inserted_;  // the last scan that went into the map
  int num_inserted_ = 0;
  std::vector<Eigen::Vector3f> returns_body_m_;  // of one scan
};

}  // namespace swiftlet
