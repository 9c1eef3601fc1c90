// SPDX-License-Identifier: BSD-3-Clause
#include "core/slam/matching/sweep.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "core/slam/cell_keys.hpp"
#include "swiftlet/core/base/ensure.hpp"
#include "swiftlet/core/localization/rotation.hpp"

namespace swiftlet {
namespace {

// [ns] Interval between samples up to which the motion counts as straight: 50 rad/s^2 bend it by 0.2 mrad. Larger
// values distort the scans of slow IMUs, smaller ones cost time.
constexpr TimeNs kStraight = 5'000'000;

/// Linear interpolation of two attitudes a few milliseconds apart: the error of the angle is of third order.
Eigen::Quaterniond between(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b, double f) {
  const double sign = a.dot(b) < 0.0 ? -1.0 : 1.0;
  Eigen::Quaterniond q;
  q.coeffs() = (1.0 - f) * a.coeffs() + f * sign * b.coeffs();
  return q.normalized();
}

}  // namespace

void MotionHistory::push(TimeNs t, const Vector3& p_local_m, const Eigen::Quaterniond& q_local_body) {
  if (count_ > 0 && t <= entry(count_ - 1).t) return;
  if (count_ < kCapacity) {
    ++count_;
  } else {
    first_ = (first_ + 1) % kCapacity;
    cursor_ = std::max(cursor_ - 1, 0);
  }
  ring_[(first_ + count_ - 1) % kCapacity] = {t, p_local_m, q_local_body};
  bent_ = -1;
}

void MotionHistory::move(const Pose& T_new_old) {
  bent_ = -1;
  const Eigen::Quaterniond turn(T_new_old.linear());
  for (int i = 0; i < count_; ++i) {
    Entry& e = ring_[(first_ + i) % kCapacity];
    e.p_local_m = T_new_old * e.p_local_m;
    e.q = (turn * e.q).normalized();
  }
}

void MotionHistory::change_velocity(TimeNs t, const Vector3& by_local_mps, const Vector3& by_body_radps) {
  bent_ = -1;
  for (int i = 0; i < count_; ++i) {
    Entry& e = ring_[(first_ + i) % kCapacity];
    const double since_s = to_seconds(e.t - t);
    e.p_local_m += since_s * by_local_mps;
    if (!by_body_radps.isZero(0.0)) e.q = (e.q * rotation_by(since_s * by_body_radps)).normalized();
  }
}

Eigen::Matrix<double, 6, 1> MotionHistory::mean_motion(TimeNs from, TimeNs to) const {
  const double duration_s = to_seconds(to - from);
  const Pose T_from = at(from), T_to = at(to);
  Eigen::Matrix<double, 6, 1> mean;
  mean << T_to.translation() - T_from.translation(),
      rotation_vector_rad(Eigen::Quaterniond(T_from.linear().transpose() * T_to.linear()));
  return mean / duration_s;
}

Pose MotionHistory::at(TimeNs t) const {
  ENSURE(count_ > 0, t);
  while (cursor_ > 0 && entry(cursor_).t > t) --cursor_;
  while (cursor_ + 2 < count_ && entry(cursor_ + 1).t <= t) ++cursor_;
  const Entry& a = entry(cursor_);
  const Entry& b = entry(std::min(cursor_ + 1, count_ - 1));
  if (t <= a.t || b.t <= a.t) return make_pose(a.p_local_m, a.q);
  if (t >= b.t) return make_pose(b.p_local_m, b.q);
  const double f = static_cast<double>(t - a.t) / static_cast<double>(b.t - a.t);
  const Pose straight = make_pose(a.p_local_m + f * (b.p_local_m - a.p_local_m), between(a.q, b.q, f));
  if (b.t - a.t <= kStraight) return straight;
  if (bent_ != cursor_) bend_ = acceleration(cursor_);
  bent_ = cursor_;
  const Vector6 beside = -0.5 * to_seconds(t - a.t) * to_seconds(b.t - t) * bend_;
  return make_pose(straight.translation() + beside.head<3>(),
                   Eigen::Quaterniond(straight.linear()) * rotation_by(beside.tail<3>()));
}

/// Mean velocity (local frame) and body rate between entries i and i + 1.
MotionHistory::Vector6 MotionHistory::mean_rates(int i) const {
  const Entry &a = entry(i), &b = entry(i + 1);
  Vector6 change;
  change << b.p_local_m - a.p_local_m, rotation_vector_rad(a.q.conjugate() * b.q);
  return change / to_seconds(b.t - a.t);
}

/// Accelerations between entries i and i + 1, from the intervals before and after.
MotionHistory::Vector6 MotionHistory::acceleration(int i) const {
  const int from = std::max(i - 1, 0), to = std::min(i + 1, count_ - 2);
  const double between_s = 0.5 * to_seconds(entry(to + 1).t + entry(to).t - entry(from + 1).t - entry(from).t);
  return from < to ? Vector6((mean_rates(to) - mean_rates(from)) / between_s) : Vector6::Zero();
}

void VoxelThinner::thin(std::span<const Eigen::Vector3f> points_m, float edge_m, std::vector<std::uint32_t>& kept) {
  const std::size_t wanted = std::bit_ceil(2 * points_m.size() + 2);
  if (table_.size() < wanted) {
    table_.assign(wanted, {});
    round_ = 0;
  }
  if (++round_ == 0) {
    std::fill(table_.begin(), table_.end(), Slot{});
    round_ = 1;
  }
  const float per_m = 1.0F / edge_m;
  const std::size_t mask = table_.size() - 1;
  for (std::uint32_t i = 0; i < points_m.size(); ++i) {
    const auto index = [per_m](float x) { return static_cast<std::int64_t>(std::floor(x * per_m)); };
    const Eigen::Vector3f& p = points_m[i];
    const std::uint64_t key = cell_key(index(p.x()), index(p.y()), index(p.z()));
    std::size_t slot = first_slot(key, table_.size());
    while (table_[slot].round == round_ && table_[slot].key != key) slot = (slot + 1) & mask;
    if (table_[slot].round == round_) continue;
    table_[slot] = {key, round_};
    kept.push_back(i);
  }
}

void VoxelThinner::thin_into(std::span<const Eigen::Vector3f> points_m, float edge_m,
                             std::vector<Eigen::Vector3f>& kept_m) {
  kept_.clear();
  kept_.reserve(points_m.size());
  thin(points_m, edge_m, kept_);
  kept_m.resize(kept_.size());
  for (std::size_t i = 0; i < kept_.size(); ++i) kept_m[i] = points_m[kept_[i]];
}

void undistort(const Scan& scan, const MotionHistory& motion, TimeNs t, double own_radius_m, double range_max_m,
               std::vector<Eigen::Vector3f>& points_body_m, TimeNs time_offset) {
  const BeamTable& beams = *scan.beams;
  const std::size_t size = beams.size();
  ENSURE(scan.range_m.size() == size && beams.directions_lidar.size() == size && beams.origins_lidar.size() == size &&
             beams.column_offset_s.size() == static_cast<std::size_t>(beams.cols) &&
             (beams.row_offset_s.empty() || beams.row_offset_s.size() == static_cast<std::size_t>(beams.rows)) &&
             (beams.masked.empty() || beams.masked.size() == size),
         scan.sensor, size, scan.range_m.size(), beams.directions_lidar.size(), beams.column_offset_s.size());
  points_body_m.clear();
  points_body_m.reserve(size);
  const Pose T_now_local = motion.at(t).inverse();
  const float own_sq = static_cast<float>(own_radius_m * own_radius_m);
  const float range_max = static_cast<float>(range_max_m);
  const auto carried = [&](int i) {
    return Eigen::Isometry3f(
        (T_now_local * motion.at(scan.time_of(i) + time_offset) * scan.T_body_lidar).cast<float>());
  };
  const auto add = [&](int i, const Eigen::Isometry3f& T_now_lidar) {
    const Eigen::Vector3f p = T_now_lidar * scan.point_lidar(i);
    if (p.squaredNorm() >= own_sq && p.allFinite()) points_body_m.push_back(p);
  };
  const auto counts = [&](int i) {
    return scan.hit(i) && scan.range_m[i] <= range_max && (beams.masked.empty() || !beams.masked[i]);
  };
  const bool by_column = beams.row_offset_s.empty() || scan.duration == 0;
  for (int column = 0; column < beams.cols; ++column) {
    Eigen::Isometry3f T_now_lidar = Eigen::Isometry3f::Identity();
    if (by_column) T_now_lidar = carried(column);
    for (int row = 0; row < beams.rows; ++row) {
      const int i = row * beams.cols + column;
      if (!counts(i)) continue;
      if (!by_column) T_now_lidar = carried(i);
      add(i, T_now_lidar);
    }
  }
}

}  // namespace swiftlet
