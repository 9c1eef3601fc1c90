// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "swiftlet/core/localization/dead_reckoning.hpp"
#include "swiftlet/core/scan.hpp"

namespace swiftlet {

/// Where the body was during the last seconds, as the filter knew it: at every IMU sample. Only differences of poses
/// count, so that a correction moves all of them alike.
class MotionHistory {
 public:
  void push(TimeNs t, const Vector3& p_local_m, const Eigen::Quaterniond& q_local_body);
  /// The whole past, moved by a correction in the local frame.
  void move(const Pose& T_new_old);
  /// The speed turned out to be another one: the past moves, but for the instant t.
  void change_velocity(TimeNs t, const Vector3& by_local_mps);
  /// Interpolated between samples; the nearest known one outside of them.
  Pose at(TimeNs t) const;
  bool covers(TimeNs t) const { return count_ > 0 && entry(0).t <= t; }
  bool empty() const { return count_ == 0; }

 private:
  struct Entry {
    TimeNs t = 0;
    Vector3 p_local_m = Vector3::Zero();
    Eigen::Quaterniond q = Eigen::Quaterniond::Identity();
  };
  static constexpr int kCapacity = 1024;
  const Entry& entry(int i) const { return ring_[(first_ + i) % kCapacity]; }

  std::vector<Entry> ring_ = std::vector<Entry>(kCapacity);
  int first_ = 0, count_ = 0;
  mutable int cursor_ = 0;  // beams ask for times that hardly ever go back
};

/// Keeps the first point in every cube of a grid, in the order of the points. Any frame, the same for all arguments.
class VoxelThinner {
 public:
  /// Appends the indices of the points that are kept.
  void thin(std::span<const Eigen::Vector3f> points_m, float edge_m, std::vector<std::uint32_t>& kept);
  /// The points themselves, in place of what was in `kept_m`.
  void thin_into(std::span<const Eigen::Vector3f> points_m, float edge_m, std::vector<Eigen::Vector3f>& kept_m);

 private:
  struct Slot {
    std::uint64_t key = 0;
    std::uint32_t round = 0;
  };
  std::vector<Slot> table_;
  std::uint32_t round_ = 0;
  std::vector<std::uint32_t> kept_;
};

/// The returns of a scan in the body frame of one instant: each beam is carried by the motion since it was fired.
///
/// @param own_radius_m  returns nearer than this to the body's origin are the vehicle itself
void undistort(const Scan& scan, const MotionHistory& motion, TimeNs t, double own_radius_m, double range_max_m,
               std::vector<Eigen::Vector3f>& points_body_m);

}  // namespace swiftlet
