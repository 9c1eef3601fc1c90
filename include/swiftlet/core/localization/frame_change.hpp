// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/base/action.hpp"

namespace swiftlet {

/// Transforms goals from the world into the vehicle's local frame, and outputs back into the world. Without a
/// correction the values stay bit-identical.
class FrameChange {
 public:
  FrameChange() = default;  ///< identity
  static FrameChange to_world(const StateEstimate& estimate);
  static FrameChange to_local(const StateEstimate& estimate);

  Vector3 point(const Vector3& p_from_m) const { return same_ ? p_from_m : Vector3(T_to_from_ * p_from_m); }
  Vector3 direction(const Vector3& v_from) const { return same_ ? v_from : Vector3(T_to_from_.linear() * v_from); }
  /// Both frames have z up, so headings and heights change by a constant.
  double yaw(double yaw_rad) const;
  double height(double z_from_m) const { return same_ ? z_from_m : z_from_m + T_to_from_.translation().z(); }
  Pose pose(const Pose& T_from_body) const { return same_ ? T_from_body : T_to_from_ * T_from_body; }
  Matrix3 covariance(const Matrix3& C) const;
  Reference reference(const Reference& r) const;
  Detection detection(const Detection& d) const;
  Track track(const Track& t) const;
  RelativeEstimate relative(const RelativeEstimate& r) const;
  void carry(Overlay& overlay) const;

 private:
  explicit FrameChange(const Pose& T_to_from) : T_to_from_(T_to_from), same_(false) {}

  Pose T_to_from_ = Pose::Identity();
  bool same_ = true;
};

/// Level transform with the given yaw that maps p_from_m to p_to_m.
Pose level_alignment(double yaw_rad, const Vector3& p_to_m, const Vector3& p_from_m);

}  // namespace swiftlet
