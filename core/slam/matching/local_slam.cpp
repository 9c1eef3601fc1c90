// SPDX-License-Identifier: BSD-3-Clause
#include "core/slam/matching/local_slam.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "swiftlet/core/base/gravity.hpp"
#include "swiftlet/core/localization/rotation.hpp"
#include "swiftlet/core/math/angles.hpp"

namespace swiftlet {
namespace {

constexpr double kUnknownVelocity_mps = 0.3;  // velocity sigma above which a scan counts as smeared
// [s] Change of the time offset above which a scan is undistorted again: 0.3 mm at 3 m/s. Larger values save time.
constexpr double kTimeShift_s = 1e-4;
// Least speed [m/s] and body rate [rad/s] of a sweep from which the time offset is estimated. Smaller values fit noise.
constexpr double kClear_mps = 0.5, kClear_radps = 0.1;
// [ns] Shortest interval over which the motion of a scan without duration is measured. Smaller values measure noise.
constexpr TimeNs kMotionInterval = 20'000'000;
// [samples] Most IMU samples kept for a second start, which is skipped if the first scans need more.
constexpr std::size_t kMostStartSamples = 4096;
// [s] Longest age of a sighting of another vehicle at which its position is extrapolated. Larger values mask returns at
// wrong places.
constexpr double kVehicleKnown_s = 1.0;
constexpr int kLeastReturns = 50;  // fewest points of a scan that is matched
// Sigma from which a direction counts as open: planes do not measure the error along it.
constexpr double kOpen_m = 0.1, kOpen_rad = 0.02;

// Normalized square of an innovation per direction: 1 for exact noise models, 0.1 to 0.3 in simulated flights. Above
// it, other time offsets are tried. Larger values miss offsets of 10 ms.
constexpr double kExpectedInnovation = 1.0;
// Time offsets tried at the start: multiples of a quarter of their standard deviation up to 2.5 of them. Smaller steps
// cost time, larger ones leave the right offset outside of the range from which the filter finds it.
constexpr int kTriedSteps = 10;
constexpr double kTriedStep = 0.25;
// Most repetitions of the start, which end when the time offset changes by less than its standard deviation. More of
// them cost time.
constexpr int kMostRepeats = 5;

/// Motion without the parts that may be noise, from which no time offset can be learned.
Eigen::Matrix<double, 6, 1> clear_part(Eigen::Matrix<double, 6, 1> motion) {
  if (motion.head<3>().norm() < kClear_mps) motion.head<3>().setZero();
  if (motion.tail<3>().norm() < kClear_radps) motion.tail<3>().setZero();
  return motion;
}

double angle_between_rad(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b) {
  return rotation_vector_rad(a.conjugate() * b).norm();
}

}  // namespace

LocalSlam::LocalSlam(const LocalSlamConfig& config, const Pose& T_local_body_start, double own_radius_m,
                     std::unique_ptr<ScanMatcher> matcher)
    : config_(config),
      T_local_body_start_(T_local_body_start),
      own_radius_m_(own_radius_m),
      filter_(config.imu, T_local_body_start),
      matcher_(matcher ? std::move(matcher) : std::make_unique<SurfaceMatcher>(config)),
      admission_(matcher_->admission()),
      drift_(T_local_body_start.translation()) {
  start_.over = config.start_scans == 0;
  if (!start_.over) start_.imu.reserve(kMostStartSamples);
}

void LocalSlam::add(const ImuSample& sample) {
  const bool finite = sample.omega_body_radps.allFinite() && sample.specific_force_body_mps2.allFinite();
  if (!start_.over && finite && start_.imu.size() < kMostStartSamples) start_.imu.push_back(sample);
  filter_.predict(sample);
  const NavState& nav = filter_.state().nav;
  motion_.push(nav.t, nav.p_m, nav.q);
}

ScanOutcome LocalSlam::add(std::shared_ptr<const Scan> scan, std::vector<SeenVehicle> others) {
  const ScanOutcome outcome = match(*scan, others);
  if (start_.over) return outcome;
  start_.scans.push_back({start_.imu.size(), std::move(scan), std::move(others)});
  if (static_cast<int>(start_.scans.size()) >= config_.start_scans) begin_again();
  return outcome;
}

/// Repeats the start: all later scans refer to the first ones, which were undistorted by a gyroscope of unknown bias
/// and with an unknown time offset.
void LocalSlam::begin_again() {
  start_.over = true;
  if (!start_.imu.empty() && start_.imu.size() < kMostStartSamples) {
    if (config_.imu.time_offset_sigma_s == 0.0 || start_.mean_innovation() < kExpectedInnovation)
      repeat_start(learned_start());
    else
      find_time_offset();
  }
  start_ = {.over = true};
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
  for (int i = 0; i < kMostRepeats; ++i) {
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
  drift_ = MapDrift(T_local_body_start_.translation());
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

/// Propagates the state to the end of the scan.
void LocalSlam::reach_end(const Scan& scan) {
  const TimeNs end = imu_time_of_end(scan);
  if (!config_.with_imu && motion_.empty()) filter_.begin_at(end);
  filter_.predict_to(end);
  const NavState& nav = filter_.state().nav;
  if (!config_.with_imu || !motion_.empty()) motion_.push(nav.t, nav.p_m, nav.q);
}

ScanOutcome LocalSlam::match(const Scan& scan, std::span<const SeenVehicle> others) {
  ScanOutcome outcome;
  reach_end(scan);
  if (motion_.empty()) return outcome;
  gather(scan, others);
  if (matcher_->num_points() < kLeastReturns) {
    outcome.fit.num_points = matcher_->num_points();
    outcome.fit.num_degenerate = 6;
    const auto beyond = std::ranges::count_if(scan.range_m, [&](float r) { return r > config_.range_max_m; });
    outcome.out_of_range = beyond >= kLeastReturns;
    return outcome;
  }
  const double sigma_mps = std::sqrt(filter_.covariance().diagonal().segment<3>(InertialFilter::kV).maxCoeff());
  const bool smeared = sigma_mps > kUnknownVelocity_mps;
  const bool first = matcher_->is_empty();
  if (!first) update(scan, others, smeared ? 0.5 * sigma_mps * to_seconds(scan.duration) : 0.0, outcome);
  outcome.used = first || outcome.fit.num_known >= config_.known_share_min * outcome.fit.num_points;
  drift_.move_to(filter_.state().nav.p_m);
  if (outcome.num_iterations > 0 && outcome.used) learn_shared_covariance(outcome.fit);
  if (first || due_for_map()) {
    if (smeared && !motion_known_) matcher_->clear();  // the map holds a scan of unknown motion
    const Matrix3 R_local_body = filter_.T_local_body().linear();
    if (matcher_->is_empty()) {
      drift_.inherit(filter_.pose_covariance(), R_local_body);
      filter_.anchor_pose();
    } else {
      // Errors persist: those of the map while it is in view, the filter's own for several scans. So the renewed share
      // adds up like one error that lasts until the whole map is renewed.
      drift_.inherit(
          innovations_.covariance_factor() * outcome.fit.renewal * (filter_.pose_covariance() + shared_covariance_),
          R_local_body);
    }
    insert();
    outcome.inserted = true;
  }
  // Without an IMU two scans give the velocity.
  motion_known_ = motion_known_ || (!first && (!smeared || filter_.is_coasting()));
  return outcome;
}

/// Corrects the state by the scan, and then the points of the scan by the corrected motion during the sweep.
void LocalSlam::update(const Scan& scan, std::span<const SeenVehicle> others, double smear_m, ScanOutcome& outcome) {
  const NavState before = filter_.state().nav;
  const double offset_before_s = filter_.state().time_offset_s;
  const TimeNs end = imu_time_of_end(scan);
  if (start_.over)  // errors of the first velocities would count as an offset
    filter_.set_scan_motion(clear_part(motion_.mean_motion(end - std::max(scan.duration, kMotionInterval), end)));
  const ScanMatcher::Match found = matcher_->match(filter_, {config_.known_share_min, smear_m, scan.sigma_range_m});
  outcome.fit = found.fit;
  outcome.num_iterations = found.num_iterations;
  if (!found.fit.evidence.information.isZero(0.0)) {
    innovations_.add(filter_.innovation_sq(), 6 - found.fit.num_degenerate);
    start_.add_innovation(filter_.innovation_sq(), 6 - found.fit.num_degenerate);
  }
  filter_.set_noise_factor(innovations_.noise_factor());
  const NavState& nav = filter_.state().nav;
  motion_.move(filter_.T_local_body() * make_pose(before.p_m, before.q).inverse());
  const bool shifted = std::abs(filter_.state().time_offset_s - offset_before_s) > kTimeShift_s;
  if (smear_m > 0.0 || filter_.is_coasting())
    motion_.change_velocity(nav.t, nav.v_mps - before.v_mps, nav.omega_body_radps - before.omega_body_radps);
  if (smear_m > 0.0 || filter_.is_coasting() || shifted) gather(scan, others);
}

/// Covariance shared by scans that meet the same part of the map; the filter treats scans as independent.
void LocalSlam::learn_shared_covariance(const ScanFit& fit) {
  Matrix6 bounded = fit.evidence.information;
  bounded.diagonal().head<3>().array() += 1.0 / (kOpen_m * kOpen_m);
  bounded.diagonal().tail<3>().array() += 1.0 / (kOpen_rad * kOpen_rad);
  const Matrix6 inverse = bounded.inverse();
  shared_covariance_ = fit.map_share * inverse * fit.evidence.information * inverse;
}

void LocalSlam::gather(const Scan& scan, std::span<const SeenVehicle> others) {
  undistort(scan, motion_, filter_.state().nav.t, own_radius_m_, config_.range_max_m, returns_body_m_, time_offset());
  if (!others.empty() && config_.vehicle_radius_m > 0.0) leave_out(others);
  matcher_->take(returns_body_m_, num_inserted_ < admission_.first_scans);
}

/// Removes points at the predicted positions of other vehicles: moving vehicles are no part of the map.
void LocalSlam::leave_out(std::span<const SeenVehicle> others) {
  const TimeNs t = filter_.state().nav.t;
  const Pose T_body_local = filter_.T_local_body().inverse();
  std::vector<Eigen::Vector3f> places_body_m;
  for (const SeenVehicle& other : others) {
    const double since_s = to_seconds(t - other.t);
    if (std::abs(since_s) > kVehicleKnown_s || !other.position_local_m.allFinite()) continue;
    const Vector3 p_local_m = other.position_local_m + since_s * other.velocity_local_mps;
    places_body_m.push_back((T_body_local * p_local_m).cast<float>());
  }
  const auto square = static_cast<float>(config_.vehicle_radius_m * config_.vehicle_radius_m);
  std::erase_if(returns_body_m_, [&](const Eigen::Vector3f& p) {
    return std::ranges::any_of(places_body_m, [&](const auto& place) { return (p - place).squaredNorm() < square; });
  });
}

bool LocalSlam::due_for_map() const {
  const NavState& nav = filter_.state().nav;
  return num_inserted_ < admission_.first_scans || to_seconds(nav.t - inserted_.t) >= admission_.after_s ||
         (nav.p_m - inserted_.T.translation()).norm() >= admission_.after_m ||
         angle_between_rad(Eigen::Quaterniond(inserted_.T.linear()), nav.q) >= admission_.after_rad;
}

void LocalSlam::insert() {
  inserted_ = {filter_.state().nav.t, filter_.T_local_body()};
  matcher_->insert(inserted_.T);
  ++num_inserted_;
}

Matrix6 LocalSlam::pose_covariance(const InertialFilter& filter, double ahead_s) const {
  return innovations_.covariance_factor() * (filter.pose_covariance_after(ahead_s) + shared_covariance_) +
         drift_.covariance(filter.state().nav.q.toRotationMatrix());
}

void MapDrift::move_to(const Vector3& p_local_m) {
  // A rotation of the map by phi moves points at distance d by phi x d.
  Matrix6 A = Matrix6::Identity();
  A.topRightCorner<3, 3>() = -skew_of(p_local_m - p_local_m_);
  C_ = (A * C_ * A.transpose()).eval();
  p_local_m_ = p_local_m;
}

void MapDrift::inherit(const Matrix6& covariance, const Matrix3& R_local_body) {
  Matrix6 J = Matrix6::Identity();
  J.bottomRightCorner<3, 3>() = R_local_body;
  C_ += J * covariance * J.transpose();
}

Matrix6 MapDrift::covariance(const Matrix3& R_local_body) const {
  Matrix6 J = Matrix6::Identity();
  J.bottomRightCorner<3, 3>() = R_local_body.transpose();
  return J * C_ * J.transpose();
}

void LocalSlamConfig::visit(ConfigVisitor& v) {
  v.object("imu", imu, "noise of the IMU, and uncertainty at the start");
  v.field("range_max_m", range_max_m, "[m] range above which returns are ignored", Range::between(1.0, 1000.0));
  v.field("start_scans", start_scans,
          "[-] number of first scans that are matched again with the biases and the time offset estimated from them; "
          "0: none",
          Range::between(0, 100));
  v.field("iterations", iterations, "[-] most iterations of the update by a scan", Range::between(1, 50));
  v.field("known_share_min", known_share_min,
          "[-] least share of a scan's points near surfaces of the map for the scan to be used", Range::probability());
  v.field("vehicle_radius_m", vehicle_radius_m,
          "[m] distance to a tracked vehicle below which returns are ignored; 0: none are", Range::non_negative());
  v.object("matching", matching, "matching of a scan to the map");
  v.object("map", map, "map of surfaces");
}

}  // namespace swiftlet
