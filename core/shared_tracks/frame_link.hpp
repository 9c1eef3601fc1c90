// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "core/shared_tracks/covariance_intersection.hpp"
#include "core/shared_tracks/observer_history.hpp"
#include "swiftlet/core/base/config.hpp"
#include "swiftlet/core/localization/relative_alignment.hpp"
#include "swiftlet/core/shared_tracks/shared_tracks_config.hpp"

namespace swiftlet {

/// Estimates the pose of another observer's local frame in the own one, and its drift.
///
/// Both frames have z up, so three coordinates and the heading are unknown, and so is the association of tracks. Paths
/// are compared: tracks and own path of one observer with those of the other. A level alignment that maps one path onto
/// another is a hypothesis that both are of one body. Straight paths are ambiguous, because any two of equal speed
/// match, and so are uncertain ones; so the curvature of a path counts in its standard deviations. A hypothesis is
/// accepted when its alignment maps further paths onto each other, because coincident motion of two bodies is unlikely.
/// A single pair is accepted when its path curves sufficiently for a long time. No hypothesis is accepted while another
/// alignment is supported as well. The accepted one is fitted to all its pairs by `RelativeAlignment`.
///
/// From then on a Kalman filter tracks T_local_other. Position and heading follow random walks with the odometry drift
/// of both observers, each about its own position. Every unambiguous pair of paths is a measurement; paths so close
/// together that they might be exchanged are not. The comparison continues meanwhile. When it contradicts the filter
/// repeatedly, the filter is reset.
class FrameLink {
 public:
  FrameLink(const FrameLinkConfig& config, const OdometryDriftConfig& drift);

  /// Compares the histories up to the newest time covered by both. Cheap without new data.
  void update(const ObserverHistory& own, const ObserverHistory& other);
  void clear();

  /// Alignment as of the newest time of both; nothing while it is too uncertain.
  const std::optional<FrameAlignment>& alignment() const { return alignment_; }
  /// Time of the newest pair used as a measurement.
  TimeNs measured() const { return measured_; }
  std::uint64_t num_starts() const { return num_starts_; }
  std::uint64_t num_lost() const { return num_lost_; }

 private:
  using Vector4 = Eigen::Matrix<double, 4, 1>;
  using Matrix4 = Eigen::Matrix<double, 4, 4>;
  /// A pair of paths that may be of one body.
  struct Match {
    std::size_t own = 0, other = 0;  // indices of the paths below; 0: the observer itself
    FrameAlignment alignment;
    double duration_s = 0.0;
    double bends = 0.0;                                      // curvature in standard deviations
    std::vector<std::pair<std::size_t, std::size_t>> pairs;  // (own, other) path pairs that fit the alignment
  };

  void list_paths(const ObserverHistory& own, const ObserverHistory& other);
  std::optional<FrameAlignment> found_by_paths(const OtherMotion& anchor) const;
  std::optional<Match> match(std::size_t own, std::size_t other, const OtherMotion& anchor) const;
  void find_support(Match& match, const OtherMotion& anchor) const;
  bool supports(std::size_t own, std::size_t other, const FrameAlignment& alignment, const OtherMotion& anchor) const;
  void append_pairs(std::size_t own, std::size_t other, double yaw_rad, std::vector<AlignmentPair>& pairs) const;
  /// Filter state: pose of the other frame, anchored at a position of the other observer.
  struct State {
    Vector3 anchor_other_m = Vector3::Zero();
    Vector4 x = Vector4::Zero();  // position of the anchor in the own frame, heading
    Matrix4 P = Matrix4::Identity();
    Flown own_flown, other_flown;  // accumulated at that time
  };

  void compare(const ObserverHistory& own, const ObserverHistory& other, TimeNs t);
  State drifted(const State& before, const PathSample& own, const PathSample& other) const;
  void measure(TimeNs t);
  void update_alignment(const ObserverHistory& own, const ObserverHistory& other);

  FrameLinkConfig config_;
  OdometryDriftConfig drift_config_;
  OdometryDrift drift_;
  bool started_ = false;
  State state_;
  std::optional<FrameAlignment> alignment_;
  TimeNs last_ = -1, measured_ = -1;
  int num_disagreements_ = 0;
  std::uint64_t num_starts_ = 0, num_lost_ = 0;
  std::vector<const SampledPath*> own_paths_, other_paths_;  // paths of one update; the observers first
};

/// Transforms a moving point from the other frame to the own one, including the uncertainty of the alignment.
MotionEstimate in_own_frame(const FrameAlignment& alignment, const MotionEstimate& in_other);

}  // namespace swiftlet
