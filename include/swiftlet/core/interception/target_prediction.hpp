// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/interception/chase_mpc.hpp"
#include "swiftlet/core/track.hpp"

namespace swiftlet {

struct TargetPredictionConfig {
  double acceleration_time_s = 0.8;
  double speed_max_mps = 15.0;

  void visit(ConfigVisitor& v);
};

/// Where a target will be: each motion model of its track goes on, and the mixture by their probabilities is told.
///
/// - Constant velocity goes on for ever.
/// - Constant acceleration dies away with a time constant, because nobody accelerates for long.
/// - The coordinated turn goes on at its rate.
///
/// A track of one model goes on like constant acceleration.
class TargetPrediction {
 public:
  TargetPrediction() = default;
  /// `modes` may be null. `now` is when `ahead_s` counts from.
  TargetPrediction(const TargetPredictionConfig& config, const Track& track, const TrackModes* modes, TimeNs now);

  /// Position and velocity; no acceleration.
  PointState at(double ahead_s) const;
  /// Standard deviation of the position along the worst axis, if its velocity stays what it is [m].
  double sigma_m(double ahead_s) const;

 private:
  TargetPredictionConfig config_;
  TrackModes modes_;
  Eigen::Matrix<double, 9, 9> covariance_ = Eigen::Matrix<double, 9, 9>::Identity();
  double age_s_ = 0.0;  // of the track
};

}  // namespace swiftlet
