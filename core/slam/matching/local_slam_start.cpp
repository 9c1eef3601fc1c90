// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "core/slam/matching/local_slam.hpp"
#include "swiftlet/core/base/elementary.hpp"
#include "swiftlet/core/base/gravity.hpp"
#include "swiftlet/core/math/angles.hpp"

namespace swiftlet {
namespace {

// Time offsets tried at the start: multiples of a quarter of their standard deviation up to 2.5 of them. Smaller steps
// cost time, larger ones leave the right offset outside of the range from which the filter finds it.
constexpr int kTriedSteps = 10;
constexpr double kTriedStep = 0.25;
// Largest number of repetitions of the start, which end when the time offset changes by less than its standard
// deviation. More of them cost time.
constexpr int kMaxRepeats = 5;
// Start velocities tried: standstill, and level flight at the standard deviation of the velocity in this number of
// directions. Fewer leave the right one outside of the range from which the filter finds it; more cost time.
constexpr int kTriedHeadings = 6;
// [-] Standard deviation about each tried velocity, as a share of that of the start. Larger values let scans of all
// tries be attracted to the same wrong velocity.
constexpr double kTriedSpread = 0.25;
// [-] Share of the most points near surfaces from which a velocity is as plausible as the best one; the least
// innovation decides between them. In the open motion differs from standstill by a third of the points, in a forest
// wrong velocities differ by less than a tenth, but by several times the innovation.
constexpr double kNearlyMost = 0.95;
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
      filter_ = best_of_start_velocities();
      for (int i = 0; i < kRepeatsInMotion; ++i) repeat_start(learned_start());
    } else {
      start_.keeps_offset = false;
      if (config_.imu.time_offset_sigma_s == 0.0 || start_.agreement.mean_innovation() < InnovationMonitor::kConsistent)
        repeat_start(learned_start());
      else
        find_time_offset();
    }
  }
  // A time offset outside of the tried range explains no contradiction.
  const double shift_s = std::abs(filter_.state().time_offset_s - config_.imu.time_offset_s);
  const bool explained = start_.agreement.mean_innovation() <= InnovationMonitor::kAgreement &&
                         shift_s <= kTriedSteps * kTriedStep * config_.imu.time_offset_sigma_s;
  innovations_.begin(contradicted && !explained);
  start_ = {.over = true, .keeps_offset = false};
}

/// Repeats the start from the offset of the first pass and from the best of several, and adopts the better one.
void LocalSlam::find_time_offset() {
  const InertialFilter first = filter_;
  const Pose T_local_body_first = T_local_body_start_;  // repetitions level the start pose
  repeat_until_settled(first);
  const double innovation = start_.agreement.mean_innovation();
  T_local_body_start_ = T_local_body_first;
  repeat_until_settled(best_of_time_offsets());
  if (start_.agreement.mean_innovation() <= innovation) return;
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
    if (start_.agreement.num_innovations < config_.start_scans / 2 || start_.agreement.mean_innovation() >= least)
      continue;
    least = start_.agreement.mean_innovation();
    best = filter_;
  }
  return best;
}

/// Filter whose start velocity explains the first scans best. From one start value, points on few rings attract each
/// scan to the place of the last one, and motion is taken for standstill.
InertialFilter LocalSlam::best_of_start_velocities() {
  struct Try {
    InertialFilter filter;
    double near, innovation;
  };
  std::vector<Try> tries;
  double most_near = 0.0;
  InertialConfig tried = config_.imu;
  tried.start_velocity_sigma_mps *= kTriedSpread;
  for (int i = 0; i <= kTriedHeadings; ++i) {
    const double azimuth_rad = 2.0 * kPi * i / kTriedHeadings;
    const Vector3 heading(elementary::cos(azimuth_rad), elementary::sin(azimuth_rad), 0.0);
    InertialFilter filter(tried, T_local_body_start_);
    filter.begin_with(filter, (i < kTriedHeadings ? config_.imu.start_velocity_sigma_mps : 0.0) * heading);
    repeat_start(filter);
    tries.push_back({filter_, start_.agreement.mean_near(), start_.agreement.mean_innovation()});
    most_near = std::max(most_near, tries.back().near);
  }
  std::erase_if(tries, [&](const Try& one) { return one.near < kNearlyMost * most_near; });
  return std::ranges::min_element(tries, {}, &Try::innovation)->filter;
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
  start_.agreement = {};
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
