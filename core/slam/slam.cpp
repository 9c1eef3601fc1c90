// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/slam/slam.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/slam/graph/correction_blend.hpp"
#include "core/slam/graph/global_slam.hpp"
#include "core/slam/matching/grid_matcher.hpp"
#include "core/slam/sharing/map_sharing.hpp"
#include "core/slam/slam_to_now.hpp"
#include "swiftlet/core/base/finite.hpp"
#include "swiftlet/core/localization/frame_change.hpp"
#include "swiftlet/core/localization/imu_check.hpp"

namespace swiftlet {
namespace {

// [-] share of a sweep that has passed when it arrives. Larger values refuse stamps that are only a little late.
constexpr double kMinElapsed = 0.5;
// Least changes of the time offset that are reported, also in standard deviations, and for how long. With fewer than
// five, errors of the map, which the filter treats as independent, are reported as an offset.
constexpr double kReportedOffset_s = 0.002, kReportedSigmas = 5.0;
constexpr TimeNs kReportDuration = 2 * kNsPerSecond;

std::unique_ptr<ScanMatcher> make_matcher(const SlamConfig& config) {
  if (config.matching == SlamConfig::Matching::kGrid) return std::make_unique<GridMatcher>(config.grid);
  return std::make_unique<SurfaceMatcher>(config.local);
}

LocalSlamConfig local_config(const SlamConfig& config) {
  LocalSlamConfig local = config.local;
  local.with_imu = config.imu != SlamConfig::Imu::kNone;
  // Only the surfaces' update estimates the offset, and only against an IMU.
  if (config.matching == SlamConfig::Matching::kGrid || !local.with_imu) local.imu.time_offset_sigma_s = 0.0;
  return local;
}

class SlamEstimator : public StateEstimator, public SavedMapProvider, public JoinedMapProvider {
 public:
  SlamEstimator(const SlamConfig& config, const AgentSetup& setup)
      : config_(config),
        latency_(from_seconds(config.latency_s)),
        slam_(local_config(config), config.latency_s, setup.T_local_body_start, setup.airframe.circumscribed_radius_m(),
              make_matcher(config)),
        start_m_(setup.T_local_body_start.translation()),
        heading_known_(setup.start_known == StartKnown::kPose),
        place_known_(setup.start_known != StartKnown::kNothing),
        blend_(config.global.blend) {
    if (config.global.enabled) global_.emplace(config.global, setup.start_known == StartKnown::kPose);
    const bool searches = global_ && config.global.loaded_map != nullptr && setup.start_known != StartKnown::kPose;
    if (searches) search_ = Search::kActive;
    if (global_ && config.global.share.enabled) {
      sharing_.emplace(config.global.share, config.global.closures, setup.self, setup.num_vehicles);
    }
    estimate_.valid = true;
    estimate_.T_local_body = setup.T_local_body_start;
  }

  const StateEstimate& update(const Observation& observation, Outbox& outbox) override {
    if (!started_) {
      slam_.begin_at(observation.t);
      last_imu_ = last_used_ = last_sure_ = observation.t;
    }
    started_ = true;
    if (config_.imu != SlamConfig::Imu::kNone) {
      for (const ImuSample& sample : observation.imu) add(sample);
    }
    for (const auto& scan : observation.scans) {
      if (!uses(*scan)) continue;
      slam_.add(observation.t, scan, others_);
      from_future_ = to_seconds(scan->stamp - observation.t) > -kMinElapsed * to_seconds(scan->duration);
    }
    while (const std::optional<SlamToNow::Matched> matched = slam_.match_next(observation.t)) take(*matched);
    update_estimate(observation.t);
    learn_world(observation);
    if (global_) correct(observation);
    if (sharing_) sharing_->step(observation.t, *global_, observation.messages, outbox);
    check_validity(observation.t);
    return estimate_;
  }

  std::shared_ptr<const SavedMap> saved_map() const override { return global_ ? global_->saved_map() : nullptr; }
  const SubmapPoses* submap_poses() const override { return global_ ? &global_->submap_poses() : nullptr; }
  void append_overlays(std::vector<Overlay>& overlays) const override {
    if (global_) global_->append_overlays(overlays);
    if (sharing_) sharing_->append_overlays(*global_, overlays);
  }
  std::span<const JoinedMap> joined_maps() const override {
    return sharing_ ? sharing_->joined_maps() : std::span<const JoinedMap>();
  }
  void see(std::span<const SeenVehicle> others) override { others_.assign(others.begin(), others.end()); }
  const char* fault() const override { return fault_; }
  const char* warning() const override { return warning_; }
  Search search() const override { return search_; }
  bool should_return() const override { return should_return_; }
  void append_counters(std::vector<Counter>& counters) const override {
    counters.push_back(
        {"scans with too few points near surfaces of the map", num_mismatched_, num_scans_, "local.known_share_min"});
    if (global_) global_->append_counters(counters);
    if (sharing_) sharing_->append_counters(counters);
  }

 private:
  bool uses(const Scan& scan) const {
    return config_.lidars.empty() ||
           std::find(config_.lidars.begin(), config_.lidars.end(), scan.sensor) != config_.lidars.end();
  }

  void add(const ImuSample& sample) {
    slam_.add(sample);
    imu_check_.add(sample);
    if (is_finite(sample)) last_imu_ = std::max(last_imu_, sample.t);
  }

  bool is_placed() const { return heading_known_ && place_known_; }

  void take(const SlamToNow::Matched& matched) {
    const ScanOutcome& outcome = matched.outcome;
    ++num_scans_;
    num_mismatched_ += outcome.num_iterations > 0 && !outcome.used;
    out_of_range_ = outcome.out_of_range;
    if (!outcome.used) return;
    last_used_ = matched.arrived;
    const LocalSlam& slam = slam_.at_scan();
    // With map sharing, the map begins before the pose is known.
    const bool placed = is_placed() || config_.global.loaded_map != nullptr || sharing_;
    if (global_ && outcome.inserted && slam.started() && placed) {
      global_->add_scan(slam.inserted_at().t, slam.inserted_at().T, slam.points_body_m(), estimate_.T_world_local);
    }
    if (outcome.fit.num_degenerate > 0) return;
    last_sure_ = matched.arrived;
    saw_enough_ = saw_enough_ || outcome.num_iterations > 0;
  }

  /// The filter's state, carried from its last IMU sample, or from the last scan without an IMU, to now.
  void update_estimate(TimeNs t) {
    const InertialFilter::State& state = slam_.now().state();
    const NavState& nav = state.nav;
    const double longest_s =
        config_.imu == SlamConfig::Imu::kNone ? config_.latency_s + config_.warn_after_s : config_.imu_timeout_s;
    const double ahead_s = std::clamp(to_seconds(t - nav.t) + state.time_offset_s, 0.0, longest_s);
    estimate_.t = t;
    estimate_.T_local_body =
        make_pose(nav.p_m + ahead_s * nav.v_mps, (nav.q * rotation_by(ahead_s * nav.omega_body_radps)).normalized());
    estimate_.v_local_mps = nav.v_mps;
    estimate_.omega_body_radps = nav.omega_body_radps;
    estimate_.covariance = slam_.pose_covariance(ahead_s);
  }

  void learn_world(const Observation& observation) {
    for (const CompassSample& sample : observation.compass) {
      if (heading_known_ || !std::isfinite(sample.yaw_rad)) continue;
      heading_known_ = true;
      const double yaw_rad = sample.yaw_rad - yaw_of(estimate_.T_local_body.linear());
      estimate_.correct(level_alignment(yaw_rad, start_m_, start_m_));
    }
    for (const GnssSample& sample : observation.gnss) {
      if (!heading_known_ || place_known_ || !sample.p_world_m.allFinite()) continue;
      place_known_ = true;
      estimate_.correct(level_alignment(yaw_of(estimate_.T_world_local.linear()), sample.p_world_m,
                                        estimate_.T_local_body.translation()));
    }
  }

  /// Applies the correction of the pose graph gradually. The revision changes when a new correction begins to be
  /// applied, and when it is complete.
  void correct(const Observation& observation) {
    for (const GnssSample& sample : observation.gnss) global_->add_gnss(sample);
    const std::optional<Pose> learned = global_->correction(observation.t);
    if (search_ != Search::kNone && global_->search_failed()) {
      search_ = is_placed() ? Search::kNone : Search::kFailed;  // continues with compass and GNSS
    }
    if (blend_.is_done() && !learned) return;
    if (learned && search_ != Search::kNone) {  // relocalized: goals in the world frame are usable now
      search_ = Search::kNone;
      heading_known_ = place_known_ = true;
      estimate_.correct(*learned);
      return;
    }
    if (blend_.is_done()) blend_.reset(estimate_.T_world_local);
    if (learned) blend_.head_for(observation.t, *learned, estimate_.T_local_body.translation());
    estimate_.T_world_local = blend_.advance(observation.t);
    if (learned || blend_.is_done()) ++estimate_.correction_revision;
  }

  void check_validity(TimeNs t) {
    const TimeNs due = t - latency_;  // later scans cannot be matched yet
    const double variance_m2 = estimate_.covariance.diagonal().head<3>().maxCoeff();
    const InnovationMonitor& innovations = slam_.at_scan().innovations();
    fault_ = "";
    if (!slam_.now().is_sound())
      fault_ = "SLAM failed: its state is not finite";
    else if (!imu_check_.fault().empty())
      fault_ = imu_check_.fault().c_str();
    else if (from_future_)
      fault_ = "LiDAR: sweeps end in the future; expected stamps of their start, not of their end";
    else if (config_.imu != SlamConfig::Imu::kNone && to_seconds(t - last_imu_) > config_.imu_timeout_s)
      fault_ = "no IMU";
    else if (to_seconds(due - last_used_) > config_.lidar_timeout_s)
      fault_ =
          out_of_range_ ? "LiDAR: returns beyond local.range_max_m; expected m, not mm" : "SLAM is lost: no scan fits";
    else if (innovations.contradicts())
      fault_ = config_.imu == SlamConfig::Imu::kNone
                   ? "SLAM is lost: scans contradict each other"
                   : "SLAM: scans contradict the IMU; check its axes, units and stamps, the mounts of the LiDARs, and "
                     "start_velocity_sigma_mps if the vehicle moved at the start";
    else if (std::sqrt(variance_m2) > config_.position_sigma_max_m)
      fault_ = "position too uncertain";
    estimate_.valid = fault_[0] == '\0';
    report_offset(t);
    const bool degenerate = to_seconds(due - last_sure_) > config_.warn_after_s;
    if (!degenerate) sure_variance_m2_ = variance_m2;
    const double gained_m = std::sqrt(std::max(variance_m2 - sure_variance_m2_, 0.0));
    should_return_ = degenerate && saw_enough_ && config_.return_sigma_m > 0.0 &&
                     (should_return_ || gained_m > config_.return_sigma_m);
    warning_ = "";
    if (to_seconds(due - last_used_) > config_.warn_after_s)
      warning_ = "SLAM: dead reckoning by the IMU alone";
    else if (innovations.disagrees())
      warning_ = "SLAM: scans disagree with the IMU; check its axes, units and stamps, and the mounts of the LiDARs";
    else if (degenerate)
      warning_ = "SLAM is degenerate: the scans do not constrain every direction";
    else if (t < offset_report_until_)
      warning_ = offset_report_.c_str();
  }

  /// Reports the time offset for kReportDuration when it has become significant, or has changed.
  void report_offset(TimeNs t) {
    const double offset_s = slam_.at_scan().filter().state().time_offset_s;
    const double sigma_s = slam_.at_scan().filter().time_offset_sigma_s();
    const double changed_s = std::abs(offset_s - reported_offset_s_);
    if (config_.local.imu.time_offset_sigma_s == 0.0 || changed_s < kReportedOffset_s ||
        changed_s < kReportedSigmas * sigma_s)
      return;
    reported_offset_s_ = offset_s;
    offset_report_until_ = t + kReportDuration;
    offset_report_ = "SLAM: IMU stamps are " + std::to_string(std::llround(1e6 * std::abs(offset_s))) + " us " +
                     (offset_s < 0.0 ? "early" : "late") + " (sigma " + std::to_string(std::llround(1e6 * sigma_s)) +
                     " us)";
  }

  SlamConfig config_;
  TimeNs latency_;
  SlamToNow slam_;
  Vector3 start_m_;
  bool heading_known_, place_known_;  // whether heading and position of the local frame in the world are known
  std::optional<GlobalSlam> global_;
  std::optional<MapSharing> sharing_;
  CorrectionBlend blend_;
  Search search_ = Search::kNone;
  std::vector<SeenVehicle> others_;  // from the last step
  bool started_ = false;
  TimeNs last_imu_ = 0, last_used_ = 0, last_sure_ = 0;
  std::uint64_t num_scans_ = 0, num_mismatched_ = 0;
  ImuCheck imu_check_;
  bool from_future_ = false;   // the last scan ends long after it arrived
  bool out_of_range_ = false;  // the last scan has its returns beyond the largest range
  double reported_offset_s_ = 0.0;
  TimeNs offset_report_until_ = 0;
  std::string offset_report_;
  bool saw_enough_ = false;        // scans have constrained every direction before, so there is a place to return to
  double sure_variance_m2_ = 0.0;  // largest variance of the position when they did so last
  bool should_return_ = false;
  StateEstimate estimate_;
  const char* fault_ = "";
  const char* warning_ = "";
};

}  // namespace

void SlamConfig::visit(ConfigVisitor& v) {
  v.field("lidars", lidars, "[-] names of the LiDARs that SLAM uses; none: all");
  v.choice("imu", imu, {"required", "none"}, "[-] prediction between scans: by the IMU; with constant velocity");
  v.field("latency_s", latency_s, "[s] time from a scan to its effect on the estimate", Range::between(0.0, 0.5));
  v.choice("matching", matching, {"surfaces", "grid"},
           "[-] matching of scans: to planes; to probability grids, as in [Orsulic 2021]");
  v.object("local", local, "motion from scan to scan");
  v.object("grid", grid, "matching: grid");
  v.object("global", global, "closures and GNSS: pose of the local frame in the world");
  v.field("warn_after_s", warn_after_s,
          "[s] time without a matching scan, or with degenerate ones, after which the vehicle warns",
          Range::positive());
  v.field("lidar_timeout_s", lidar_timeout_s, "[s] time without a matching scan after which the estimate is not valid",
          Range::positive());
  v.field("imu_timeout_s", imu_timeout_s, "[s] time without IMU samples after which the estimate is not valid",
          Range::positive());
  v.field("position_sigma_max_m", position_sigma_max_m,
          "[m] standard deviation of the position above which the estimate is not valid", Range::positive());
  v.field("return_sigma_m", return_sigma_m,
          "[m] standard deviation of the motion since scans constrained every direction, above which the vehicle "
          "returns along its path; 0: it never returns",
          Range::non_negative());
}

std::unique_ptr<StateEstimator> make_slam_estimator(const ModuleConfig& config, const AgentSetup& setup) {
  return std::make_unique<SlamEstimator>(dynamic_cast<const SlamConfig&>(config), setup);
}

}  // namespace swiftlet
