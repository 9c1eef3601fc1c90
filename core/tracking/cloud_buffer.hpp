// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "swiftlet/core/base/ensure.hpp"
#include "swiftlet/core/localization/local_cloud.hpp"

namespace swiftlet {

/// A buffered cloud of the tracker: points, measurement times, and bounding boxes of runs of consecutive points, which
/// accelerate radius searches.
class BufferedCloud {
 public:
  void assign(const LocalCloud& cloud);

  TimeNs stamp() const { return stamp_; }
  TimeNs middle() const { return stamp_ + duration_ / 2; }
  /// Pose of the sensor at mid-sweep.
  const Pose& T_local_lidar() const { return T_local_lidar_; }
  const Eigen::Vector3f& point(std::uint32_t i) const { return points_[i]; }
  TimeNs time_of(std::uint32_t i) const {
    return duration_ == 0 ? stamp_ : stamp_ + from_seconds(beams_->offset_s(static_cast<int>(beam_[i])));
  }
  float reflectivity(std::uint32_t i) const { return reflectivity_[i]; }  ///< 0: unknown
  /// Appends the indices of the points within the radius, in increasing order.
  void select(const Vector3& center_local_m, double radius_m, std::vector<std::uint32_t>& indices) const;

 private:
  struct Box {
    Eigen::Vector3f min_local_m, max_local_m;
  };
  // [-] Points per box. Smaller boxes skip more points of a search, and more boxes are tested.
  static constexpr std::size_t kRun = 64;

  TimeNs stamp_ = 0;
  TimeNs duration_ = 0;
  Pose T_local_lidar_ = Pose::Identity();
  std::shared_ptr<const BeamTable> beams_;
  std::vector<Eigen::Vector3f> points_;
  std::vector<std::uint32_t> beam_;
  std::vector<float> reflectivity_;
  std::vector<Box> boxes_;
};

/// The last N_buf clouds, oldest first; reuses memory.
class CloudBuffer {
 public:
  explicit CloudBuffer(int capacity) : clouds_(capacity) {}
  /// Slot for a new cloud; replaces the oldest one when the buffer is full.
  BufferedCloud& push() {
    if (count_ < clouds_.size())
      ++count_;
    else
      first_ = (first_ + 1) % clouds_.size();
    return clouds_[(first_ + count_ - 1) % clouds_.size()];
  }
  std::size_t size() const { return count_; }
  bool is_full() const { return count_ == clouds_.size(); }
  const BufferedCloud& operator[](std::size_t i) const { return clouds_[(first_ + i) % clouds_.size()]; }
  const BufferedCloud& newest() const {
    ENSURE(count_ > 0);
    return (*this)[count_ - 1];
  }

 private:
  std::vector<BufferedCloud> clouds_;
  std::size_t first_ = 0, count_ = 0;
};

}  // namespace swiftlet
