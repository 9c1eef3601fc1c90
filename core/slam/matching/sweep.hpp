// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "swiftlet/core/base/scan.hpp"
#include "swiftlet/core/localization/dead_reckoning.hpp"

namespace swiftlet {

/// Poses of the body during the last seconds as estimated by the filter, at every IMU sample. Only differences of poses
/// are used, so a correction moves all of them equally.
class MotionHistory {
 public:
  void push(TimeNs t, const Vector3& p_local_m, const Eigen::Quaterniond& q_local_body);
  /// Transforms the whole history by a correction in the local frame.
  void move(const Pose& T_new_old);
  /// Changes velocity and body rate of the history; the pose at t stays fixed.
  void change_velocity(TimeNs t, const Vector3& by_local_mps, const Vector3& by_body_radps = Vector3::Zero());
  /// Mean velocity (local frame) and body rate between two instants.
  Eigen::Matrix<double, 6, 1> mean_motion(TimeNs from, TimeNs to) const;
  /// Pose interpolated between samples, with constant acceleration between samples far apart; outside, the nearest one.
  Pose at(TimeNs t) const;
  bool covers(TimeNs t) const { return count_ > 0 && entry(0).t <= t; }
  bool empty() const { return count_ == 0; }

 private:
  struct Entry {
    TimeNs t = 0;
    Vector3 p_local_m = Vector3::Zero();
    Eigen::Quaterniond q = Eigen::Quaterniond::Identity();
  };
  /// [-] Stored poses: 2.5 s at 400 Hz. Must cover a sweep and its latency; larger values take memory.
  static constexpr int kCapacity = 1024;
  using Vector6 = Eigen::Matrix<double, 6, 1>;
  const Entry& entry(int i) const { return ring_[(first_ + i) % kCapacity]; }
  Vector6 mean_rates(int i) const;
  Vector6 acceleration(int i) const;

  std::vector<Entry> ring_ = std::vector<Entry>(kCapacity);
  int first_ = 0, count_ = 0;
  mutable int cursor_ = 0;                  // index of the last lookup; times of successive beams rarely decrease
  mutable int bent_ = -1;                   // index of the interval of bend_; -1: none
  mutable Vector6 bend_ = Vector6::Zero();  // acceleration (local frame) and angular acceleration (body) in it
};

/// Keeps the first point in every voxel, in the order of the points. Any frame, the same for all arguments.
class VoxelThinner {
 public:
  /// Appends the indices of the kept points.
  void thin(std::span<const Eigen::Vector3f> points_m, float edge_m, std::vector<std::uint32_t>& kept);
  /// Replaces `kept_m` by the kept points.
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

/// Returns of a scan in the body frame at time t: each point is compensated for the motion since its firing.
///
/// @param own_radius_m  returns within this radius of the body's origin are from the vehicle itself
/// @param time_offset  time of the motion minus time of the scan at the same instant
void undistort(const Scan& scan, const MotionHistory& motion, TimeNs t, double own_radius_m, double range_max_m,
               std::vector<Eigen::Vector3f>& points_body_m, TimeNs time_offset = 0);

}  // namespace swiftlet
