// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <functional>
#include <vector>

#include "swiftlet/core/localization/relative_alignment.hpp"
#include "swiftlet/core/localization/relative_odometry.hpp"
#include "swiftlet/core/math/angles.hpp"
#include "swiftlet/core/math/random.hpp"
#include "swiftlet/core/messages/kind.hpp"
#include "swiftlet/core/messages/odometry_report.hpp"

namespace swiftlet {

inline Matrix3 turned_by(double yaw_rad) { return Eigen::AngleAxisd(yaw_rad, Vector3::UnitZ()).toRotationMatrix(); }

/// Position of a vehicle in the observer's local frame as a function of time [s].
using Path = std::function<Vector3(double t_s)>;

/// A lying eight that rises and sinks, at up to 0.7 m/s for a radius of 1 m.
inline Path eight(double radius_m = 1.0, double rate_radps = 0.5) {
  return [=](double t) {
    const double phase = rate_radps * t;
    return Vector3(5.0 + radius_m * std::sin(phase), 1.0 + radius_m * std::sin(phase) * std::cos(phase),
                   0.5 + 0.2 * std::sin(0.7 * phase));
  };
}
inline Path rest() {
  return [](double) { return Vector3(5.0, 1.0, 0.5); };
}

/// A flight and what a drifting odometry makes of it: a random walk as the drift's law has it, in small steps.
class OtherFlight {
 public:
  static constexpr double kStep_s = 0.05;

  OtherFlight(const Path& path, double duration_s, const OdometryDriftConfig& drift_config, std::uint64_t seed)
      : random_(seed, "test.flight", "other") {
    const OdometryDrift drift(drift_config);
    const int num_steps = static_cast<int>(duration_s / kStep_s) + 2;
    double yaw_rad = random_.uniform(-kPi, kPi, 0, 0);  // heading of the other frame in the own one
    Vector3 p_other_m(random_.uniform(-50, 50, 0, 1), random_.uniform(-50, 50, 0, 2), random_.uniform(-5, 5, 0, 3));
    Flown flown;
    for (int k = 0; k < num_steps; ++k) {
      const Vector3 here_m = path(k * kStep_s), next_m = path((k + 1) * kStep_s);
      Sample sample;
      sample.p_local_m = here_m;
      sample.yaw_local_other_rad = yaw_rad;
      sample.motion.t = from_seconds(k * kStep_s);
      sample.motion.p_other_local_m = p_other_m;
      const Vector3 v_local_mps = (path(k * kStep_s + 1e-4) - path(k * kStep_s - 1e-4)) / 2e-4;
      sample.v_local_mps = v_local_mps;
      sample.motion.v_other_local_mps = turned_by(-yaw_rad) * v_local_mps;
      sample.motion.yaw_rad = 0.3 - yaw_rad;  // the body's heading in the own frame is 0.3 rad
      sample.motion.flown = flown;
      samples_.push_back(sample);
      Flown step;
      step.path_m = (next_m - here_m).norm();
      step.time_s = kStep_s;
      const double sigma_m = std::sqrt(drift.position_variance_m2(step));
      p_other_m += turned_by(-yaw_rad) * (next_m - here_m) +
                   sigma_m * Vector3(random_.normal(k, 10), random_.normal(k, 11), random_.normal(k, 12));
      yaw_rad += std::sqrt(drift.yaw_variance_rad2(step)) * random_.normal(k, 13);
      flown.path_m += step.path_m;
      flown.time_s += step.time_s;
    }
  }

  struct Sample {
    Vector3 p_local_m, v_local_mps;
    double yaw_local_other_rad;
    OtherMotion motion;
  };
  /// Sample at a multiple of kStep_s.
  const Sample& at(double t_s) const { return samples_.at(static_cast<std::size_t>(std::lround(t_s / kStep_s))); }
  static constexpr double kHeading_rad = 0.3;

 private:
  Random random_;
  std::vector<Sample> samples_;
};

inline OdometryDriftConfig no_drift() { return {0, 0, 0, 0, 0, 0}; }

/// A sighting of the flight at a time, with noise of the given covariance.
inline Vector3 sighting_of(const OtherFlight& flight, double t_s, const Matrix3& covariance, const Random& random) {
  const Matrix3 L = covariance.llt().matrixL();
  const auto k = static_cast<std::uint64_t>(std::llround(t_s * 1000));
  return flight.at(t_s).p_local_m + L * Vector3(random.normal(k, 20), random.normal(k, 21), random.normal(k, 22));
}

/// Wider along the line of sight than across it.
inline Matrix3 sighting_covariance(double sigma_m = 0.06) {
  Matrix3 C = sigma_m * sigma_m * Matrix3::Identity();
  C(0, 0) *= 2.0;
  C(0, 1) = C(1, 0) = 0.3 * sigma_m * sigma_m;
  return C;
}

/// Message of another vehicle that reports its motion.
inline Message odometry_message(const OtherMotion& motion, VehicleId from, TimeNs stamp, TimeNs received) {
  OdometryReport report;
  report.t = stamp;
  report.T_local_body =
      make_pose(motion.p_other_local_m, Eigen::Quaterniond(Eigen::AngleAxisd(motion.yaw_rad, Vector3::UnitZ())));
  report.v_local_mps = motion.v_other_local_mps;
  report.yaw_rate_radps = motion.yaw_rate_radps;
  Message message;
  write_message(report, message);
  message.from = from;
  message.received = received;
  return message;
}

/// Squared error of an alignment in standard deviations, against the true flight at `t_s`.
inline double nees_of(const FrameAlignment& found, const OtherFlight& flight, double t_s) {
  const OtherFlight::Sample& now = flight.at(t_s);
  Eigen::Matrix<double, 4, 1> error;
  error << found.point(now.motion.p_other_local_m) - now.p_local_m,
      std::remainder(found.yaw_rad - now.yaw_local_other_rad, 2.0 * kPi);
  return error.dot(found.covariance.ldlt().solve(error));
}

}  // namespace swiftlet
