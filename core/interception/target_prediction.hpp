// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/interception/chase_mpc.hpp"
#include "swiftlet/core/base/track.hpp"
#include "swiftlet/core/interception/intercept_config.hpp"

namespace swiftlet {

/// Prediction of a target: each motion model of its track is extrapolated and the results are mixed by the model
/// probabilities.
///
/// - Constant velocity: extrapolated without limit.
/// - Constant acceleration: decays with a time constant, because accelerations of vehicles are short.
/// - Coordinated turn: continues at its turn rate.
///
/// A track with one model is extrapolated like constant acceleration.
class TargetPrediction {
 public:
  TargetPrediction() = default;
  /// `modes` may be null. `now` is the origin of `ahead_s`.
  TargetPrediction(const TargetPredictionConfig& config, const Track& track, const TrackModes* modes, TimeNs now);

  /// Position and velocity; no acceleration.
  PointState at(double ahead_s) const;
  /// Standard deviation of the position along the worst axis, for constant velocity [m].
  double sigma_m(double ahead_s) const;

 private:
  TargetPredictionConfig config_;
  TrackModes modes_;
  Eigen::Matrix<double, 9, 9> covariance_ = Eigen::Matrix<double, 9, 9>::Identity();
  double age_s_ = 0.0;  // age of the track
};

}  // namespace swiftlet
