// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/tracking/trackers.hpp"

#include <algorithm>
#include "core/tracking/cloud_tracker.hpp"

namespace swiftlet {
namespace {

class CloudTrackerModule : public Tracker {
 public:
  CloudTrackerModule(std::string sensor, const CloudTrackerConfig& config, std::unique_ptr<MotionFilter> filter)
      : sensor_(std::move(sensor)), tracker_(config, std::move(filter)) {}

  bool step(const TrackerInput& input, std::vector<Track>& tracks, Outbox&) override {
    bool changed = input.has_detections;
    for (const auto& cloud : input.clouds) {
      if (sensor_.empty()) sensor_ = cloud->scan->sensor;
      if (cloud->scan->sensor != sensor_) continue;
      tracker_.new_cloud(*cloud, input.background);
      changed = true;
    }
    if (!changed) return false;
    tracker_.new_detections(input.detections, input.background);
    tracker_.publish(tracks);
    return true;
  }

  void modes(std::vector<TrackModes>& modes) const override { tracker_.publish_modes(modes); }
  void append_counters(std::vector<Counter>& counters) const override { tracker_.append_counters(counters); }

 private:
  std::string sensor_;  // sensor of the first cloud when none is configured
  CloudTracker tracker_;
};

/// Passes on the tracks of a detector that maintains its own, such as track_before_detect.
class DetectorTracks : public Tracker {
 public:
  bool step(const TrackerInput& input, std::vector<Track>& tracks, Outbox&) override {
    if (!input.has_detections) return false;
    tracks.assign(input.detector_tracks.begin(), input.detector_tracks.end());
    return true;
  }
};

/// Tracks of the neighbors that a mutual-localization sensor identifies and measures: one Kalman filter for each
/// neighbor.
class GroundTruthTracker : public Tracker {
 public:
  explicit GroundTruthTracker(const GroundTruthTrackerConfig& config)
      : config_(config), filter_(make_kalman_filter(config.filter)) {}

  bool step(const TrackerInput& input, std::vector<Track>& tracks, Outbox&) override {
    const std::size_t before = targets_.size();
    bool changed = false;
    for (const NeighborSample& sample : input.observation.neighbors) {
      if (sample.p_body_m.allFinite() && sample.p_body_m.norm() <= config_.range_max_m) {
        correct_track(sample, input.estimate.T_local_body);
        changed = true;
      }
    }
    const TimeNs timeout = from_seconds(config_.timeout_s);
    std::erase_if(targets_, [&](const Target& target) { return input.observation.t - target.t > timeout; });
    if (!changed && targets_.size() == before) return false;
    tracks.clear();
    for (const Target& target : targets_) tracks.push_back(track_of(target));
    return true;
  }

 private:
  struct Target {
    VehicleId id = kNoVehicle;
    TimeNs t = 0;
    MotionState state;
    int num_samples = 0;
    Vector3 measured_m = Vector3::Zero();  // position of the newest sample, local frame
    Matrix3 measured_covariance = Matrix3::Identity();
  };
  /// [m] Standard deviation added to the measurement noise, because the zero covariance of an ideal sensor would make
  /// the filter singular. Larger values smooth the tracks more.
  static constexpr double kAddedSigma_m = 1e-3;

  /// Corrects the track of the measured neighbor, or begins a new one.
  void correct_track(const NeighborSample& sample, const Pose& T_local_body) {
    const Matrix3& R = T_local_body.linear();
    const Vector3 position_m = T_local_body * sample.p_body_m;
    const Matrix3 Z = R * sample.covariance_body * R.transpose() + kAddedSigma_m * kAddedSigma_m * Matrix3::Identity();
    auto target = std::lower_bound(targets_.begin(), targets_.end(), sample.id,
                                   [](const Target& t, VehicleId id) { return t.id < id; });
    if (target == targets_.end() || target->id != sample.id) {
      targets_.insert(target, {sample.id, sample.t, filter_->start(position_m, Z), 1, position_m, Z});
      return;
    }
    if (sample.t < target->t) return;
    filter_->predict(target->state, to_seconds(sample.t - target->t));
    filter_->correct(target->state, position_m, Z);
    target->t = sample.t;
    ++target->num_samples;
    target->measured_m = position_m;
    target->measured_covariance = Z;
  }

  static Track track_of(const Target& target) {
    Track track;
    track.id = static_cast<std::uint32_t>(target.id + 1);
    track.t = target.t;
    track.position_m = target.state.belief.mean.head<3>();
    track.velocity_mps = target.state.belief.mean.segment<3>(3);
    track.acceleration_mps2 = target.state.belief.mean.tail<3>();
    track.covariance = target.state.belief.covariance;
    track.num_detections = target.num_samples;
    track.corrected = true;
    track.measured_m = target.measured_m;
    track.measured_covariance = target.measured_covariance;
    return track;
  }

  GroundTruthTrackerConfig config_;
  std::unique_ptr<MotionFilter> filter_;
  std::vector<Target> targets_;  // ordered by id
};

}  // namespace

void VofodTrackerConfig::visit(ConfigVisitor& v) {
  v.field("sensor", sensor, "[-] name of the LiDAR; empty: the LiDAR of the first scan");
  tracker.visit(v);
  v.object("filter", filter, "motion model of a target");
}

void ImmTrackerConfig::visit(ConfigVisitor& v) {
  v.field("sensor", sensor, "[-] name of the LiDAR; empty: the LiDAR of the first scan");
  tracker.visit(v);
  v.object("filter", filter, "motion models of a target");
}

void GroundTruthTrackerConfig::visit(ConfigVisitor& v) {
  v.field("range_max_m", range_max_m, "[m] range beyond which neighbors are not detected", Range::positive());
  v.field("timeout_s", timeout_s, "[s] time without a sample after which a track ends", Range::positive());
  v.object("filter", filter, "motion model, for velocity and acceleration");
}

std::unique_ptr<Tracker> make_no_tracker(const ModuleConfig&, const AgentSetup&) { return nullptr; }

std::unique_ptr<Tracker> make_vofod_tracker(const ModuleConfig& config, const AgentSetup&) {
  const auto& c = dynamic_cast<const VofodTrackerConfig&>(config);
  return std::make_unique<CloudTrackerModule>(c.sensor, c.tracker, make_kalman_filter(c.filter));
}

std::unique_ptr<Tracker> make_imm_tracker(const ModuleConfig& config, const AgentSetup&) {
  const auto& c = dynamic_cast<const ImmTrackerConfig&>(config);
  return std::make_unique<CloudTrackerModule>(c.sensor, c.tracker, make_imm_filter(c.filter));
}

std::unique_ptr<Tracker> make_detector_tracks(const ModuleConfig&, const AgentSetup&) {
  return std::make_unique<DetectorTracks>();
}

std::unique_ptr<Tracker> make_ground_truth_tracker(const ModuleConfig& config, const AgentSetup&) {
  return std::make_unique<GroundTruthTracker>(dynamic_cast<const GroundTruthTrackerConfig&>(config));
}

}  // namespace swiftlet
