// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/localization/frame_change.hpp"

#include <cmath>
#include <numbers>

namespace swiftlet {

FrameChange FrameChange::to_world(const StateEstimate& estimate) {
  return estimate.correction_revision == 0 ? FrameChange() : FrameChange(estimate.T_world_local);
}

FrameChange FrameChange::to_local(const StateEstimate& estimate) {
  return estimate.correction_revision == 0 ? FrameChange() : FrameChange(estimate.T_world_local.inverse());
}

double FrameChange::yaw(double yaw_rad) const {
  return same_ ? yaw_rad : std::remainder(yaw_rad + yaw_of(T_to_from_.linear()), 2.0 * std::numbers::pi);
}

Matrix3 FrameChange::covariance(const Matrix3& C) const {
  return same_ ? C : Matrix3(T_to_from_.linear() * C * T_to_from_.linear().transpose());
}

Reference FrameChange::reference(const Reference& r) const {
  return {point(r.position_m), direction(r.velocity_mps), direction(r.acceleration_mps2), yaw(r.yaw_rad),
          r.yaw_rate_radps};
}

Detection FrameChange::detection(const Detection& d) const {
  Detection out = d;
  out.position_m = point(d.position_m);
  out.covariance = covariance(d.covariance);
  return out;
}

Track FrameChange::track(const Track& t) const {
  Track out = t;
  if (same_) return out;
  out.position_m = point(t.position_m);
  out.velocity_mps = direction(t.velocity_mps);
  out.acceleration_mps2 = direction(t.acceleration_mps2);
  Eigen::Matrix<double, 9, 9> R = Eigen::Matrix<double, 9, 9>::Zero();
  for (int i = 0; i < 9; i += 3) R.block<3, 3>(i, i) = T_to_from_.linear();
  out.covariance = R * t.covariance * R.transpose();
  out.measured_m = point(t.measured_m);
  out.measured_covariance = covariance(t.measured_covariance);
  return out;
}

RelativeEstimate FrameChange::relative(const RelativeEstimate& r) const {
  RelativeEstimate out = r;
  if (same_) return out;
  out.position_m = point(r.position_m);
  out.velocity_mps = direction(r.velocity_mps);
  out.yaw_rad = yaw(r.yaw_rad);
  out.report_position_m = point(r.report_position_m);
  out.report_yaw_rad = yaw(r.report_yaw_rad);
  RelativeEstimate::Covariance R = RelativeEstimate::Covariance::Identity();
  for (int i = 0; i < 6; i += 3) R.block<3, 3>(i, i) = T_to_from_.linear();
  out.covariance = R.lazyProduct(RelativeEstimate::Covariance(r.covariance.lazyProduct(R.transpose())));
  return out;
}

void FrameChange::carry(Overlay& overlay) const {
  if (same_) return;
  for (Eigen::Vector3f& p : overlay.positions) p = (T_to_from_ * p.cast<double>()).cast<float>();
}

Pose level_alignment(double yaw_rad, const Vector3& p_to_m, const Vector3& p_from_m) {
  Pose T = Pose::Identity();
  T.linear() = Eigen::AngleAxisd(yaw_rad, Vector3::UnitZ()).toRotationMatrix();
  T.translation() = p_to_m - T.linear() * p_from_m;
  return T;
}

}  // namespace swiftlet
