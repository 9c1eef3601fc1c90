// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/base/config.hpp"
#include "swiftlet/core/base/frames.hpp"
#include "swiftlet/core/slam/global_slam_config.hpp"

namespace swiftlet {

/// Blends in a new correction T_world_local, so that goals in the world frame do not jump in the local frame of the
/// controller. A newer correction starts a new blend from the present output.
///
/// The limited form also continues the present rate and acceleration. It moves the vehicle's position along a quintic
/// polynomial with the duration required by the limits. They apply to the combined translation and rotation of any
/// point within `lever_m` of the vehicle's position at the start.
class CorrectionBlend {
 public:
  explicit CorrectionBlend(const CorrectionBlendConfig& config) : config_(config) {}

  /// Sets the output without a blend.
  void reset(const Pose& T_world_local);
  /// Starts a blend toward a new correction. `t` is not before the last advance().
  void head_for(TimeNs t, const Pose& T_world_local, const Vector3& p_local_body_m);
  /// Output at t, which must not decrease.
  const Pose& advance(TimeNs t);
  /// True when the output equals the correction.
  bool is_done() const { return !blending_ && !waiting_; }

 private:
  /// Displacement of a point and rotation vector, both in world axes, and their derivatives.
  struct Offset {
    Vector3 u_world_m = Vector3::Zero(), turn_world_rad = Vector3::Zero();
  };
  struct Motion {
    Offset value, rate, acceleration;
  };
  Motion motion_at(double t_s) const;
  void show_at(TimeNs t);
  void show(const Offset& offset);
  void begin_blend(TimeNs t, const Pose& T_world_local, const Vector3& pivot_local_m);
  bool begin_limited(TimeNs t);
  double peak_share(const Motion& start, double duration_s) const;

  CorrectionBlendConfig config_;
  Pose T_world_local_ = Pose::Identity();  // output
  Pose T_target_ = Pose::Identity();       // target of the present blend
  Vector3 pivot_local_m_ = Vector3::Zero();
  bool blending_ = false;
  TimeNs begin_ = 0;
  double duration_s_ = 0.0;
  Motion start_;
  // Pending correction, while no motion toward it keeps the limits.
  bool waiting_ = false;
  Pose T_next_ = Pose::Identity();
  Vector3 next_pivot_local_m_ = Vector3::Zero();
};

}  // namespace swiftlet
