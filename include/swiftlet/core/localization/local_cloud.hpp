// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "swiftlet/core/base/scan.hpp"
#include "swiftlet/core/localization/frame_change.hpp"
#include "swiftlet/core/localization/local_poses.hpp"

namespace swiftlet {

/// One sweep in the vehicle's local frame, each beam transformed by the pose at its firing time: the point cloud P of
/// Vrba 2025. Each scan is registered once, for all stages that use it. Reused from sweep to sweep; keeps the scan
/// alive.
struct LocalCloud {
  std::shared_ptr<const Scan> scan;             ///< includes the rays without return
  std::vector<Pose> T_local_lidar;              ///< sensor pose at the firing of each column           (scan->cols())
  std::vector<Eigen::Vector3f> points_local_m;  ///< returns only: finite, not masked, not the own body
  std::vector<std::uint32_t> beam;              ///< index in the scan of each point

  std::size_t size() const { return points_local_m.size(); }
  TimeNs stamp() const { return scan->stamp; }  ///< start of the sweep
  TimeNs end() const { return scan->stamp + scan->duration; }
  TimeNs time_of(std::size_t point) const { return scan->time_of(static_cast<int>(beam[point])); }
  /// 1 = white Lambertian; 0 when the scan has no reflectivity.
  float reflectivity_of(std::size_t point) const {
    return scan->reflectivity.empty() ? 0.0F : scan->reflectivity[beam[point]];
  }
  const Pose& T_local_lidar_of_beam(int i) const { return T_local_lidar[i % scan->cols()]; }
};

/// Makes local clouds from scans and the estimates of the last seconds. A scan with its own poses in the world
/// (Scan::external_poses) is registered by them, transformed into the local frame by the present correction.
class CloudRegistrar {
 public:
  /// @param own_radius_m  returns within this radius of the body's origin are from the vehicle itself
  explicit CloudRegistrar(double own_radius_m) : own_radius_m_(own_radius_m) {}

  /// Adds an estimate, in order of time.
  void push(const StateEstimate& estimate);
  const LocalPoses& poses() const { return poses_; }
  /// False when no pose is known for the scan. Before the first and after the last pose, the nearest one is used.
  bool make(std::shared_ptr<const Scan> scan, LocalCloud& cloud);

 private:
  void place_columns(const Scan& scan, std::vector<Pose>& T_local_lidar);

  double own_radius_m_;
  LocalPoses poses_;
  FrameChange to_local_;
  std::vector<TimedPose> external_poses_;  // scratch: external poses in the local frame
};

/// Pool of local clouds: a cloud's memory is reused once no stage references it.
class LocalCloudPool {
 public:
  /// Null when no pose is known for the scan.
  std::shared_ptr<const LocalCloud> make(std::shared_ptr<const Scan> scan, CloudRegistrar& registrar);

 private:
  std::vector<std::shared_ptr<LocalCloud>> clouds_;
};

}  // namespace swiftlet
