// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "swiftlet/core/config.hpp"
#include "swiftlet/core/localization/relative_alignment.hpp"
#include "swiftlet/core/sharing/covariance_intersection.hpp"
#include "swiftlet/core/sharing/observer_history.hpp"

namespace swiftlet {

struct FrameLinkConfig {
  double window_s = 15.0;
  double interval_s = 0.5;
  double gap_max_s = 0.8;
  int min_samples = 20;
  double min_spread_m = 2.0;
  double min_bend_m = 1.0;
  double bend_sigmas = 4.0;
  double support_s = 3.0;
  double support_sigma_m = 1.0;
  double alone_s = 10.0;
  double alone_sigmas = 12.0;
  double residual_sigma_max = 1.5;
  double gate_sigma = 4.0;
  double margin = 9.2;
  double sigma_own_m = 0.02;
  double sigma_common_m = 0.05;
  double position_sigma_max_m = 1.5;
  double heading_sigma_max_deg = 5.0;

  void visit(ConfigVisitor& v);
};

/// Where another observer's local frame lies in one's own, and how it drifts.
///
/// Both have z up, so that three numbers of the position and the heading are unknown. Nobody knows at first who sees
/// whom. So paths are compared: what one saw flying and where it flew itself, with the same of the other. Two paths
/// that one level alignment lays onto each other may be of one body. Straight ones tell nothing, because any two of the
/// same speed fit. So do those that are hardly known, so the bends of a path count in its own standard deviations. What
/// two paths say is believed when the same alignment lays other paths onto each other as well. In a wide field two
/// bodies hardly fly the same way by chance. One pair alone is believed when it bends much for a long time. Nothing is
/// believed as long as another alignment is supported as well. The one that is believed is fitted to all its pairs by
/// `RelativeAlignment`.
///
/// From there a Kalman filter follows T_local_other. Position and heading walk by what both observers fly, each by its
/// own drift about its own place. Every pair of paths that surely is of one body measures them. Paths that lie so near
/// to each other that they might be exchanged measure nothing. Meanwhile the comparison goes on. When it says something
/// else again and again, the filter starts anew.
class FrameLink {
 public:
  FrameLink(const FrameLinkConfig& config, const OdometryDriftConfig& drift);

  /// Compares what is known of the newest instant that both have told of. Cheap when there is nothing new.
  void update(const ObserverHistory& own, const ObserverHistory& other);
  void clear();

  /// As of the newest of both; nothing as long as it is not sure enough.
  const std::optional<FrameAlignment>& alignment() const { return told_; }
  /// Instant of the newest pair that measured it.
  TimeNs measured() const { return measured_; }
  std::uint64_t num_starts() const { return num_starts_; }
  std::uint64_t num_lost() const { return num_lost_; }

 private:
  using Vector4 = Eigen::Matrix<double, 4, 1>;
  using Matrix4 = Eigen::Matrix<double, 4, 4>;
  /// A path of each side that may be the same body's.
  struct Match {
    std::size_t own = 0, other = 0;  // of the paths below; 0: the observer itself
    FrameAlignment alignment;
    double duration_s = 0.0;
    double bends = 0.0;                                      // in standard deviations
    std::vector<std::pair<std::size_t, std::size_t>> pairs;  // of paths that it lays onto each other, its own first
  };

  void list_paths(const ObserverHistory& own, const ObserverHistory& other);
  std::optional<FrameAlignment> found_by_paths(const OtherMotion& anchor) const;
  std::optional<Match> match(std::size_t own, std::size_t other, const OtherMotion& anchor) const;
  void find_support(Match& match, const OtherMotion& anchor) const;
  bool supports(std::size_t own, std::size_t other, const FrameAlignment& alignment, const OtherMotion& anchor) const;
  void append_pairs(std::size_t own, std::size_t other, double yaw_rad, std::vector<AlignmentPair>& pairs) const;
  /// Where the other frame lies, anchored in where the other observer was.
  struct State {
    Vector3 anchor_other_m = Vector3::Zero();
    Vector4 x = Vector4::Zero();  // place of the anchor in the own frame, heading
    Matrix4 P = Matrix4::Identity();
    Flown own_flown, other_flown;  // by then
  };

  void compare(const ObserverHistory& own, const ObserverHistory& other, TimeNs t);
  State drifted(const State& before, const PathSample& own, const PathSample& other) const;
  void measure(TimeNs t);
  void tell(const ObserverHistory& own, const ObserverHistory& other);

  FrameLinkConfig config_;
  OdometryDriftConfig drift_config_;
  OdometryDrift drift_;
  bool started_ = false;
  State state_;
  std::optional<FrameAlignment> told_;
  TimeNs last_ = -1, measured_ = -1;
  int num_disagreements_ = 0;
  std::uint64_t num_starts_ = 0, num_lost_ = 0;
  std::vector<const SampledPath*> own_paths_, other_paths_;  // of one update; the observers first
};

/// A moving point of the other frame in the own one, with the uncertainty of the alignment.
MotionEstimate in_own_frame(const FrameAlignment& alignment, const MotionEstimate& in_other);

}  // namespace swiftlet
