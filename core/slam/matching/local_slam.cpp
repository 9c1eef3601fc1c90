// SPDX-License-Identifier: BSD-3-Clause
#include "core/slam/matching/local_slam.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <optional>

#include "core/slam/matching/matching_limits.hpp"
#include "swiftlet/core/localization/rotation.hpp"
#include "swiftlet/core/math/angles.hpp"

namespace swiftlet {
namespace {

// [s] Change of the time offset above which a scan is undistorted again: 0.3 mm at 3 m/s. Larger values save time.
constexpr double kTimeShift_s = 1e-4;
// Least speed [m/s] and body rate [rad/s] of a sweep from which the time offset is estimated. Smaller values fit noise.
constexpr double kClear_mps = 0.5, kClear_radps = 0.1;
// [ns] Longest time from the start to the first IMU sample that the sample covers; after it the start pose is that at
// the sample. Larger values turn the start pose by what a late sample measures.
constexpr TimeNs kLongestFirst = 50'000'000;
// [ns] Shortest interval over which the motion of a scan without duration is measured. Smaller values measure noise.
constexpr TimeNs kMotionInterval = 20'000'000;
// Coarse alignment. [-] Number of alignments of a scan during a pause of the IMU, with its motion corrected in between.
// More of them cost time.
constexpr int kAlignments = 2;
// [m] Limits of the kernel's width, and mean range by which the uncertainty of the attitude adds to the width. A wider
// kernel finds larger displacements, and lets more points attract that have no counterpart.
constexpr double kNarrowest_m = 0.3, kWidest_m = 2.0, kMeanRange_m = 10.0;
// [m] Standard deviation of the aligned pose, for the attitude at the mean range. Larger values leave more to the
// prediction, smaller ones to the spacing of the points.
constexpr double kAligned_m = 0.1, kAligned_rad = kAligned_m / kMeanRange_m;
// [s] Longest age of a sighting of another vehicle at which its position is extrapolated. Larger values mask returns at
// wrong places.
constexpr double kVehicleKnown_s = 1.0;
// [m], [rad] Sigma from which a direction counts as open: planes do not measure the error along it. Larger values
// report a larger covariance along weak directions.
constexpr double kOpen_m = 0.1, kOpen_rad = 0.02;

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
  start_.keeps_offset = !start_.over;
  if (!start_.over) start_.imu.reserve(Start::kMaxSamples);
}

void LocalSlam::add(const ImuSample& sample) {
  const bool finite = sample.omega_body_radps.allFinite() && sample.specific_force_body_mps2.allFinite();
  if (!start_.over && finite && start_.imu.size() < Start::kMaxSamples) start_.imu.push_back(sample);
  if (start_time_ && !filter_.has_begun()) {
    // A sample is the mean since the one before, and the first one since the start.
    const bool covers = sample.t > *start_time_ && sample.t - *start_time_ <= kLongestFirst;
    filter_.begin_at(covers ? *start_time_ : sample.t);
  }
  filter_.predict(sample);
  const NavState& nav = filter_.state().nav;
  motion_.push(nav.t, nav.p_m, nav.q);
}

ScanOutcome LocalSlam::add(std::shared_ptr<const Scan> scan, std::vector<SeenVehicle> others) {
  ScanOutcome outcome = match(*scan, others);
  if (start_.over) return outcome;
  start_.scans.push_back({start_.imu.size(), std::move(scan), std::move(others)});
  if (static_cast<int>(start_.scans.size()) >= config_.start_scans) begin_again();
  return outcome;
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
  if (matcher_->num_points() < kMinReturns) {
    outcome.fit.num_points = matcher_->num_points();
    outcome.fit.num_degenerate = 6;
    const auto beyond = std::ranges::count_if(scan.range_m, [&](float r) { return r > config_.range_max_m; });
    outcome.out_of_range = beyond >= kMinReturns;
    return outcome;
  }
  const double sigma_mps = std::sqrt(filter_.covariance().diagonal().segment<3>(InertialFilter::kV).maxCoeff());
  const bool smeared = sigma_mps > kUnknown_mps;
  const bool first = matcher_->is_empty();
  if (!first) update(scan, others, smeared ? 0.5 * sigma_mps * to_seconds(scan.duration) : 0.0, outcome);
  outcome.used = first || outcome.fit.num_known >= config_.known_share_min * outcome.fit.num_points;
  drift_.move_to(filter_.state().nav.p_m);
  if (outcome.num_iterations > 0 && outcome.used) learn_shared_covariance(outcome.fit);
  if (first || (due_for_map() && !is_blurred())) {
    if (smeared && !motion_known_) matcher_->clear();  // the map holds a scan of unknown motion
    const Matrix3 R_local_body = filter_.T_local_body().linear();
    if (matcher_->is_empty()) {
      drift_.inherit(filter_.pose_covariance(), R_local_body);
      filter_.anchor_pose();
    } else {
      // Errors persist: errors of the map while it is in view, errors of the filter for several scans. So the renewed
      // share adds up like one error that lasts until the whole map is renewed.
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
  const bool uncertain = smear_m > 0.0 || filter_.is_coasting();
  const NavState before = filter_.state().nav;
  const double offset_before_s = filter_.state().time_offset_s;
  const TimeNs end = imu_time_of_end(scan);
  if (!start_.keeps_offset)
    filter_.set_scan_motion(clear_part(motion_.mean_motion(end - std::max(scan.duration, kMotionInterval), end)));
  if (!config_.with_imu) filter_.set_scan_lag(0.5 * to_seconds(scan.duration));
  const InertialFilter predicted = filter_;
  std::optional<Pose> coarse = uncertain ? align_coarsely(scan, others) : std::nullopt;
  NavState aligned = filter_.state().nav;
  const ScanMatcher::Uncertainty uncertainty{config_.known_share_min, smear_m, scan.sigma_range_m};
  ScanMatcher::Match found = matcher_->match(filter_, uncertainty);
  if (coarse && found.fit.num_degenerate > 0 && !filter_.is_coasting() && !has_unknown_start()) {
    // Along an aisle, points attract each other without structure, so the prediction by the IMU is more accurate.
    filter_ = predicted;
    correct_motion(aligned, true);
    aligned = filter_.state().nav;
    coarse.reset();
    gather(scan, others);
    found = matcher_->match(filter_, uncertainty);
  }
  outcome.fit = found.fit;
  outcome.num_iterations = found.num_iterations;
  start_.agreement.add_fit(found.fit);
  if (!found.fit.evidence.information.isZero(0.0) && !filter_.is_coasting()) {
    innovations_.add(filter_.innovation_sq(), 6 - found.fit.num_degenerate);
    const bool offset_known = start_.over || config_.imu.time_offset_sigma_s == 0.0;
    if (!has_unknown_start()) innovations_.add_correction(filter_.state().nav.v_mps - before.v_mps, offset_known);
    start_.agreement.add_innovation(filter_.innovation_sq(), 6 - found.fit.num_degenerate);
  }
  if (coarse && found.fit.num_degenerate == 0) filter_.measure(*coarse, kAligned_m, kAligned_rad);
  filter_.set_noise_factor(innovations_.noise_factor());
  turned_rad_ = angle_between_rad(before.q, filter_.state().nav.q);
  correct_motion(aligned, uncertain);
  const bool shifted = std::abs(filter_.state().time_offset_s - offset_before_s) > kTimeShift_s;
  if (uncertain || shifted) gather(scan, others);
}

/// Aligns the scan with the points of the map where the prediction is too poor for a match with its planes: without
/// IMU, and while the velocity is unknown.
std::optional<Pose> LocalSlam::align_coarsely(const Scan& scan, std::span<const SeenVehicle> others) {
  const auto sigma = [&](int i) { return std::sqrt(filter_.covariance().diagonal().segment<3>(i).maxCoeff()); };
  const double width_m =
      std::min(kNarrowest_m + sigma(InertialFilter::kP) + kMeanRange_m * sigma(InertialFilter::kTheta), kWidest_m);
  const InertialFilter predicted = filter_;
  const int num_alignments = filter_.is_coasting() && config_.with_imu ? kAlignments : 1;
  std::optional<Pose> aligned;
  for (int i = 0; i < num_alignments; ++i) {
    const NavState before = filter_.state().nav;
    aligned = matcher_->align(filter_.T_local_body(), width_m);
    if (!aligned) break;
    filter_ = predicted;
    filter_.move_towards(*aligned, kAligned_m, kAligned_rad);
    correct_motion(before, true);
    gather(scan, others);
  }
  return aligned;
}

/// Adapts the motion during the sweep to a correction of the state.
/// @param velocity  whether its velocity is corrected as well; otherwise it is that of the IMU
void LocalSlam::correct_motion(const NavState& before, bool velocity) {
  const NavState& nav = filter_.state().nav;
  motion_.move(filter_.T_local_body() * make_pose(before.p_m, before.q).inverse());
  if (velocity)
    motion_.change_velocity(nav.t, nav.v_mps - before.v_mps, nav.omega_body_radps - before.omega_body_radps);
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
          "[-] number of first scans that are matched again with the biases, the time offset and the velocity "
          "estimated from them; 0: none",
          Range::between(0, 100));
  v.field("known_share_min", known_share_min,
          "[-] minimum share of a scan's points near surfaces of the map for the scan to be used",
          Range::probability());
  v.field("vehicle_radius_m", vehicle_radius_m,
          "[m] distance to a tracked vehicle below which returns are ignored; 0: none are", Range::non_negative());
  v.object("matching", matching, "matching of a scan to the map");
  v.object("map", map, "map of surfaces");
}

}  // namespace swiftlet
