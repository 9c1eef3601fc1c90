// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "swiftlet/core/base/config.hpp"
#include "swiftlet/core/localization/relative_odometry.hpp"

/// Pose of another vehicle's local frame ("other") in the own one ("local"), estimated from sightings of the other and
/// its reported odometry at the same times. Both frames have z up, so there are four unknowns: three of the position,
/// and the heading [Pritzl, Fusion of Visual-Inertial Odometry with LiDAR Relative Localization, 2023].
namespace swiftlet {

/// Position of the other vehicle in both frames at one time.
struct AlignmentPair {
  TimeNs t = 0;
  Vector3 p_local_m = Vector3::Zero();  ///< measured position
  Matrix3 covariance = Matrix3::Identity();
  Vector3 p_other_m = Vector3::Zero();  ///< reported position, for an assumed clock offset `clock_s`
  Vector3 v_other_mps = Vector3::Zero();
  double clock_s = 0.0;
  Flown flown;  ///< distance, turning and time flown by the other vehicle until then
};

/// Transform from the other frame into the own one. The heading rotates about an anchor, a position of the other
/// vehicle near the data. About its distant origin, errors of heading and position would be almost fully correlated.
struct FrameAlignment {
  using Covariance = Eigen::Matrix<double, 4, 4>;

  Vector3 anchor_other_m = Vector3::Zero();
  Vector3 anchor_local_m = Vector3::Zero();
  double yaw_rad = 0.0;
  Covariance covariance = Covariance::Identity();  ///< anchor_local_m [m], yaw [rad]
  double clock_s = 0.0;                            ///< lag of the other clock behind the own one
  double clock_sigma_s = 0.0;

  Pose T_local_other() const;
  Vector3 point(const Vector3& p_other_m) const;
};

/// [-] Squared Mahalanobis distance from which two alignments contradict each other: a chance of 1 in 200 000, with
/// four degrees of freedom. Larger values keep a wrong alignment longer.
inline constexpr double kDisagreement_sigma_sq = 30.0;

/// Weighted least-squares alignment in closed form: S. Umeyama, "Least-squares estimation of transformation parameters
/// between two point patterns", IEEE PAMI 13(4), 1991, restricted to rotations about the vertical. Nothing when the
/// horizontal positions in either frame coincide. Anchor: the weighted mean.
std::optional<FrameAlignment> align_in_closed_form(std::span<const Vector3> p_local_m,
                                                   std::span<const Vector3> p_other_m, std::span<const double> weights);

struct RelativeAlignmentConfig {
  int window_size = 60;  ///< [-] pairs of sighting and odometry in the window
  /// [m] distance flown by the other vehicle between pairs; while it rests, the newest pair is replaced
  double window_step_m = 0.1;
  double loss_scale = 2.0;         ///< [-] residual in standard deviations at which Cauchy's loss departs from a square
  int min_pairs = 8;               ///< [-] fewest inliers of an alignment
  double min_inlier_share = 0.65;  ///< [-] least share of inliers in the window
  /// [-] largest RMS residual of the inliers per axis, in standard deviations; above it another vehicle was seen
  double residual_sigma_max = 1.25;
  /// [m] horizontal RMS distance of the window's positions from their mean below which the heading is unobservable
  double min_spread_m = 0.25;
  double heading_sigma_max_deg = 5.0;  ///< [deg] standard deviation of the heading above which it is not reported
};

/// Prior of the other vehicle's clock offset, before any motion constrains it.
struct ClockPrior {
  double clock_s = 0.0;
  double sigma_s = 0.0;  ///< 0: known exactly
};

/// Reason why there is no alignment yet.
enum class AlignmentFault { kNone, kFewPairs, kFewInliers, kNoSpread, kUncertainHeading };
constexpr const char* reason_of(AlignmentFault fault) {
  constexpr const char* kReasons[] = {"", "too few sightings", "sightings that do not fit the reported odometry",
                                      "the vehicle has not moved enough", "the heading is too uncertain"};
  return kReasons[static_cast<std::size_t>(fault)];
}

/// Robust non-linear least squares over a sliding window of pairs.
///
/// Gauss-Newton with Levenberg's damping. The 5 x 5 normal equations (anchor, heading, clock) are solved here, because
/// results of a library for larger problems depend on its build. The initial guess is the last result, or the best of
/// the alignments by two pairs each, in a fixed order, which is robust to false sightings.
class RelativeAlignment {
 public:
  RelativeAlignment(const RelativeAlignmentConfig& config, const OdometryDriftConfig& drift);

  /// Adds a pair, in order of time. The window advances with motion: while the other vehicle rests, its newest pair
  /// replaces the previous one.
  void push(const AlignmentPair& pair);
  void clear();
  /// Scales the variance of the odometry drift by this factor, for an odometry worse than configured.
  void set_drift_variance_factor(double factor) { drift_factor_ = factor; }
  int num_pairs() const { return static_cast<int>(pairs_.size()); }
  std::span<const AlignmentPair> pairs() const { return pairs_; }  ///< pairs of the window, oldest first

  /// Alignment as of now, with the other vehicle at `anchor`; nothing, and a fault, when it is not observable.
  const std::optional<FrameAlignment>& fit(const OtherMotion& anchor, const ClockPrior& clock);
  AlignmentFault fault() const { return fault_; }

 private:
  using Vector5 = Eigen::Matrix<double, 5, 1>;
  using Matrix5 = Eigen::Matrix<double, 5, 5>;
  using Matrix35 = Eigen::Matrix<double, 3, 5>;
  struct Guess {
    Vector3 anchor_local_m = Vector3::Zero();
    double yaw_rad = 0.0, clock_s = 0.0;
  };

  Vector3 residual(const AlignmentPair& pair, const Guess& guess) const;
  Matrix35 jacobian(const AlignmentPair& pair, const Guess& guess) const;
  double squared_sigmas(std::size_t i, const Guess& guess) const;
  void weigh(const OtherMotion& anchor);
  std::optional<Guess> global_start() const;
  Guess refine(Guess guess, bool robust) const;
  double cost(const Guess& guess, bool robust) const;
  void take_inliers(const Guess& guess);
  double inlier_share() const;
  double spread_m() const;
  double residual_sigma(const Guess& guess) const;
  Matrix5 covariance(const Guess& guess, const OtherMotion& now) const;
  AlignmentFault fault_of(const FrameAlignment& found, const Guess& guess) const;

  RelativeAlignmentConfig config_;
  OdometryDrift drift_;
  double drift_factor_ = 1.0;
  std::vector<AlignmentPair> pairs_;  // oldest first
  std::optional<FrameAlignment> result_;
  AlignmentFault fault_ = AlignmentFault::kFewPairs;
  int num_inliers_ = 0;
  // Scratch of one fit.
  Vector3 anchor_other_m_ = Vector3::Zero();
  ClockPrior clock_;
  std::vector<Matrix3> information_;
  std::vector<char> inlier_;
  mutable std::vector<Vector3> local_, other_;
  mutable std::vector<double> weights_;
};

}  // namespace swiftlet
