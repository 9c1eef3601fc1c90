// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/slam/matching/local_slam.hpp"
#include "swiftlet/core/math/latency.hpp"

namespace swiftlet {

/// Local SLAM with processing latency. Each scan is matched as of its arrival or, if its end on the IMU's clock is
/// later, as of then. The IMU samples since then are kept, and propagate the corrected state to the present.
///
/// At most kMaxSamples samples are kept. If more arrive while a scan waits, the scan is matched as of a later time.
class SlamToNow {
 public:
  /// [-] Stored IMU samples: 5 s at 400 Hz. Larger values match scans of a longer latency as of their own time.
  static constexpr std::size_t kMaxSamples = 2048;

  /// @param matcher  as in LocalSlam
  SlamToNow(const LocalSlamConfig& config, double latency_s, const Pose& T_local_body_start, double own_radius_m,
            std::unique_ptr<ScanMatcher> matcher = nullptr);

  /// States the time of the start pose.
  void begin_at(TimeNs t) { slam_.begin_at(t); }
  void add(const ImuSample& sample);
  /// Adds a scan that arrived at t, after all IMU samples until then.
  void add(TimeNs t, std::shared_ptr<const Scan> scan, std::span<const SeenVehicle> others = {});

  struct Matched {
    TimeNs arrived = 0;
    ScanOutcome outcome;
  };
  /// Result for the oldest scan whose latency is over by t, if any.
  std::optional<Matched> match_next(TimeNs t);

  /// State as of the last matched scan, or later.
  const LocalSlam& at_scan() const { return slam_; }
  /// State at the last IMU sample.
  const InertialFilter& now() const { return num_ahead() > 0 ? now_ : slam_.filter(); }
  /// Covariance of the pose `ahead_s` after that state, in the local frame.
  Matrix6 pose_covariance(double ahead_s) const { return slam_.pose_covariance(now(), ahead_s); }

 private:
  struct Arrival {
    TimeNs t = 0;
    std::shared_ptr<const Scan> scan;
    std::uint64_t samples_before = 0;
    std::vector<SeenVehicle> others;
  };
  bool is_due(TimeNs t) const { return !waiting_.empty() && latency_.is_over(waiting_.front().t, t); }
  std::uint64_t num_ahead() const { return num_samples_ - num_added_; }
  const ImuSample& sample(std::uint64_t i) const { return ring_[i % kMaxSamples]; }
  void add_until(std::uint64_t num_samples);
  void catch_up();

  Latency latency_;
  LocalSlam slam_;
  InertialFilter now_;
  std::vector<ImuSample> ring_;
  std::uint64_t num_samples_ = 0, num_added_ = 0;  // all samples; the ring has those not yet passed to local SLAM
  std::vector<Arrival> waiting_;                   // few
};

}  // namespace swiftlet
