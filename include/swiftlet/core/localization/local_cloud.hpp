// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "swiftlet/core/localization/frame_change.hpp"
#include "swiftlet/core/localization/local_poses.hpp"
#include "swiftlet/core/scan.hpp"

namespace swiftlet {

/// One sweep in the vehicle's local frame, every beam carried by the pose at its own firing: the point cloud P of Vrba
/// 2025. Each scan is placed once, for all stages that look at it. Reused from sweep to sweep; holds on to the scan.
struct LocalCloud {
  std::shared_ptr<const Scan> scan;             ///< rays without return are found there
  std::vector<Pose> T_local_lidar;              ///< of the sensor at the firing of each column           (scan->cols())
  std::vector<Eigen::Vector3f> points_local_m;  ///< returns only: finite, not masked, not the own body
  std::vector<std::uint32_t> beam;              ///< of each point, index into the scan

  std::size_t size() const { return points_local_m.size(); }
  TimeNs stamp() const { return scan->stamp; }  ///< start of the sweep
  TimeNs end() const { return scan->stamp + scan->duration; }
  TimeNs time_of(std::size_t point) const { return scan->time_of(static_cast<int>(beam[point])); }
  /// 1 = white Lambertian; 0 when the scan does not tell.
  float reflectivity_of(std::size_t point) const {
    return scan->reflectivity.empty() ? 0.0F : scan->reflectivity[beam[point]];
  }
  const Pose& T_local_lidar_of_beam(int i) const { return T_local_lidar[i % scan->cols()]; }
};

/// Makes local clouds from scans and the estimates of the last seconds. A scan that tells its own poses in the world
/// (Scan::external_poses) is placed by them, carried into the local frame by the present correction.
class CloudRegistrar {
 public:
  /// @param own_radius_m  returns nearer than this to the body's origin are the vehicle itself
  explicit CloudRegistrar(double own_radius_m) : own_radius_m_(own_radius_m) {}

  /// Every estimate, in order of time.
  void push(const StateEstimate& estimate);
  const LocalPoses& poses() const { return poses_; }
  /// False when no pose is known for the scan. Poses beyond the known ones are the nearest known.
  bool make(std::shared_ptr<const Scan> scan, LocalCloud& cloud);

 private:
  void place_columns(const Scan& scan, std::vector<Pose>& T_local_lidar);

  double own_radius_m_;
  LocalPoses poses_;
  FrameChange to_local_;
  std::vector<TimedPose> told_;  // scratch: external poses in the local frame
};

/// Local clouds whose memory is used again when nobody holds on to them any more.
class LocalCloudPool {
 public:
  /// Null when no pose is known for the scan.
  std::shared_ptr<const LocalCloud> make(std::shared_ptr<const Scan> scan, CloudRegistrar& registrar);

 private:
  std::vector<std::shared_ptr<LocalCloud>> clouds_;
};

}  // namespace swiftlet
