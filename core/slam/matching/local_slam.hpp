// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/slam/matching/inertial_filter.hpp"
#include "core/slam/matching/innovation_monitor.hpp"
#include "core/slam/matching/scan_matcher.hpp"
#include "core/slam/matching/surface_matcher.hpp"
#include "core/slam/matching/sweep.hpp"
#include "swiftlet/core/base/config.hpp"
#include "swiftlet/core/base/scan.hpp"
#include "swiftlet/core/localization/estimator.hpp"
#include "swiftlet/core/localization/local_poses.hpp"
#include "swiftlet/core/slam/local_slam_config.hpp"

namespace swiftlet {

/// Covariance of the local error of the map. The filter of the vehicle estimates its pose relative to the map.
///
/// An inserted scan carries the error of its pose into the map. So the error of the map is that of its scans, each
/// weighted by its share in the renewal of the map.
class MapDrift {
 public:
  /// @param level_covariance_rad2  of the rotation vector between the local frame and a level one
  explicit MapDrift(const Vector3& p_local_m, const Matrix3& level_covariance_rad2 = Matrix3::Zero())
      : p_local_m_(p_local_m) {
    C_.bottomRightCorner<3, 3>() = level_covariance_rad2;
  }
  void move_to(const Vector3& p_local_m);
  /// Updates the covariance after an insertion. Covariances are of position (local frame) and attitude (body axes).
  void inherit(const Matrix6& covariance, const Matrix3& R_local_body);
  Matrix6 covariance(const Matrix3& R_local_body) const;

 private:
  Vector3 p_local_m_;
  Matrix6 C_ = Matrix6::Zero();  // covariance of position and rotation vector, both in local axes
};

/// Result of one scan.
struct ScanOutcome {
  bool used = false;  ///< the scan corrected the estimate, or started the map
  ScanFit fit;        ///< fit at the last iterate
  int num_iterations = 0;
  bool inserted = false;
  bool out_of_range = false;  ///< more returns lie beyond range_max_m than within
};

/// Scan-to-scan motion and the local map. Scans are motion-compensated by the IMU and matched to the map, fused with
/// inertial propagation, and inserted. Without loop closures the estimate drifts, slowly and smoothly.
class LocalSlam {
 public:
  /// @param matcher  method of scan matching; null: surfaces
  LocalSlam(const LocalSlamConfig& config, const Pose& T_local_body_start, double own_radius_m,
            std::unique_ptr<ScanMatcher> matcher = nullptr);

  /// States the time of the start pose, on the IMU's clock. Otherwise it is that of the first sample.
  void begin_at(TimeNs t) { start_time_ = t; }
  void add(const ImuSample& sample);
  /// Adds a scan. The state is propagated to its end if the last IMU sample is older.
  /// @param others  nearby flying vehicles, whose returns are removed
  ScanOutcome add(std::shared_ptr<const Scan> scan, std::vector<SeenVehicle> others = {});

  const InertialFilter& filter() const { return filter_; }
  const ScanMatcher& matcher() const { return *matcher_; }
  /// True when the initialization is over, so that the map is no longer rebuilt.
  bool started() const { return start_.over; }
  const InnovationMonitor& innovations() const { return innovations_; }
  /// Time of the end of a scan on the IMU's clock.
  TimeNs imu_time_of_end(const Scan& scan) const { return scan.stamp + scan.duration + time_offset(); }
  TimeNs time_offset() const { return from_seconds(filter_.state().time_offset_s); }
  /// Time and pose of the last insertion into the map.
  const TimedPose& inserted_at() const { return inserted_; }
  /// Points of the last scan, thinned for the map.
  std::span<const Eigen::Vector3f> points_body_m() const { return matcher_->points_body_m(); }
  /// Covariance of the pose in the local frame, ahead_s after the state of the filter: the covariance relative to the
  /// map by the filter, plus the covariances of the visible planes and of the drift of the map.
  /// @param filter  the own filter, or a copy propagated from it
  Matrix6 pose_covariance(const InertialFilter& filter, double ahead_s) const;

 private:
  /// [m/s] Standard deviation of the velocity above which a scan counts as smeared. Larger values align fewer scans
  /// coarsely.
  static constexpr double kUnknown_mps = 0.3;
  /// [rad] Correction of the predicted attitude above which a scan without IMU counts as blurred: a rotation that the
  /// prediction did not contain. Larger values blur the planes of the map, smaller ones leave scans of curves out of
  /// it.
  static constexpr double kBlur_rad = 0.06;

  /// Initialization: the first scans are processed again with the biases, the time offset and the velocity
  /// estimated from them.
  struct Start {
    /// [-] Largest number of IMU samples kept. The start is not repeated if the first scans need more.
    static constexpr std::size_t kMaxSamples = 4096;
    std::vector<ImuSample> imu;
    struct Swept {
      std::size_t after_sample = 0;
      std::shared_ptr<const Scan> scan;
      std::vector<SeenVehicle> others;
    };
    std::vector<Swept> scans;
    bool over = false;
    /// The time offset is not estimated: errors of the first velocities would count as an offset.
    bool keeps_offset = true;
    /// How well the last pass explains the first scans.
    struct Agreement {
      double sum_of_innovations = 0.0;  // normalized squares per direction
      int num_innovations = 0;
      double sum_of_near = 0.0;  // shares of points near surfaces of the map
      int num_fits = 0;

      void add_innovation(double innovation_sq, int num_directions) {
        if (num_directions <= 0) return;
        sum_of_innovations += innovation_sq / num_directions;
        ++num_innovations;
      }
      void add_fit(const ScanFit& fit) {
        sum_of_near += static_cast<double>(fit.num_near) / std::max(fit.num_points, 1);
        ++num_fits;
      }
      double mean_innovation() const { return num_innovations > 0 ? sum_of_innovations / num_innovations : 0.0; }
      double mean_near() const { return num_fits > 0 ? sum_of_near / num_fits : 0.0; }
    } agreement;
  };
  bool has_unknown_start() const { return !start_.over && config_.imu.start_velocity_sigma_mps > kUnknown_mps; }
  void begin_again();
  void find_time_offset();
  void repeat_until_settled(const InertialFilter& learned);
  InertialFilter best_of_time_offsets();
  InertialFilter best_of_start_velocities();
  InertialFilter learned_start();
  void repeat_start(const InertialFilter& filter);
  Vector3 velocity_gained(const InertialFilter& learned) const;
  ScanOutcome match(const Scan& scan, std::span<const SeenVehicle> others);
  void reach_end(const Scan& scan);
  void update(const Scan& scan, std::span<const SeenVehicle> others, double smear_m, ScanOutcome& outcome);
  std::optional<Pose> align_coarsely(const Scan& scan, std::span<const SeenVehicle> others);
  void correct_motion(const NavState& before, bool velocity);
  void gather(const Scan& scan, std::span<const SeenVehicle> others);
  void leave_out(std::span<const SeenVehicle> others);
  void learn_shared_covariance(const ScanFit& fit);
  bool due_for_map() const;
  bool is_blurred() const { return filter_.is_coasting() && motion_known_ && turned_rad_ > kBlur_rad; }
  void insert();

  LocalSlamConfig config_;
  Pose T_local_body_start_;
  std::optional<TimeNs> start_time_;
  double own_radius_m_;
  Start start_;
  /// Covariance of the rotation vector between the local frame and a level one; 0 unless the first scans level it.
  Matrix3 level_covariance_rad2_ = Matrix3::Zero();
  InertialFilter filter_;
  MotionHistory motion_;
  std::unique_ptr<ScanMatcher> matcher_;
  ScanMatcher::Admission admission_;
  InnovationMonitor innovations_;
  MapDrift drift_;
  Matrix6 shared_covariance_ = Matrix6::Zero();  // covariance of the pose due to map errors common to successive scans

  TimedPose inserted_;  // last insertion
  int num_inserted_ = 0;
  double turned_rad_ = 0.0;                      // correction of the predicted attitude by the last scan
  bool motion_known_ = false;                    // the map holds scans of known motion
  std::vector<Eigen::Vector3f> returns_body_m_;  // scratch of one scan
};

}  // namespace swiftlet
