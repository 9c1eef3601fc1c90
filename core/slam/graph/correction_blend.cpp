// SPDX-License-Identifier: BSD-3-Clause
#include "core/slam/graph/correction_blend.hpp"

#include <algorithm>
#include <cmath>

#include "swiftlet/core/localization/dead_reckoning.hpp"
#include "swiftlet/core/localization/rotation.hpp"

namespace swiftlet {
namespace {

// Steepness, middle and length of the transition [Orsulic 2021, eq. 2].
constexpr double kSteepness = 1.5, kMiddle_s = 3.0, kWindow_s = 7.0;
// Peak speed, acceleration and jerk of the quintic from rest to rest over a distance of 1 in 1 s.
constexpr double kPeakSpeed = 1.875, kPeakAcceleration = 5.7735027, kPeakJerk = 60.0;
// [m/s^3] Jerk limit of the limited form. Larger values shorten blends of small corrections.
constexpr double kJerkMax_mps3 = 0.15;
// [-] Factor of the duration for peaks between two samples. Larger values slow blends down.
constexpr double kMargin = 1.001;
/// [-] Instants at which a blend is compared with its limits. More of them miss smaller peaks and cost time.
constexpr int kSamples = 48;
/// [-] Factor of the duration from attempt to attempt. Smaller factors find shorter blends and need more attempts.
constexpr double kLonger = 1.05;
// [-] Largest number of durations that are tried; if none keeps the limits, the present motion first comes to rest.
// Together with kLonger it bounds the duration by 18 times the first one.
constexpr int kMaxAttempts = 60;

/// Weight of the old pose [Orsulic 2021, eq. 2].
double weight_of_old(BlendForm form, double t_s) {
  return form == BlendForm::kPrinted ? 1.0 / (1.0 + kSteepness * elementary::exp(t_s - kMiddle_s))
                                     : 1.0 / (1.0 + elementary::exp(kSteepness * (t_s - kMiddle_s)));
}

/// A polynomial of fifth degree that comes to rest at zero after T, at the fraction s of T.
struct Quintic {
  Vector3 c0, c1, c2, c3, c4, c5;

  Quintic(const Vector3& x, const Vector3& v, const Vector3& a, double T)
      : c0(x),
        c1(T * v),
        c2(0.5 * T * T * a),
        c3(-10.0 * c0 - 6.0 * c1 - 3.0 * c2),
        c4(15.0 * c0 + 8.0 * c1 + 3.0 * c2),
        c5(-6.0 * c0 - 3.0 * c1 - c2) {}

  Vector3 value(double s) const { return c0 + s * (c1 + s * (c2 + s * (c3 + s * (c4 + s * c5)))); }
  Vector3 first(double s) const { return c1 + s * (2.0 * c2 + s * (3.0 * c3 + s * (4.0 * c4 + s * 5.0 * c5))); }
  Vector3 second(double s) const { return 2.0 * c2 + s * (6.0 * c3 + s * (12.0 * c4 + s * 20.0 * c5)); }
  Vector3 third(double s) const { return 6.0 * c3 + s * (24.0 * c4 + s * 60.0 * c5); }
};

/// Maps the derivative of `turn` to the angular rate of Exp(turn), in the axes of its destination.
Matrix3 left_jacobian(const Vector3& turn_rad) {
  const Matrix3 K = skew_of(turn_rad);
  const double angle = turn_rad.norm(), square = angle * angle;
  if (angle < 1e-4) return Matrix3::Identity() + 0.5 * K + K * K / 6.0;
  return Matrix3::Identity() + (1.0 - elementary::cos(angle)) / square * K +
         (angle - elementary::sin(angle)) / (square * angle) * (K * K);
}

Vector3 turn_between(const Pose& T_to, const Pose& T_from) {
  return rotation_vector_rad(Eigen::Quaterniond(Matrix3(T_to.linear() * T_from.linear().transpose())));
}

}  // namespace

void CorrectionBlend::reset(const Pose& T_world_local) {
  T_world_local_ = T_target_ = T_world_local;
  blending_ = waiting_ = false;
  start_ = {};
}

void CorrectionBlend::head_for(TimeNs t, const Pose& T_world_local, const Vector3& p_local_body_m) {
  advance(t);
  if (config_.form == BlendForm::kLimited) {
    T_next_ = T_world_local;
    next_pivot_local_m_ = p_local_body_m;
    waiting_ = true;
  } else {
    begin_blend(t, T_world_local, Vector3::Zero());  // the document blends the translation of the pose itself
    duration_s_ = kWindow_s;
  }
  advance(t);
}

const Pose& CorrectionBlend::advance(TimeNs t) {
  if (blending_) show_at(t);
  if (waiting_) waiting_ = !begin_limited(t);
  return T_world_local_;
}

void CorrectionBlend::show_at(TimeNs t) {
  const double t_s = to_seconds(t - begin_);
  if (t_s >= duration_s_ || config_.form == BlendForm::kNone) {
    T_world_local_ = T_target_;
    start_ = {};
    blending_ = false;
  } else if (config_.form == BlendForm::kLimited) {
    show(motion_at(t_s).value);
  } else {
    const double w = weight_of_old(config_.form, t_s);
    show({w * start_.value.u_world_m, w * start_.value.turn_world_rad});
  }
}

CorrectionBlend::Motion CorrectionBlend::motion_at(double t_s) const {
  const double T = duration_s_, s = t_s / T;
  const Quintic u(start_.value.u_world_m, start_.rate.u_world_m, start_.acceleration.u_world_m, T);
  const Quintic turn(start_.value.turn_world_rad, start_.rate.turn_world_rad, start_.acceleration.turn_world_rad, T);
  return {{u.value(s), turn.value(s)},
          {u.first(s) / T, turn.first(s) / T},
          {u.second(s) / (T * T), turn.second(s) / (T * T)}};
}

void CorrectionBlend::show(const Offset& offset) {
  const Matrix3 R = rotation_by(offset.turn_world_rad).toRotationMatrix() * T_target_.linear();
  T_world_local_.linear() = R;
  T_world_local_.translation() = T_target_ * pivot_local_m_ + offset.u_world_m - R * pivot_local_m_;
}

void CorrectionBlend::begin_blend(TimeNs t, const Pose& T_world_local, const Vector3& pivot_local_m) {
  start_ = {};
  start_.value.u_world_m = T_world_local_ * pivot_local_m - T_world_local * pivot_local_m;
  start_.value.turn_world_rad = turn_between(T_world_local_, T_world_local);
  T_target_ = T_world_local;
  pivot_local_m_ = pivot_local_m;
  begin_ = t;
  blending_ = true;
}

/// Blends from the pose shown now, with its rate and acceleration. False when no such motion keeps the limits: the
/// present motion then first comes to rest within them, and a blend from rest always exists.
bool CorrectionBlend::begin_limited(TimeNs t) {
  Motion start;
  if (blending_) {
    const double t_s = to_seconds(t - begin_);
    const Motion now = t_s < duration_s_ ? motion_at(t_s) : Motion{};
    const Matrix3 J = left_jacobian(now.value.turn_world_rad);
    const Vector3 omega_world = J * now.rate.turn_world_rad, alpha_world = J * now.acceleration.turn_world_rad;
    const Vector3 arm_world_m = T_world_local_.linear() * (next_pivot_local_m_ - pivot_local_m_);
    start.rate.u_world_m = now.rate.u_world_m + omega_world.cross(arm_world_m);
    start.acceleration.u_world_m =
        now.acceleration.u_world_m + alpha_world.cross(arm_world_m) + omega_world.cross(omega_world.cross(arm_world_m));
    const Matrix3 J_inverse = left_jacobian(turn_between(T_world_local_, T_next_)).inverse();
    start.rate.turn_world_rad = J_inverse * omega_world;
    start.acceleration.turn_world_rad = J_inverse * alpha_world;
  }
  start.value.u_world_m = T_world_local_ * next_pivot_local_m_ - T_next_ * next_pivot_local_m_;
  start.value.turn_world_rad = turn_between(T_world_local_, T_next_);
  const double displacement_m = start.value.u_world_m.norm() + config_.lever_m * start.value.turn_world_rad.norm();
  double duration_s = kMargin * std::max({kPeakSpeed * displacement_m / config_.speed_max_mps,
                                          std::sqrt(kPeakAcceleration * displacement_m / config_.acceleration_max_mps2),
                                          elementary::cbrt(kPeakJerk * displacement_m / kJerkMax_mps3), 1e-3});
  for (int i = 0; i < kMaxAttempts; ++i, duration_s *= kLonger) {
    if (peak_share(start, duration_s) > 1.0) continue;
    begin_blend(t, T_next_, next_pivot_local_m_);
    start_ = start;
    duration_s_ = duration_s;
    return true;
  }
  return false;
}

/// Largest ratio of speed, acceleration and jerk to their limits.
double CorrectionBlend::peak_share(const Motion& start, double duration_s) const {
  const double T = duration_s;
  const Quintic u(start.value.u_world_m, start.rate.u_world_m, start.acceleration.u_world_m, T);
  const Quintic turn(start.value.turn_world_rad, start.rate.turn_world_rad, start.acceleration.turn_world_rad, T);
  double peak = 0.0;
  for (int i = 0; i <= kSamples; ++i) {
    const double s = static_cast<double>(i) / kSamples;
    const auto both = [&](const Vector3& of_u, const Vector3& of_turn) {
      return of_u.norm() + config_.lever_m * of_turn.norm();
    };
    peak = std::max({peak, both(u.first(s), turn.first(s)) / (T * config_.speed_max_mps),
                     both(u.second(s), turn.second(s)) / (T * T * config_.acceleration_max_mps2),
                     both(u.third(s), turn.third(s)) / (T * T * T * kJerkMax_mps3)});
  }
  return peak;
}

void CorrectionBlendConfig::visit(ConfigVisitor& v) {
  v.choice("form", form, {"limited", "printed", "released", "none"},
           "transition to a new correction: with limited motion, by eq. 2 of [Orsulic 2021] as printed or as released, "
           "or at once");
  v.field("speed_max_mps", speed_max_mps, "[m/s] speed limit of the limited form", Range::positive());
  v.field("acceleration_max_mps2", acceleration_max_mps2, "[m/s^2] acceleration limit of the limited form",
          Range::positive());
}

}  // namespace swiftlet
