// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "swiftlet/core/math/latency.hpp"
#include "swiftlet/core/slam/local_slam.hpp"

namespace swiftlet {

/// Local SLAM whose scans take a while on board. Each is matched as of the instant at which it arrived, by what was
/// known then. The IMU's samples since that instant are kept, and carry the corrected state from there to now.
///
/// At most kMostSamples of them are kept. If more come while a scan waits, it is matched as of a later instant.
class SlamToNow {
 public:
  static constexpr std::size_t kMostSamples = 2048;

  /// @param matcher  as LocalSlam takes it
  SlamToNow(const LocalSlamConfig& config, double latency_s, const Pose& T_local_body_start, double own_radius_m,
            std::unique_ptr<ScanMatcher> matcher = nullptr);

  void add(const ImuSample& sample);
  /// A scan that arrived at t, with all samples of the IMU until then.
  void add(TimeNs t, std::shared_ptr<const Scan> scan, std::span<const SeenVehicle> others = {});

  struct Matched {
    TimeNs arrived = 0;
    ScanOutcome outcome;
  };
  /// The oldest scan whose latency is over by t, if there is one.
  std::optional<Matched> match_next(TimeNs t);

  /// As of the scan that was matched last, or later.
  const LocalSlam& at_scan() const { return slam_; }
  /// At the last sample of the IMU.
  const InertialFilter& now() const { return num_ahead() > 0 ? now_ : slam_.filter(); }
  /// Of the pose now, in the local frame.
  Matrix6 pose_covariance() const { return slam_.pose_covariance(now()); }

 private:
  struct Arrival {
    TimeNs t = 0;
    std::shared_ptr<const Scan> scan;
    std::uint64_t samples_before = 0;
    std::vector<SeenVehicle> others;
  };
  bool is_due(TimeNs t) const { return !waiting_.empty() && latency_.is_over(waiting_.front().t, t); }
  std::uint64_t num_ahead() const { return num_samples_ - num_told_; }
  const ImuSample& sample(std::uint64_t i) const { return ring_[i % kMostSamples]; }
  void tell_until(std::uint64_t num_samples);
  void catch_up();

  Latency latency_;
  LocalSlam slam_;
  InertialFilter now_;
  std::vector<ImuSample> ring_;
  std::uint64_t num_samples_ = 0, num_told_ = 0;  // of all; the ring has those that local SLAM was not told yet
  std::vector<Arrival> waiting_;                  // few
};

}  // namespace swiftlet
