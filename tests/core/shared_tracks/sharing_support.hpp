// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <vector>

#include "core/shared_tracks/covariance_intersection.hpp"
#include "core/shared_tracks/observer_history.hpp"
#include "swiftlet/core/localization/relative_odometry.hpp"
#include "swiftlet/core/math/angles.hpp"
#include "swiftlet/core/math/random.hpp"

namespace swiftlet {

/// Targets on sinusoidal paths in a field: up to 5 m/s and 4 m/s^2.
struct Flyer {
  Vector3 middle_m = Vector3::Zero();
  double radius_m = 8.0;
  double rate_radps = 0.4, phase_rad = 0.0;

  Vector3 p_m(double t) const {
    const double a = rate_radps * t + phase_rad;
    return middle_m + Vector3(radius_m * std::sin(a), radius_m * std::cos(1.37 * a + 0.4), 0.8 * std::sin(0.61 * a));
  }
  Vector3 v_mps(double t) const { return (p_m(t + 1e-4) - p_m(t - 1e-4)) / 2e-4; }
};

inline Matrix3 turned(double yaw_rad) { return Eigen::AngleAxisd(yaw_rad, Vector3::UnitZ()).toRotationMatrix(); }

/// An observer whose local frame drifts against the world by the configured law.
class DriftingObserver {
 public:
  static constexpr double kStep_s = 0.1;

  DriftingObserver(const Flyer& flyer, const OdometryDriftConfig& drift, std::uint64_t seed, const char* name)
      : flyer(flyer), drift_(drift), random_(seed, "test.observer", name) {
    yaw_local_world_rad_ = random_.uniform(-kPi, kPi, 0, 0);
    p_local_m_ = Vector3(random_.uniform(-50, 50, 0, 1), random_.uniform(-50, 50, 0, 2), random_.uniform(-3, 3, 0, 3));
    last_m_ = flyer.p_m(0.0);
  }

  /// The next tenth of a second; the first one is 0.
  void step() {
    ++k_;
    const Vector3 here_m = flyer.p_m(t_s());
    Flown flown;
    flown.path_m = (here_m - last_m_).norm();
    flown.time_s = kStep_s;
    const double sigma_m = std::sqrt(drift_.position_variance_m2(flown));
    p_local_m_ += R() * (here_m - last_m_) +
                  sigma_m * Vector3(random_.normal(k_, 4), random_.normal(k_, 5), random_.normal(k_, 6));
    yaw_local_world_rad_ += std::sqrt(drift_.yaw_variance_rad2(flown)) * random_.normal(k_, 7);
    last_m_ = here_m;
  }

  double t_s() const { return kStep_s * k_; }
  TimeNs t() const { return from_seconds(t_s()); }
  Matrix3 R() const { return turned(yaw_local_world_rad_); }
  double yaw_local_world_rad() const { return yaw_local_world_rad_; }
  const Vector3& p_local_m() const { return p_local_m_; }
  Vector3 v_local_mps() const { return R() * flyer.v_mps(t_s()); }
  Vector3 to_local(const Vector3& p_world_m) const { return p_local_m_ + R() * (p_world_m - flyer.p_m(t_s())); }
  /// Pose of another observer's frame in this one: a point of it, and the heading.
  Vector3 from(const DriftingObserver& other, const Vector3& p_other_m) const {
    return to_local(other.flyer.p_m(other.t_s()) + other.R().transpose() * (p_other_m - other.p_local_m_));
  }
  double yaw_from(const DriftingObserver& other) const {
    return std::remainder(yaw_local_world_rad_ - other.yaw_local_world_rad_, 2.0 * kPi);
  }

  /// Noisy measurement of a target with its covariance.
  MotionEstimate seen(const Flyer& target, std::uint32_t which, double sigma_m, double sigma_mps) const {
    MotionEstimate out;
    out.covariance.setZero();
    out.covariance.diagonal().head<3>().setConstant(sigma_m * sigma_m);
    out.covariance.diagonal().tail<3>().setConstant(sigma_mps * sigma_mps);
    out.mean << to_local(target.p_m(t_s())), R() * target.v_mps(t_s());
    for (std::uint32_t i = 0; i < 3; ++i) {
      out.mean(i) += sigma_m * random_.normal(k_, 20 + 10 * which + i);
      out.mean(i + 3) += sigma_mps * random_.normal(k_, 23 + 10 * which + i);
    }
    return out;
  }

  Flyer flyer;

 private:
  OdometryDrift drift_;
  Random random_;
  int k_ = 0;
  double yaw_local_world_rad_ = 0.0;
  Vector3 p_local_m_, last_m_;
};

inline Flyer observer_a() { return {{-12, 0, 5}, 6.0, 0.35, 0.0}; }
inline Flyer observer_b() { return {{14, 3, 5}, 7.0, 0.28, 2.0}; }
inline Flyer observer_c() { return {{0, 18, 5}, 6.0, 0.31, 4.0}; }
inline Flyer target_1() { return {{-3, 2, 8}, 9.0, 0.4, 1.0}; }
inline Flyer target_2() { return {{6, -4, 9}, 8.0, 0.33, 3.0}; }
inline Flyer target_3() { return {{1, 6, 7}, 7.0, 0.45, 5.0}; }

inline OdometryDriftConfig no_drift() { return {0, 0, 0, 0, 0, 0}; }

}  // namespace swiftlet
