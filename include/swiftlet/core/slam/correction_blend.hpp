// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/config.hpp"
#include "swiftlet/core/frames.hpp"

namespace swiftlet {

/// How a new correction is shown. Both forms of the document let a part through at once.
enum class BlendForm {
  kLimited,   ///< no step: speed, acceleration and jerk have limits
  kPrinted,   ///< eq. 2 of [Orsulic 2021] as printed: 6.9 % at once
  kReleased,  ///< as its authors released it: 1.1 % at once
  kNone,      ///< all of it at once
};

struct CorrectionBlendConfig {
  BlendForm form = BlendForm::kLimited;
  double speed_max_mps = 0.25;
  double acceleration_max_mps2 = 0.1;
  double jerk_max_mps3 = 0.15;
  double lever_m = 10.0;

  void visit(ConfigVisitor& v);
};

/// Shows a new correction T_world_local little by little, so that goals of the world do not jump in the local frame
/// that control lives in. A newer correction begins a new blend from the pose that is shown at that moment.
///
/// The limited form also goes on with the rate and the acceleration shown at that moment. It moves the vehicle's place
/// along a polynomial of fifth degree, as long as the limits ask for. They hold for the whole of motion and turn at any
/// point within `lever_m` of where the vehicle was.
class CorrectionBlend {
 public:
  explicit CorrectionBlend(const CorrectionBlendConfig& config) : config_(config) {}

  /// From here on it shows this one, without any blend.
  void reset(const Pose& T_world_local);
  /// A new correction was learned. Not before an instant that advance() has seen.
  void head_for(TimeNs t, const Pose& T_world_local, const Vector3& p_local_body_m);
  /// What is to be shown at t, which does not go back.
  const Pose& advance(TimeNs t);
  /// Is the correction shown in full?
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
  Pose T_world_local_ = Pose::Identity();  // shown
  Pose T_target_ = Pose::Identity();       // world_local, of the blend that goes on
  Vector3 pivot_local_m_ = Vector3::Zero();
  bool blending_ = false;
  TimeNs begin_ = 0;
  double duration_s_ = 0.0;
  Motion start_;
  // The next one, while no motion from here to there keeps the limits.
  bool waiting_ = false;
  Pose T_next_ = Pose::Identity();
  Vector3 next_pivot_local_m_ = Vector3::Zero();
};

}  // namespace swiftlet
