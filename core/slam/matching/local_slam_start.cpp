// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <limits>

#include "core/slam/matching/local_slam.hpp"
#include "swiftlet/core/base/gravity.hpp"
#include "swiftlet/core/math/angles.hpp"

namespace swiftlet {
namespace {

// Normalized square of an innovation per direction: 1 for exact noise models, 0.1 to 0.3 in simulated flights. Above
// it, other time offsets are tried. Larger values miss offsets of 10 ms.
constexpr double kExpectedInnovation = 1.0;
// Normalized square above which the repeated start does not explain a contradiction: 0.2 to 0.4 after a wrong time
// offset, 6 to 11 with a LiDAR turned by 90 or 180 degrees. Larger values let wrong mounts pass.
constexpr double kUnexplainedInnovation = 4.0;
// Time offsets tried at the start: multiples of a quarter of their standard deviation up to 2.5 of them. Smaller steps
// cost time, larger ones leave the right offset outside of the range from which the filter finds it.
constexpr int kTriedSteps = 10;
constexpr double kTriedStep = 0.25;
// Largest number of repetitions of the start, which end when the time offset changes by less than its standard
// deviation. More of them cost time.
constexpr int kMaxRepeats = 5;
// Repetitions of a start with unknown velocity, whose first map consists of smeared scans. The time offset stays as
// given meanwhile: in straight flight it is not observable beside the position of the first scan. More repetitions cost
// time.
constexpr int kRepeatsInMotion = 2;

}  // namespace

/// Repeats the start: all later scans refer to the first ones, which were undistorted by a gyroscope of unknown bias
/// and with an unknown time offset.
void LocalSlam::begin_again() {
  start_.over = true;
  const bool contradicted = innovations_.contradicts();
  if (!start_.imu.empty() && start_.imu.size() < Start::kMaxSamples) {
    if (config_.imu.start_velocity_sigma_mps > kUnknown_mps) {
      for (int i = 0; i < kRepeatsInMotion; ++i) repeat_start(learned_start());
    } else {
      start_.keeps_offset = false;
      if (config_.imu.time_offset_sigma_s == 0.0 || start_.mean_innovation() < kExpectedInnovation)
        repeat_start(learned_start());
      else
        find_time_offset();
    }
  }
  innovations_.begin(contradicted && start_.mean_innovation() > kUnexplainedInnovation);
  start_ = {.over = true, .keeps_offset = false};
}

/// Repeats the start from the offset of the first pass and from the best of several, and adopts the better one.
void LocalSlam::find_time_offset() {
  const InertialFilter first = filter_;
  const Pose T_local_body_first = T_local_body_start_;  // repetitions level the start pose
  repeat_until_settled(first);
  const double innovation = start_.mean_innovation();
  T_local_body_start_ = T_local_body_first;
  repeat_until_settled(best_of_time_offsets());
  if (start_.mean_innovation() <= innovation) return;
  T_local_body_start_ = T_local_body_first;
  repeat_until_settled(first);
}

/// Repeats the start with what has been learned, until the time offset stays the same.
void LocalSlam::repeat_until_settled(const InertialFilter& learned) {
  filter_ = learned;
  for (int i = 0; i < kMaxRepeats; ++i) {
    const double offset_before_s = filter_.state().time_offset_s;
    repeat_start(learned_start());
    if (std::abs(filter_.state().time_offset_s - offset_before_s) < filter_.time_offset_sigma_s()) return;
  }
}

/// Filter whose time offset at the start explains the first scans best. From one start value a large offset is not
/// found: biases and attitude are learned from wrong stamps before it.
InertialFilter LocalSlam::best_of_time_offsets() {
  InertialFilter best = filter_;
  double least = std::numeric_limits<double>::infinity();
  for (int i = -kTriedSteps; i <= kTriedSteps; ++i) {
    InertialConfig tried = config_.imu;
    tried.time_offset_s += kTriedStep * i * config_.imu.time_offset_sigma_s;
    tried.time_offset_sigma_s *= 0.5 * kTriedStep;
    repeat_start(InertialFilter(tried, T_local_body_start_));
    if (start_.num_innovations < config_.start_scans / 2 || start_.mean_innovation() >= least) continue;
    least = start_.mean_innovation();
    best = filter_;
  }
  return best;
}

/// Filter at the start with what has been learned since.
InertialFilter LocalSlam::learned_start() {
  InertialFilter learned = filter_;
  Vector3 v_start_local_mps = learned.state().nav.v_mps - velocity_gained(learned);
  if (config_.imu.start_tilt_sigma_deg * kRadPerDeg > config_.imu.start_accel_bias_sigma_mps2 / kGravity_mps2) {
    level_covariance_rad2_ = learned.level_covariance_rad2();
    const Matrix3 R = learned.level();
    v_start_local_mps = R * v_start_local_mps;
    T_local_body_start_.linear() = R * T_local_body_start_.linear();
  }
  InertialFilter filter(config_.imu, T_local_body_start_);
  filter.begin_with(learned, v_start_local_mps);
  return filter;
}

void LocalSlam::repeat_start(const InertialFilter& filter) {
  filter_ = filter;
  motion_ = {};
  matcher_->clear();
  innovations_ = {};
  drift_ = MapDrift(T_local_body_start_.translation(), level_covariance_rad2_);
  shared_covariance_.setZero();
  inserted_ = {};
  num_inserted_ = 0;
  motion_known_ = false;
  start_.sum_of_innovations = 0.0;
  start_.num_innovations = 0;
  std::size_t next = 0;
  for (const Start::Swept& swept : start_.scans) {
    const auto is_ahead = [&] { return filter_.state().nav.t < imu_time_of_end(*swept.scan); };
    for (; next < start_.imu.size() && (next < swept.after_sample || is_ahead()); ++next) add(start_.imu[next]);
    match(*swept.scan, swept.others);
  }
}

/// Velocity gained since the start, by the IMU alone.
Vector3 LocalSlam::velocity_gained(const InertialFilter& learned) const {
  InertialFilter::State state = learned.state();
  state.nav = {};
  state.nav.q = Eigen::Quaterniond(T_local_body_start_.linear());
  for (std::size_t i = 1; i < start_.imu.size(); ++i) {
    const ImuSample& sample = start_.imu[i];
    const double dt_s = to_seconds(sample.t - start_.imu[i - 1].t);
    state = InertialFilter::advanced(state, sample.omega_body_radps - state.gyro_bias_body_radps,
                                     sample.specific_force_body_mps2 - state.accel_bias_body_mps2, std::max(dt_s, 0.0));
  }
  return state.nav.v_mps;
}

}  // namespace swiftlet
