// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "swiftlet/core/base/config.hpp"
#include "swiftlet/core/base/relative_estimate.hpp"
#include "swiftlet/core/localization/relative_alignment.hpp"
#include "swiftlet/core/localization/relative_filter_config.hpp"
#include "swiftlet/core/localization/relative_odometry.hpp"

namespace swiftlet {

/// Measured position of another vehicle.
struct Sighting {
  TimeNs t = 0;
  Vector3 p_local_m = Vector3::Zero();
  Matrix3 covariance = Matrix3::Identity();
};

/// [-] Largest number of bright bodies in a scan, and of chains of their sightings. Racks and signs are bright too;
/// larger values cost time.
inline constexpr std::size_t kMaxBrightBodies = 256;

/// State of another vehicle in the own local frame: a Kalman filter on its position and velocity, and on the alignment
/// of its own local frame, which drifts with its odometry:
///
///   position   integrates a velocity with white acceleration noise
///   sighting   = position + noise
///   odometry   = position, by the alignment, and velocity, by its heading
///   alignment  random walk by the drift of the odometry since its last sample
///
/// Measurements are applied at their own times. A delayed measurement is inserted into a short history, and the later
/// ones are applied again. Without sightings the odometry propagates the state, without odometry the velocity does, and
/// the covariance grows accordingly. The alignment of the window only initializes the filter: it is made of the same
/// sightings and is no independent measurement.
///
/// The odometry may drift more than configured. Then the innovations of its samples exceed the predicted covariance.
/// The factor of its variance, at least 1, is estimated online by steps along the gradient of the log-likelihood,
/// divided by Fisher's information.
class RelativeFilter {
 public:
  RelativeFilter(const RelativeFilterConfig& config, const OdometryDriftConfig& drift);

  bool started() const { return started_; }
  void stop();
  /// Initializes from an alignment anchored where the odometry was at `anchor`. The estimated drift factor is kept.
  void start(const FrameAlignment& alignment, const OtherMotion& anchor);

  /// False when the sample is older than the history.
  bool push(const OtherMotion& odometry);
  /// Squared Mahalanobis distance of the sighting from its prediction.
  double squared_sigmas(const Sighting& sighting) const;
  /// Twice the negative log-likelihood of the sighting, up to a constant.
  double unlikelihood(const Sighting& sighting) const;
  /// False when the sighting is older than the history, or fails the gate of gate_sigma.
  bool push(const Sighting& sighting);

  /// Position, velocity, heading and covariance at any time since the start of the history.
  RelativeEstimate at(TimeNs t) const;
  /// Present alignment, anchored at the newest odometry.
  FrameAlignment alignment() const;
  /// Estimated factor of the drift variance relative to the configured one.
  double drift_variance_factor() const;

 private:
  // [-] Dimension of the state: position and velocity of the vehicle, position and heading of the alignment.
  static constexpr int kStates = 10;
  static constexpr double kLogFactorVariance = 1.0;  // prior, before any flight
  enum Index { kP = 0, kV = 3, kAnchor = 6, kYaw = 9 };
  using Vector = Eigen::Matrix<double, kStates, 1>;
  using Covariance = Eigen::Matrix<double, kStates, kStates>;
  struct State {
    TimeNs t = 0;
    Vector x = Vector::Zero();
    Covariance P = Covariance::Zero();
    OtherMotion odometry;  // newest odometry, the anchor of the alignment
    TimeNs seen = 0;
    double log_factor = 0.0, log_factor_variance = kLogFactorVariance;  // log of the drift factor
  };
  /// A measurement and the state after it.
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
    Matrix3 covariance;  // innovation covariance
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
  State base_;                  // state before the history
  std::vector<Entry> history_;  // in order of time
};

}  // namespace swiftlet
