// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "swiftlet/core/action.hpp"
#include "swiftlet/core/scan.hpp"

namespace swiftlet {

/// One sweep in the world frame of the agent's own estimate, every beam carried by the pose at its own firing: the
/// point cloud P of Vrba 2025, shared by detection, tracking and mapping. Reused from sweep to sweep; holds on to the
/// scan.
struct WorldCloud {
  std::shared_ptr<const Scan> scan;             ///< rays without return are found there
  std::vector<Pose> T_world_lidar;              ///< of the sensor at the firing of each column           (scan->cols())
  std::vector<Eigen::Vector3f> points_world_m;  ///< returns only: finite, not masked, not the own body
  std::vector<std::uint32_t> beam;              ///< of each point, index into the scan

  std::size_t size() const { return points_world_m.size(); }
  TimeNs stamp() const { return scan->stamp; }  ///< start of the sweep
  TimeNs end() const { return scan->stamp + scan->duration; }
  TimeNs time_of(std::size_t point) const { return scan->time_of(static_cast<int>(beam[point])); }
  const Pose& T_world_lidar_of_beam(int i) const { return T_world_lidar[i % scan->cols()]; }
};

/// Makes world clouds from scans and the estimates of the last second. A scan that tells its own poses
/// (Scan::external_poses) is placed by them.
class CloudRegistrar {
 public:
  /// @param own_radius_m  returns nearer than this to the body's origin are the vehicle itself
  explicit CloudRegistrar(double own_radius_m) : own_radius_m_(own_radius_m) {}

  /// Every estimate, in order of time. Those that are not valid are passed over.
  void push(const StateEstimate& estimate);
  /// Of the body at time t: interpolated, or the nearest known. Not before the first push.
  Pose at(TimeNs t) const;
  /// False when no pose is known for the scan. Poses beyond the known ones are the nearest known.
  bool make(std::shared_ptr<const Scan> scan, WorldCloud& cloud) const;

 private:
  static constexpr int kCapacity = 512;
  const StampedPose& pose(int i) const { return ring_[(first_ + i) % kCapacity]; }
  void place_columns(const Scan& scan, std::vector<Pose>& T_world_lidar) const;

  double own_radius_m_;
  std::array<StampedPose, kCapacity> ring_{};
  int first_ = 0;
  int count_ = 0;
};

/// World clouds whose memory is used again when nobody holds on to them any more.
class WorldCloudPool {
 public:
  /// Null when no pose is known for the scan.
  std::shared_ptr<const WorldCloud> make(std::shared_ptr<const Scan> scan, const CloudRegistrar& registrar);

 private:
  std::vector<std::shared_ptr<WorldCloud>> clouds_;
};

/// The pose at time t between two others; position linear, rotation along the shortest arc. Outside: the nearer one.
Pose interpolate(const StampedPose& before, const StampedPose& after, TimeNs t);

}  // namespace swiftlet
