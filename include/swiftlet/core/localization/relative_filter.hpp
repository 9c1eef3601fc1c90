// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "swiftlet/core/config.hpp"
#include "swiftlet/core/localization/relative_alignment.hpp"
#include "swiftlet/core/localization/relative_odometry.hpp"
#include "swiftlet/core/relative_estimate.hpp"

namespace swiftlet {

struct RelativeFilterConfig {
  double acceleration_mps2_psqrthz = 0.5;
  double odometry_sigma_m = 0.015;
  double odometry_velocity_sigma_mps = 0.06;
  double odometry_yaw_sigma_deg = 0.5;
  double yaw_rate_sigma_degps = 10.0;
  double bias_sigma_m = 0.02;
  double gate_sigma = 4.0;
  double drift_factor_max = 10.0;
  double history_s = 3.0;

  void visit(ConfigVisitor& v);
};

/// A place of the other vehicle as a sensor saw it.
struct Sighting {
  TimeNs t = 0;
  Vector3 p_local_m = Vector3::Zero();
  Matrix3 covariance = Matrix3::Identity();
};

/// Where another vehicle is in one's own local frame. A Kalman filter on its position and velocity there, and on the
/// alignment of its own local frame, which drifts as its odometry does:
///
///   position   moves at a velocity that white acceleration changes
///   sighting   = position + noise
///   odometry   = position, by the alignment, and velocity, by its heading
///   alignment  walks by what the odometry flew since its last sample
///
/// Everything is taken in at its own time. What comes late is put in its place in a short history, and what came after
/// is done again. Without sightings the odometry carries it on, without odometry the velocity. The covariance tells how
/// far. The window's alignment starts it and is no measurement of it, because it is made of the same sightings.
///
/// An odometry may drift more than it is said to. Then its samples lie farther from where sightings expect them than
/// the covariance allows. By what factor its variance is greater, from 1 on, is estimated on the way. A step goes along
/// the gradient of the logarithm of the likelihood, over Fisher's information.
class RelativeFilter {
 public:
  RelativeFilter(const RelativeFilterConfig& config, const OdometryDriftConfig& drift);

  bool started() const { return started_; }
  void stop();
  /// From an alignment whose anchor is where the odometry was at `anchor`. What was learned of the drift remains.
  void start(const FrameAlignment& alignment, const OtherMotion& anchor);

  /// False when it is older than the history.
  bool push(const OtherMotion& odometry);
  /// Squared distance in standard deviations from where it is expected.
  double squared_sigmas(const Sighting& sighting) const;
  /// Twice its negative logarithm of the likelihood, but for a constant.
  double unlikelihood(const Sighting& sighting) const;
  /// False when it is older than the history, or no sighting of this vehicle by gate_sigma.
  bool push(const Sighting& sighting);

  /// Position, velocity, heading and covariance at any time from the start of the history on.
  RelativeEstimate at(TimeNs t) const;
  /// The alignment as it is now, about the newest odometry.
  FrameAlignment alignment() const;
  /// How many times greater the variance of the drift is than it is said to be.
  double drift_variance_factor() const;

 private:
  static constexpr int kStates = 10;
  static constexpr double kLogFactorVariance = 1.0;  // before anything was flown
  enum Index { kP = 0, kV = 3, kAnchor = 6, kYaw = 9 };
  using Vector = Eigen::Matrix<double, kStates, 1>;
  using Covariance = Eigen::Matrix<double, kStates, kStates>;
  struct State {
    TimeNs t = 0;
    Vector x = Vector::Zero();
    Covariance P = Covariance::Zero();
    OtherMotion odometry;  // the newest, where the alignment is anchored
    TimeNs seen = 0;
    double log_factor = 0.0, log_factor_variance = kLogFactorVariance;  // on the variance of the drift
  };
  /// A measurement, and the state after it.
  struct Entry {
    TimeNs t = 0;
    bool is_odometry = false;
    OtherMotion odometry;
    Sighting sighting;
    State after;
  };

  bool insert(Entry entry);
  struct Expected {
    Vector3 p_local_m;
    Matrix3 covariance;  // of how far the sighting may be off
  };
  Expected expected(const Sighting& sighting) const;
  const State& before(TimeNs t) const;
  const State& newest() const { return history_.empty() ? base_ : history_.back().after; }
  void predict(State& state, TimeNs t) const;
  void correct(State& state, const OtherMotion& odometry) const;
  void learn_drift(State& state, const Vector3& innovation_local_m, const Matrix3& expected,
                   const Matrix3& of_drift) const;
  void correct(State& state, const Sighting& sighting) const;
  template <int M>
  void correct(State& state, const Eigen::Matrix<double, M, 1>& innovation, const Eigen::Matrix<double, M, kStates>& H,
               const Eigen::Matrix<double, M, M>& R) const;

  RelativeFilterConfig config_;
  OdometryDrift drift_;
  bool started_ = false;
  State base_;                  // before the history
  std::vector<Entry> history_;  // by time
};

}  // namespace swiftlet
