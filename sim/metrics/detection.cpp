// SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/Cholesky>
#include <array>

#include "sim/metrics/seen_scans.hpp"
#include "sim/metrics/statistics.hpp"
#include "sim/metrics/track_identities.hpp"
#include "sim/metrics/truth_history.hpp"
#include "swiftlet/core/math/assignment.hpp"
#include "swiftlet/sim/metrics/detection_score.hpp"
#include "swiftlet/sim/metrics/metric.hpp"

namespace swiftlet::sim {
namespace {

// Definitions of the reported metrics, as in docs/metrics.md.
constexpr MetricDefinition kDetectionRecall = {
    "detection_recall", "",
    "share of flying vehicles within metrics.detection_range_m for which there is a "
    "detection, counted for each scan [Vrba 2025, eq. 71]"};
constexpr MetricDefinition kDetectionRecallVisible = {"detection_recall_visible", "",
                                                      "recall over the vehicles with a return in the scan"};
constexpr MetricDefinition kDetectionPrecision = {
    "detection_precision", "",
    "share of detections assigned to a flying vehicle; detections of vehicles on the ground are not counted"};
constexpr MetricDefinition kDetectionErrorMean = {
    "detection_error_mean_m", "m",
    "mean of |estimated - true position| of found vehicles; truth at the time of the detection, transformed to the "
    "observer's estimated world [Vrba 2025, eq. 68]"};
constexpr MetricDefinition kDetectionErrorStd = {"detection_error_std_m", "m",
                                                 "standard deviation of the position error"};
constexpr MetricDefinition kDetectionLatency = {
    "detection_latency_s", "s", "mean time from the time of validity of a detection to the tick of its report"};
constexpr MetricDefinition kFalseDetections = {"false_detections_per_min", "1/min",
                                               "false detections per minute: farther than metrics.true_positive_m from "
                                               "every vehicle, or a second one of a vehicle [Vrba 2025, eq. 67]"};
constexpr MetricDefinition kTimeToFirstDetection = {
    "time_to_first_detection_s", "s",
    "mean time from the first scan with a return of a vehicle within metrics.detection_range_m to its first detection, "
    "over found vehicles"};
constexpr MetricDefinition kTrackRecall = {
    "track_recall", "",
    "share of flying vehicles within metrics.detection_range_m for which there is a "
    "track, counted for each scan [Vrba 2025, eq. 71]"};
constexpr MetricDefinition kTrackRecallVisible = {"track_recall_visible", "",
                                                  "recall over the vehicles with a return in the scan"};
constexpr MetricDefinition kTrackPrecision = {
    "track_precision", "",
    "share of tracks assigned to a flying vehicle; tracks of vehicles on the ground are not counted"};
constexpr MetricDefinition kTrackErrorMean = {
    "track_error_mean_m", "m",
    "mean of |estimated - true position| of found vehicles; truth at the time of the track, transformed to the "
    "observer's estimated world [Vrba 2025, eq. 68]"};
constexpr MetricDefinition kTrackErrorStd = {"track_error_std_m", "m", "standard deviation of the position error"};
constexpr MetricDefinition kTrackLatency = {"track_latency_s", "s",
                                            "mean time from the time of validity of a track to the tick of its report"};
constexpr MetricDefinition kTrackSpeedError = {"track_speed_error_mean_mps", "m/s",
                                               "mean of |estimated speed - true speed| [Vrba 2025, eq. 69]"};
constexpr MetricDefinition kTrackDirectionError = {
    "track_direction_error_mean_rad", "rad",
    "mean angle between estimated and true velocity of moving vehicles [Vrba 2025, eq. 70]"};
constexpr MetricDefinition kFalseTracks = {"false_tracks_per_min", "1/min",
                                           "tracks per minute that are never assigned to a vehicle"};
constexpr MetricDefinition kTimeToFirstTrack = {
    "time_to_first_track_s", "s",
    "mean time from the first scan with a return of a vehicle to its first track, over found vehicles"};
constexpr MetricDefinition kIdentitySwitches = {"track_identity_switches", "",
                                                "number of changes of the track number assigned to a vehicle"};
constexpr MetricDefinition kCrossAssociations = {"track_cross_associations", "",
                                                 "number of changes of the vehicle assigned to a track"};
constexpr MetricDefinition kTrackOspa = {
    "track_ospa_m", "m",
    "mean optimal subpattern assignment of order 1 between vehicles in range and tracks, "
    "cut off at metrics.true_positive_m (Schuhmacher et al. 2008)"};
constexpr MetricDefinition kTrackNees = {
    "track_nees", "", "mean normalized error squared of tracked positions; 3 for correct covariances"};
constexpr MetricDefinition kTrackNeesWithin95 = {"track_nees_within_95", "",
                                                 "share of normalized errors squared within the 95 % quantile of "
                                                 "chi-square with 3 degrees of freedom; 0.95 for correct covariances"};
constexpr MetricDefinition kDetectionDefinitions[] = {kDetectionRecall,    kDetectionRecallVisible,
                                                      kDetectionPrecision, kDetectionErrorMean,
                                                      kDetectionErrorStd,  kDetectionLatency,
                                                      kFalseDetections,    kTimeToFirstDetection,
                                                      kTrackRecall,        kTrackRecallVisible,
                                                      kTrackPrecision,     kTrackErrorMean,
                                                      kTrackErrorStd,      kTrackLatency,
                                                      kTrackSpeedError,    kTrackDirectionError,
                                                      kFalseTracks,        kTimeToFirstTrack,
                                                      kIdentitySwitches,   kCrossAssociations,
                                                      kTrackOspa,          kTrackNees,
                                                      kTrackNeesWithin95};

/// Metrics that are defined alike for detections and tracks.
struct CommonDefinitions {
  MetricDefinition recall, recall_visible, precision, error_mean, error_std, latency;
};
constexpr CommonDefinitions kOfDetections = {kDetectionRecall,    kDetectionRecallVisible, kDetectionPrecision,
                                             kDetectionErrorMean, kDetectionErrorStd,      kDetectionLatency};
constexpr CommonDefinitions kOfTracks = {kTrackRecall,    kTrackRecallVisible, kTrackPrecision,
                                         kTrackErrorMean, kTrackErrorStd,      kTrackLatency};

// [m/s] True speed below which a vehicle gives no error of direction. Smaller values count the noise of slow tracks.
constexpr double kMoving_mps = 0.5;
// [-] 95 % quantile of chi-square with three degrees of freedom, for the normalized squared error of a position.
constexpr double kChiSquare95 = 7.815;
// [-] Number of distance bins, each metrics.detection_bin_m wide. Farther targets count in the totals only.
constexpr int kBins = 20;

/// Mean and standard deviation of the added values; NaN is ignored.
class Moments {
 public:
  void add(double value) {
    if (std::isnan(value)) return;
    ++count_;
    sum_ += value;
    sum_of_squares_ += value * value;
  }
  double count() const { return static_cast<double>(count_); }
  double mean() const { return count_ > 0 ? sum_ / count() : kNotMeasured; }
  double std() const {
    return count_ > 0 ? std::sqrt(std::max(0.0, sum_of_squares_ / count() - mean() * mean())) : kNotMeasured;
  }

 private:
  std::uint64_t count_ = 0;
  double sum_ = 0.0, sum_of_squares_ = 0.0;
};

double ratio(double part, double whole) { return whole > 0.0 ? part / whole : kNotMeasured; }

/// Counts of targets, of detected targets, and of both among those with returns, summed over scans.
struct Recall {
  int targets = 0, found = 0, visible = 0, visible_found = 0;

  void add(const DetectionScore& score) {
    ++targets;
    found += score.found;
    if (score.visible_points == 0) return;  // an unknown number (-1) counts as visible
    ++visible;
    visible_found += score.found;
  }
  double all() const { return ratio(found, targets); }
  double of_visible() const { return ratio(visible_found, visible); }
};

/// Errors of the estimates of detected targets.
struct Errors {
  Moments position, speed, direction;

  void add(const DetectionScore& score) {
    if (!score.found) return;
    position.add(score.position_error_m);
    speed.add(score.speed_error_mps);
    direction.add(score.direction_error_rad);
  }
};

/// Detection or track, in the observer's estimated world frame.
struct Estimate {
  TimeNs t = 0;
  Vector3 p_m = Vector3::Zero(), v_mps = Vector3::Constant(kNotMeasured);
  Matrix3 covariance = Matrix3::Zero();
  std::uint32_t track_id = 0;
};

/// Results of one observer's detector or tracker over the whole run.
struct StageResult {
  Recall recall;
  Errors errors;
  std::array<Recall, kBins> recall_by_distance;
  std::array<Errors, kBins> errors_by_distance;
  Moments latency, ospa, nees;
  int consistent = 0;              // number of normalized squared errors within kChiSquare95
  int estimates = 0, correct = 0;  // number of estimates, and of those assigned to a flying vehicle
  int false_detections = 0;
  TimeNs t_first = -1, t_last = 0;  // first (-1: none) and last evaluation
  TrackIdentities identities;
  // First scan with returns from a target in range, and its first detection, indexed by VehicleId; -1: never.
  std::vector<TimeNs> first_seen, first_found;

  void prepare(std::size_t num_vehicles) {
    identities.prepare(num_vehicles);
    first_seen.assign(num_vehicles, -1);
    first_found.assign(num_vehicles, -1);
  }
};

/// Optimal subpattern assignment metric of order 1, cut off at the true-positive distance (Schuhmacher et al., IEEE
/// TSP 56(8), 2008), between the flying vehicles in range and the tracks not assigned to other vehicles.
double ospa(std::span<const DetectionScore> scores, std::span<const char> flying, const MetricsConfig& config) {
  const double cut_off_m = config.true_positive_m;
  int vehicles = 0, tracks = 0, paired = 0;
  double sum_m = 0.0;
  for (const DetectionScore& score : scores) {
    const bool in_range = score.distance_m <= config.detection_range_m;
    if (score.target == kNoVehicle) {
      ++tracks;
    } else if (in_range && flying[score.target]) {
      ++vehicles;
      tracks += score.found;
      paired += score.found;
      if (score.found) sum_m += score.position_error_m;
    }
  }
  const int larger = std::max(vehicles, tracks);
  return larger > 0 ? (sum_m + cut_off_m * (larger - paired)) / larger : 0.0;
}

/// Compares detections and tracks of each observer with the true positions of all other vehicles. Estimates inherit the
/// observer's localization error, which the metric estimate_error measures. To exclude it here, the truth is
/// transformed by the observer's pose error at that time. Only flying vehicles are counted; estimates assigned to a
/// vehicle on the ground count neither as correct nor as false.
class DetectionMetric final : public Metric {
 public:
  explicit DetectionMetric(const MetricSetup& setup)
      : Metric(setup), observers_(num_vehicles()), scores_(add_series<DetectionScore>()) {
    for (std::size_t i = 0; i < num_vehicles(); ++i) {
      if (!setup.perception[i].detects && !setup.perception[i].tracks) continue;
      any_ = true;
      Observer& observer = observers_[i];
      observer.detector.prepare(num_vehicles());
      observer.tracker.prepare(num_vehicles());
      observer.T_estimate_truth = std::make_unique<RecentValues<Pose>>();
      observer.scans.prepare(num_vehicles());
    }
    if (any_) truth_.resize(num_vehicles());
  }

  void update(const TickView& tick, const MetricContext& context) override {
    if (!any_) return;
    for (std::size_t i = 0; i < num_vehicles(); ++i)
      truth_[i].push(tick.t, {tick.states[i].p_world_m, tick.states[i].v_world_mps});
    for (std::size_t i = 0; i < num_vehicles(); ++i) {
      const Perception& perception = setup().perception[i];
      if (!perception.detects && !perception.tracks) continue;
      store_history(i, tick);
      const Action& action = *tick.actions[i];
      if (tick.states[i].crashed) continue;
      if (perception.detects && action.has_detections) evaluate_detections(i, tick, context);
      const bool new_scan = !tick.scans[i].empty() || observers_[i].scans.newest() == nullptr;
      if (perception.tracks && action.has_tracks && new_scan) evaluate_tracks(i, tick, context);
    }
  }

  void report(MetricTable& table) const override {
    for (std::size_t i = 0; i < num_vehicles(); ++i) {
      if (setup().perception[i].detects) report_detector(i, table);
      if (setup().perception[i].tracks) report_tracker(i, table);
    }
  }

 private:
  struct Observer {
    StageResult detector, tracker;
    // Transforms from the true world frame to the world frame as estimated by the observer.
    std::unique_ptr<RecentValues<Pose>> T_estimate_truth;
    SeenScans scans;
  };

  // ---- history
  /// Stores the observer's pose error and the returns of its scans at this tick.
  void store_history(std::size_t i, const TickView& tick) {
    Observer& observer = observers_[i];
    const StateEstimate& estimate = tick.actions[i]->estimate;
    if (estimate.valid)
      observer.T_estimate_truth->push(tick.t, estimate.T_world_body() * tick.states[i].T_world_body().inverse());
    for (const auto& labeled : tick.scans[i]) observer.scans.push(*labeled);
  }

  // ---- evaluation of one scan
  void evaluate_detections(std::size_t i, const TickView& tick, const MetricContext& context) {
    const Action& action = *tick.actions[i];
    estimates_.clear();
    for (const Detection& detection : action.detections) {
      Estimate estimate;
      estimate.t = detection.t;
      estimate.p_m = detection.position_m;
      estimate.covariance = detection.covariance;
      estimates_.push_back(estimate);
    }
    const SeenScans::Scan* scan = observers_[i].scans.find(action.detections_stamp);
    const TimeNs middle = scan != nullptr ? scan->middle : action.detections_stamp;
    evaluate(i, DetectionScore::Stage::kDetector, scan, middle, tick.t, context.flying);
  }

  void evaluate_tracks(std::size_t i, const TickView& tick, const MetricContext& context) {
    estimates_.clear();
    for (const Track& track : tick.actions[i]->tracks) {
      Estimate estimate;
      estimate.t = track.t;
      estimate.p_m = track.position_m;
      estimate.v_mps = track.velocity_mps;
      estimate.covariance = track.covariance.topLeftCorner<3, 3>();
      estimate.track_id = track.id;
      estimates_.push_back(estimate);
    }
    const SeenScans::Scan* scan = observers_[i].scans.newest();
    evaluate(i, DetectionScore::Stage::kTracker, scan, scan != nullptr ? scan->middle : tick.t, tick.t, context.flying);
    follow_identities(observers_[i].tracker.identities);
  }

  /// Assigns estimates to vehicles, then scores every flying vehicle and every unassigned estimate.
  void evaluate(std::size_t i, DetectionScore::Stage stage, const SeenScans::Scan* scan, TimeNs middle, TimeNs now,
                std::span<const char> flying) {
    Observer& observer = observers_[i];
    if (observer.T_estimate_truth->empty()) return;
    StageResult& result = stage == DetectionScore::Stage::kDetector ? observer.detector : observer.tracker;
    if (result.t_first < 0) result.t_first = now;
    result.t_last = now;
    assign_estimates(i, observer);

    const std::size_t first_score = scores_.rows().size();
    for (std::size_t j = 0; j < num_vehicles(); ++j) {
      if (j == i || !flying[j]) continue;
      DetectionScore score;
      score.stage = stage;
      score.target = static_cast<VehicleId>(j);
      score.t = middle;
      score.distance_m = (interpolate(truth_[j], middle).p_m - interpolate(truth_[i], middle).p_m).norm();
      score.visible_points = scan != nullptr ? scan->points[j] : -1;
      fill_errors(observer, estimate_of_[j], now, score);
      scores_.push(static_cast<VehicleId>(i), score);
      count(result, score, now);
    }
    for (std::size_t e = 0; e < estimates_.size(); ++e) {
      result.latency.add(to_seconds(now - estimates_[e].t));
      const int vehicle = vehicle_of_[e];
      if (vehicle >= 0 && !flying[vehicle]) continue;
      ++result.estimates;
      result.correct += vehicle >= 0;
      if (vehicle < 0) add_false(i, stage, estimates_[e], now, result);
    }
    if (stage == DetectionScore::Stage::kTracker) {
      result.ospa.add(ospa(scores_.rows().subspan(first_score), flying, setup().config));
    }
  }

  /// Assigns estimates to vehicles with the smallest total distance, where each distance counts as at most the
  /// true-positive distance, as in OSPA. An isolated vehicle gets the nearest estimate, as in eq. (67).
  void assign_estimates(std::size_t i, const Observer& observer) {
    const double gate_m = setup().config.true_positive_m;
    const std::size_t num = estimates_.size();
    distances_.assign(num_vehicles() * num, gate_m);
    for (std::size_t j = 0; j < num_vehicles(); ++j) {
      for (std::size_t e = 0; e < num; ++e) {
        if (j == i) continue;
        const double distance_m = (estimates_[e].p_m - truth_in_estimate(observer, j, estimates_[e].t).p_m).norm();
        if (distance_m < gate_m) distances_[j * num + e] = distance_m;
      }
    }
    estimate_of_.assign(num_vehicles(), -1);
    vehicle_of_.assign(num, -1);
    if (num == 0) return;
    const auto columns = assignment_.solve(distances_, static_cast<int>(num_vehicles()), static_cast<int>(num));
    for (std::size_t j = 0; j < num_vehicles(); ++j) {
      const int e = columns[j];
      if (e < 0 || distances_[j * num + e] >= gate_m) continue;
      estimate_of_[j] = e;
      vehicle_of_[e] = static_cast<int>(j);
    }
  }

  /// True motion of vehicle j at t, transformed to the observer's estimated world frame.
  PointMotion truth_in_estimate(const Observer& observer, std::size_t j, TimeNs t) const {
    const Pose& T = observer.T_estimate_truth->value(observer.T_estimate_truth->before(t));
    const PointMotion truth = interpolate(truth_[j], t);
    return {T * truth.p_m, T.linear() * truth.v_mps};
  }

  void fill_errors(const Observer& observer, int e, TimeNs now, DetectionScore& score) const {
    score.position_error_m = score.speed_error_mps = score.direction_error_rad = score.nees = score.latency_s =
        kNotMeasured;
    if (e < 0) return;
    const Estimate& estimate = estimates_[e];
    const PointMotion truth = truth_in_estimate(observer, score.target, estimate.t);
    const Vector3 error = estimate.p_m - truth.p_m;
    score.found = true;
    score.t = estimate.t;
    score.track_id = estimate.track_id;
    score.latency_s = to_seconds(now - estimate.t);
    score.position_error_m = error.norm();
    const Eigen::LLT<Matrix3> llt(estimate.covariance);
    if (llt.info() == Eigen::Success) score.nees = error.dot(llt.solve(error));
    if (!estimate.v_mps.allFinite()) return;
    const double speed_mps = truth.v_mps.norm(), estimated_mps = estimate.v_mps.norm();
    score.speed_error_mps = std::abs(estimated_mps - speed_mps);
    if (speed_mps < kMoving_mps || !(estimated_mps > 0.0)) return;
    const double cosine = estimate.v_mps.dot(truth.v_mps) / (speed_mps * estimated_mps);
    score.direction_error_rad = std::acos(std::clamp(cosine, -1.0, 1.0));
  }

  void count(StageResult& result, const DetectionScore& score, TimeNs now) {
    const auto bin = static_cast<std::size_t>(score.distance_m / setup().config.detection_bin_m);
    if (bin < kBins) {
      result.recall_by_distance[bin].add(score);
      result.errors_by_distance[bin].add(score);
    }
    if (score.found) {
      result.nees.add(score.nees);
      result.consistent += score.nees <= kChiSquare95;
      if (result.first_found[score.target] < 0) result.first_found[score.target] = now;
    }
    if (score.distance_m > setup().config.detection_range_m) return;
    result.recall.add(score);
    result.errors.add(score);
    if (score.visible_points != 0 && result.first_seen[score.target] < 0) result.first_seen[score.target] = score.t;
  }

  void add_false(std::size_t i, DetectionScore::Stage stage, const Estimate& estimate, TimeNs now,
                 StageResult& result) {
    DetectionScore score;
    score.stage = stage;
    score.t = estimate.t;
    score.track_id = estimate.track_id;
    score.latency_s = to_seconds(now - estimate.t);
    score.distance_m = (estimate.p_m - truth_in_estimate(observers_[i], i, estimate.t).p_m).norm();
    score.position_error_m = score.speed_error_mps = score.direction_error_rad = score.nees = kNotMeasured;
    scores_.push(static_cast<VehicleId>(i), score);
    result.false_detections += 1;
  }

  void follow_identities(TrackIdentities& identities) const {
    identities.begin();
    for (std::size_t e = 0; e < estimates_.size(); ++e) identities.add(estimates_[e].track_id, vehicle_of_[e]);
    identities.end();
  }

  // ---- results
  void report_detector(std::size_t i, MetricTable& table) const {
    const StageResult& r = observers_[i].detector;
    report_common(kOfDetections, i, r, table);
    table.add(kFalseDetections, name_of(i), per_minute(r, r.false_detections));
    table.add(kTimeToFirstDetection, name_of(i), time_to_first_s(r));
    report_bins("detector", i, r, table);
  }

  void report_tracker(std::size_t i, MetricTable& table) const {
    const StageResult& r = observers_[i].tracker;
    report_common(kOfTracks, i, r, table);
    table.add(kTrackSpeedError, name_of(i), r.errors.speed.mean());
    table.add(kTrackDirectionError, name_of(i), r.errors.direction.mean());
    table.add(kFalseTracks, name_of(i), per_minute(r, r.identities.num_false()));
    table.add(kTimeToFirstTrack, name_of(i), time_to_first_s(r));
    table.add(kIdentitySwitches, name_of(i), r.identities.switches());
    table.add(kCrossAssociations, name_of(i), r.identities.cross_associations());
    table.add(kTrackOspa, name_of(i), r.ospa.mean());
    table.add(kTrackNees, name_of(i), r.nees.mean());
    table.add(kTrackNeesWithin95, name_of(i), ratio(r.consistent, r.nees.count()));
    report_bins("tracker", i, r, table);
  }

  void report_common(const CommonDefinitions& what, std::size_t i, const StageResult& r, MetricTable& table) const {
    table.add(what.recall, name_of(i), r.recall.all());
    table.add(what.recall_visible, name_of(i), r.recall.of_visible());
    table.add(what.precision, name_of(i), ratio(r.correct, r.estimates));
    table.add(what.error_mean, name_of(i), r.errors.position.mean());
    table.add(what.error_std, name_of(i), r.errors.position.std());
    table.add(what.latency, name_of(i), r.latency.mean());
  }

  void report_bins(const char* stage, std::size_t i, const StageResult& r, MetricTable& table) const {
    for (int b = 0; b < kBins; ++b) {
      const Recall& recall = r.recall_by_distance[b];
      const Errors& errors = r.errors_by_distance[b];
      if (recall.targets == 0) continue;
      DistanceBin bin;
      bin.vehicle = name_of(i);
      bin.stage = stage;
      bin.from_m = b * setup().config.detection_bin_m;
      bin.to_m = (b + 1) * setup().config.detection_bin_m;
      bin.targets = recall.targets;
      bin.recall = recall.all();
      bin.recall_visible = recall.of_visible();
      bin.error_mean_m = errors.position.mean();
      bin.error_std_m = errors.position.std();
      bin.speed_error_mean_mps = errors.speed.mean();
      bin.direction_error_mean_rad = errors.direction.mean();
      table.add(std::move(bin));
    }
  }

  static double per_minute(const StageResult& r, int count) {
    return r.t_last > r.t_first ? count / (to_seconds(r.t_last - r.t_first) / 60.0) : kNotMeasured;
  }

  /// Mean over the detected targets of the time from the first scan in range with returns from the target to its first
  /// detection.
  static double time_to_first_s(const StageResult& r) {
    Moments time;
    for (std::size_t j = 0; j < r.first_seen.size(); ++j) {
      if (r.first_seen[j] >= 0 && r.first_found[j] >= 0)
        time.add(std::max(0.0, to_seconds(r.first_found[j] - r.first_seen[j])));
    }
    return time.mean();
  }

  std::vector<Observer> observers_;               // indexed by VehicleId
  std::vector<RecentValues<PointMotion>> truth_;  // indexed by VehicleId; empty: no vehicle detects or tracks
  bool any_ = false;                              // whether any vehicle detects or tracks

  // Working data of the scan under evaluation.
  std::vector<Estimate> estimates_;
  std::vector<double> distances_;              // (vehicles x estimates)
  std::vector<int> estimate_of_, vehicle_of_;  // assigned estimate by vehicle, and vehicle by estimate; -1: none
  Assignment assignment_;
  SeriesOf<DetectionScore>& scores_;  // each row is about the observer
};

}  // namespace

MetricType detection_metric() {
  return {"detection", "detections and tracks against the true vehicles [Vrba 2025, eqs. 67-71]",
          make_metric<DetectionMetric>, kDetectionDefinitions};
}

}  // namespace swiftlet::sim
