// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "core/shared_tracks/covariance_intersection.hpp"
#include "core/shared_tracks/path_comparison.hpp"
#include "swiftlet/core/base/config.hpp"
#include "swiftlet/core/localization/relative_alignment.hpp"
#include "swiftlet/core/shared_tracks/shared_tracks_config.hpp"

namespace swiftlet {

/// Estimates the pose of another observer's local frame in the own one, and its drift.
///
/// Both frames have z up, so three coordinates and the heading are unknown, and so is the association of tracks. A
/// comparison of paths finds a first alignment (`PathComparison`).
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
  /// Filter state: pose of the other frame, anchored at a position of the other observer.
  struct State {
    Vector3 anchor_other_m = Vector3::Zero();
    Vector4 x = Vector4::Zero();  // position of the anchor in the own frame, heading
    Matrix4 P = Matrix4::Identity();
    Flown own_flown, other_flown;  // accumulated at that time
  };

  /// A body at one instant, in the own frame.
  struct Seen {
    bool there = false;
    Vector3 p_local_m, lever_local_m = Vector3::Zero();  // lever: from the anchor of the other observer
    Matrix3 covariance;

    /// Derivative of the point with respect to the filter state.
    Eigen::Matrix<double, 3, 4> jacobian() const;
  };

  void compare(const ObserverHistory& own, const ObserverHistory& other, TimeNs t);
  State drifted(const State& before, const PathSample& own, const PathSample& other) const;
  std::vector<Seen> seen_at(TimeNs t, std::span<const SampledPath* const> paths) const;
  std::vector<std::pair<std::size_t, std::size_t>> sure_pairs(std::span<const Seen> own,
                                                              std::span<const Seen> other) const;
  void measure(TimeNs t);
  void update_alignment(const ObserverHistory& own, const ObserverHistory& other);

  FrameLinkConfig config_;
  OdometryDrift drift_;
  PathComparison paths_;
  bool started_ = false;
  State state_;
  std::optional<FrameAlignment> alignment_;
  TimeNs last_ = -1, measured_ = -1;
  int num_disagreements_ = 0;
  std::uint64_t num_starts_ = 0, num_lost_ = 0;
};

/// Transforms a moving point from the other frame to the own one, including the uncertainty of the alignment.
MotionEstimate in_own_frame(const FrameAlignment& alignment, const MotionEstimate& in_other);

}  // namespace swiftlet
