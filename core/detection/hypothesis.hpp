// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>

#include <Eigen/LU>
#include "core/detection/existence.hpp"
#include "swiftlet/core/base/frames.hpp"
#include "swiftlet/core/base/time.hpp"
#include "swiftlet/core/detection/track_before_detect_config.hpp"

namespace swiftlet {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// Constants of track before detect.
struct TrackBeforeDetectLimits {
  /// [-] Existence probability from which a hypothesis counts as a target: targets take returns first, keep them
  /// from becoming background, and are remembered when lost. Smaller values let clutter do so.
  static constexpr double kTarget = 0.5;
  /// [-] Existence probability below which a hypothesis is dropped. Larger values lose targets that begin weakly.
  static constexpr double kMinExistence = 1e-7;
  /// [-] Gate of the squared Mahalanobis distance: 0.999 in three dimensions. Larger values associate more clutter.
  static constexpr double kGate = 16.0;
  /// [m] Largest range of a target, and largest length up to which a beam clears the air before its return. Returns
  /// from farther away become background at once. Larger values cost time.
  static constexpr double kMaxRange_m = 60.0;
  /// [m] Largest distance of an association, which limits the wide gate of hypotheses without known velocity.
  static constexpr double kGateMost_m = 8.0;
  /// [sigma] Error of the attitude within which nearby background may have caused a return. Larger values begin fewer
  /// hypotheses near background far away.
  static constexpr double kReach_sigma = 2.5;
  /// [voxels] Largest search radius around a return; exceeds every map.
  static constexpr double kMaxVoxels = 1000.0;
  /// [-] Weight of past returns in a target's return rate, per sweep. Larger values follow its turns more slowly.
  static constexpr double kRateMemory = 0.95;
  /// [beams] Weight of the expected share of returns in a target's return rate. Larger values adapt the rate later.
  static constexpr double kPriorShots = 20.0;
  /// [-] Lower bound of the probability that a target returns any beam, for an object that did. Smaller values make a
  /// hypothesis on which hardly any beams are expected less likely.
  static constexpr double kMinDetection = 0.02;
  /// [beams] Lower bound of the beams through a voxel in the clutter density; keeps the density above 0 where hardly
  /// any beams are expected.
  static constexpr double kMinBeams = 0.01;
  /// [cluster_distance_m] Distance below which a hypothesis is a duplicate of a more likely one, for targets and for
  /// others. Larger values merge targets that fly close together.
  static constexpr double kMergeTarget = 0.25, kMergeOther = 0.75;
  /// [-] Share of the variance of a single return that is common to all returns of a sweep, because they come from the
  /// visible side. Larger values trust the mean of many returns less.
  static constexpr double kSameSide = 0.1;
  /// [-] Least existence probability of a former target when a new hypothesis is associated with it: it may be without
  /// returns because it is hidden. Larger values continue former identities more readily.
  static constexpr double kSilentTarget = 0.1;
  /// [-] Factor of sigma_lost_m for hypotheses that are no targets yet. Larger values keep them longer without returns.
  static constexpr double kUnlikelyLost = 2.0;
  /// [-] Least factor of the size of a body from sweep to sweep. Smaller values shrink a body that is seen only in
  /// part.
  static constexpr double kSizeMemory = 0.998;
  /// [m] Size of the reference body in the comparison of bodies of different sizes. Values up to four times the scatter
  /// of returns are equivalent; larger ones draw returns from targets of usual size to large bodies.
  static constexpr double kSmallest_m = 0.04;
  /// [body_m] Largest size of a body merged from parts. Larger values let a body absorb its neighbors.
  static constexpr double kMaxSize = 1.5;
  /// [-] Fewest returns of a body in a sweep for a test of a split. Smaller values split bodies by a few stray returns.
  static constexpr std::size_t kMinReturnsToSplit = 6;
  /// [-] Lower bound of the prior of a small object; keeps its log odds finite.
  static constexpr double kNeverSmall = 1e-12;
  /// [-] Capacities: returns of a sweep outside of background, and returns that wait to become background. Further
  /// returns become background at once.
  static constexpr std::size_t kMaxCandidates = 4096, kMaxPending = 16384;
};

/// Hypothesis of a flying object: a Bernoulli component with a Gaussian state. Local frame.
struct Hypothesis {
  std::uint32_t id = 0;
  std::uint32_t identity = 0;         ///< reported id: the own id, or that of a reappeared target
  std::uint32_t former_identity = 0;  ///< hidden target that this hypothesis probably continues; 0: none
  TimeNs t = 0, begun = 0, seen = 0;  ///< times of the state, of the first and of the newest return
  double existence = 0.0;             ///< probability that the object exists
  Vector6 mean = Vector6::Zero();     ///< position, velocity
  Matrix6 covariance = Matrix6::Identity();
  ReturnRate rate;          ///< share of beams on the object that return
  Observability sight;      ///< probability that the object is hidden
  Smallness small;          ///< evidence that the object is too small for a UAV
  int num_sweeps = 0;       ///< number of sweeps with returns of the target
  int num_returns = 0;      ///< returns in the newest sweep
  bool was_target = false;  ///< existence once reached kTarget, so that the identity outlives the hypothesis
  double size_m = 0.0;      ///< diameter of a body merged from parts; 0: not known to be large
  // Newest measurement: edges of the box around its returns, center of the target [m] with covariance [m^2], and
  // reflectivity of the brightest return [-].
  Vector3 extent_m = Vector3::Zero();
  Vector3 measured_local_m = Vector3::Zero();
  Matrix3 measured_covariance = Matrix3::Identity();
  double reflectivity = 0.0;

  /// Predicts state and existence.
  void predict(TimeNs to, const ExpectedTarget& target);
  /// Moves the state, not its time: constant velocity with white acceleration of spectral density q [m^2/s^3].
  void move(double dt_s, double q);
  /// Probability that the object exists and is not too small for a UAV.
  double confidence() const { return existence * (1.0 - small.probability()); }
  Vector3 p_local_m() const { return mean.head<3>(); }
  Vector3 v_local_mps() const { return mean.tail<3>(); }
  Matrix3 position_covariance() const { return covariance.topLeftCorner<3, 3>(); }
};

inline void Hypothesis::move(double dt_s, double q) {
  mean.head<3>() += dt_s * mean.tail<3>();
  Matrix6 F = Matrix6::Identity();
  F.topRightCorner<3, 3>() = dt_s * Matrix3::Identity();
  covariance = F * covariance * F.transpose();
  covariance.topLeftCorner<3, 3>() += q * dt_s * dt_s * dt_s / 3.0 * Matrix3::Identity();
  covariance.topRightCorner<3, 3>() += q * dt_s * dt_s / 2.0 * Matrix3::Identity();
  covariance.bottomLeftCorner<3, 3>() += q * dt_s * dt_s / 2.0 * Matrix3::Identity();
  covariance.bottomRightCorner<3, 3>() += q * dt_s * Matrix3::Identity();
}

inline void Hypothesis::predict(TimeNs to, const ExpectedTarget& target) {
  const double dt_s = to_seconds(to - t);
  move(dt_s, target.acceleration_density);
  t = to;
  existence *= elementary::exp(-dt_s / target.lifetime_s);
}

/// Maps a state to the position dt_s later.
inline Eigen::Matrix<double, 3, 6> position_at(double dt_s) {
  Eigen::Matrix<double, 3, 6> H;
  H << Matrix3::Identity(), dt_s * Matrix3::Identity();
  return H;
}

inline double normal_density(double distance_sq, const Matrix3& S) {
  const double two_pi = 2.0 * std::numbers::pi;
  return elementary::exp(-0.5 * distance_sq) / std::sqrt(two_pi * two_pi * two_pi * S.determinant());
}

}  // namespace swiftlet
