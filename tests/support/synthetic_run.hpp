// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <filesystem>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "swiftlet/core/messages/kind.hpp"
#include "swiftlet/core/messages/neighbor_position.hpp"
#include "swiftlet/sim/metrics/detection_score.hpp"
#include "swiftlet/sim/recording/recorder.hpp"
#include "swiftlet/sim/recording/series.hpp"
#include "swiftlet/sim/world/labeled_scan.hpp"
#include "swiftlet/sim/world/vehicle_state.hpp"

namespace swiftlet::sim {

/// A series over the whole run, as a user-defined metric may have it.
struct TeamSpread {
  static constexpr const char* kName = "spread";
  TimeNs t = 0;
  double spread_m = 0.0;

  static void visit(auto& s, auto& v) {
    v.time("t_s", s.t, "[s] of the tick");
    v.field("spread_m", s.spread_m, "[m] greatest distance between two vehicles");
  }
};

/// Voxels of every vehicle of a SyntheticRun; the first one is of a known world.
inline std::vector<MapVoxels> made_up_maps() {
  std::vector<MapVoxels> maps;
  maps.push_back({"detector", 0.25, {"free", "uncertain", "tentative", "confident"}, 2, {}, {}, {}});
  for (int i = 0; i < 40; ++i) {
    const float value = i == 0 ? std::numeric_limits<float>::infinity() : -25.5F * static_cast<float>(i);
    maps.back().add({0.25 * i + 0.125, -0.125, 1e-3 * i}, static_cast<std::uint8_t>(3 - i / 10), value);
  }
  maps.push_back({"mapping", 0.2, {"free", "occupied"}, 1, {}, {}, {}});
  maps.back().add({1.1, 2.3, -0.7}, 1, 3.25F);
  maps.back().add({1.3, 2.3, -0.7}, 0, -0.5F);
  return maps;
}

/// Returns those maps and does nothing else.
class MapKeeper : public Agent {
 public:
  const Action& step(const Observation&) override { return action_; }
  void append_maps(std::vector<MapVoxels>& maps) const override { maps = made_up_maps(); }

 private:
  Action action_;
};

/// Ticks with synthetic content for tests of recorders: every field has a distinct value, none is round. Two vehicles:
/// "uav1" with a LiDAR "os1" (8 x 16), "uav-2" with "mid360" (4 x 30) and "puck" (16 x 12, rows in succession). Every
/// second scan is frozen. A tick every 10 ms; a scan of each LiDAR every 100 ms; GNSS every 50 ms; the estimate is
/// valid from 50 ms on.
class SyntheticRun {
 public:
  static constexpr TimeNs kTick = 10'000'000;

  explicit SyntheticRun(std::filesystem::path directory, TimeNs start_time = 0) {
    info_.directory = std::move(directory);
    info_.start_time = start_time;
    std::filesystem::create_directories(info_.directory);
    info_.vehicle_names = {"uav1", "uav-2"};
    info_.series = {&scores_, &team_};
    airframe_.rotors.resize(4);
    for (std::size_t i = 0; i < info_.vehicle_names.size(); ++i) {
      info_.airframes.push_back(&airframe_);
      info_.vehicle_shapes.push_back(nullptr);
      action_pointers_.push_back(&actions_[i]);
      agents_.push_back(std::make_unique<MapKeeper>());
    }
    ouster_ = make_beams(8, 16);
    livox_ = make_beams(4, 30);
    auto velodyne = std::make_shared<BeamTable>(*make_beams(16, 12));
    for (int row = 0; row < 16; ++row) velodyne->row_offset_s.push_back(2e-6F * static_cast<float>(row * 7 % 16));
    velodyne_ = velodyne;
  }

  const RunInfo& info() const { return info_; }
  const SeriesOf<DetectionScore>& scores() const { return scores_; }

  /// The k-th tick, at k * kTick; valid until the next call.
  const TickView& tick(int k) {
    view_ = {};
    events_.clear();
    view_.t = k * kTick;
    for (VehicleId v = 0; v < 2; ++v) {
      fill_state(v);
      fill_observation(v, k);
      fill_action(v);
      fill_scans(v, k);
      clearance_[v] = number();
    }
    fill_scores();
    if (k == 7) events_.push_back({view_.t, "crash", 1, "trunk \"17\"", vector(), "motors\nstopped"});
    if (k == 9) events_.push_back({view_.t, "end", kNoVehicle, "", Vector3::Zero(), "time is up"});
    view_.states = states_;
    view_.observations = observations_;
    view_.actions = action_pointers_;
    view_.scans = scans_;
    view_.events = events_;
    view_.clearance_m = clearance_;
    view_.agents = agents_;
    return view_;
  }

  /// A number between -5 and 5, different in each call: the golden-ratio sequence.
  double number() {
    phase_ += 0.6180339887498949;
    phase_ -= static_cast<int>(phase_);
    return 10.0 * phase_ - 5.0;
  }

  std::shared_ptr<LabeledScan> make_scan(const std::string& sensor, std::shared_ptr<const BeamTable> beams,
                                         TimeNs stamp, bool rolling) {
    auto labeled = std::make_shared<LabeledScan>();
    Scan& scan = labeled->scan;
    scan.sensor = sensor;
    scan.stamp = stamp;
    scan.duration = rolling ? 100'000'000 : 0;
    scan.T_body_lidar = pose();
    scan.beams = std::move(beams);
    for (int i = 0; i < scan.size(); ++i) {
      const bool hit = i % 5 != 3;
      scan.range_m.push_back(hit ? static_cast<float>(10.0 + number()) : 0.0F);
      scan.intensity.push_back(hit ? static_cast<float>(6.0 + number()) : 0.0F);
      // Mostly diffuse, some retro-reflective.
      scan.reflectivity.push_back(hit ? static_cast<float>(i % 7 == 0 ? 50.0 + 9 * number() : 0.5 + 0.09 * number())
                                      : 0.0F);
      labeled->truth.range_m.push_back(static_cast<float>(10.0 + number()));
      labeled->truth.incidence_rad.push_back(static_cast<float>(0.7 + 0.1 * number()));
      labeled->truth.surface_class.push_back(static_cast<std::uint16_t>(40 + i % 300));
      labeled->truth.instance.push_back(static_cast<std::uint16_t>(1000 + i));
      labeled->truth.part.push_back(static_cast<std::uint8_t>(i % 7));
    }
    const int num_poses = rolling ? scan.cols() : 1;
    for (int column = 0; column < num_poses; ++column) labeled->truth.T_world_lidar.push_back(pose());
    return labeled;
  }

  std::shared_ptr<const BeamTable> make_beams(int rows, int cols) {
    auto beams = std::make_shared<BeamTable>();
    beams->rows = rows;
    beams->cols = cols;
    for (int i = 0; i < rows * cols; ++i) {
      beams->directions_lidar.push_back(vector().normalized().cast<float>());
      beams->origins_lidar.push_back((0.01 * vector()).cast<float>());
    }
    for (int column = 0; column < cols; ++column) {
      beams->column_offset_s.push_back(0.1F * static_cast<float>(column) / static_cast<float>(cols));
    }
    return beams;
  }

 private:
  // One call per statement, because C++ does not define the order in which arguments are evaluated.
  Vector3 vector() {
    Vector3 v;
    for (int i = 0; i < 3; ++i) v[i] = number();
    return v;
  }
  Eigen::Quaterniond rotation() {
    Eigen::Quaterniond q;
    for (int i = 0; i < 4; ++i) q.coeffs()[i] = number();
    return q.normalized();
  }
  Pose pose() {
    const Vector3 position = vector();
    return make_pose(position, rotation());
  }
  Matrix3 covariance() {
    Matrix3 m;
    for (int i = 0; i < 9; ++i) m(i) = number();
    return m * m.transpose();
  }

  void fill_state(VehicleId v) {
    VehicleState& state = states_[v];
    state.t = view_.t;
    state.p_world_m = vector();
    state.q_world_body = rotation();
    state.v_world_mps = vector();
    state.omega_body_radps = vector();
    for (double& speed : state.rotor_speed_radps) speed = 500.0 + number();
    state.crashed = v == 1 && view_.t >= 7 * kTick;
  }

  void fill_observation(VehicleId v, int k) {
    Observation& o = observations_[v];
    o.clear();
    o.t = view_.t;
    o.self = v;
    for (int i = 0; i < 2; ++i) {
      const Vector3 omega = vector();
      o.imu.push_back({view_.t - (1 - i) * kTick / 2, omega, vector()});
    }
    const Pose local = pose();
    o.odometry.push_back({view_.t, local, vector()});
    if (k % 5 == 0) {
      GnssSample& sample = o.gnss.emplace_back();
      sample.t = view_.t;
      sample.p_world_m = 100.0 * vector();
      sample.v_world_mps = vector();
      sample.sigma_p_m = vector().cwiseAbs();
      sample.sigma_v_mps = vector().cwiseAbs();
    }
    o.altimeter.push_back({view_.t, 6.0 + number(), 0.1});
    o.compass.push_back({view_.t, 0.5 * number(), 0.02});
    const Pose reported = pose();
    const Vector3 velocity = vector();
    o.pose.push_back({view_.t, reported, velocity, vector()});
    const Vector3 seen = vector();
    o.neighbors.push_back({view_.t, 1 - v, seen, covariance()});
    Message& message = o.messages.emplace_back();
    message.from = 1 - v;
    message.sent = view_.t - kTick;
    message.received = view_.t - kTick / 3;
    write_message(NeighborPosition{view_.t - kTick, vector()}, message);
    if (k % 3 == 0) message.version = 99;  // a later version of the message
  }

  void fill_action(VehicleId v) {
    Action& action = actions_[v];
    action.clear_outputs();
    StateEstimate& estimate = action.estimate;
    estimate.valid = view_.t >= 5 * kTick;
    estimate.t = view_.t;
    estimate.T_local_body = pose();
    estimate.v_local_mps = vector();
    estimate.omega_body_radps = vector();
    estimate.covariance.topLeftCorner<3, 3>() = covariance();
    estimate.covariance.bottomRightCorner<3, 3>() = covariance();
    action.reference.position_m = vector();
    action.reference.velocity_mps = vector();
    action.reference.acceleration_mps2 = vector();
    action.reference.yaw_rad = number();
    action.reference.yaw_rate_radps = number();
    action.has_detections = true;
    action.detections_stamp = view_.t - 2 * kTick;
    Detection& detection = action.detections.emplace_back();
    detection.t = view_.t - kTick;
    detection.position_m = vector();
    detection.covariance = covariance();
    detection.extent_m = vector().cwiseAbs();
    detection.num_points = 17;
    detection.confidence = 0.75;
    RelativeEstimate& relative = action.relatives.emplace_back();
    relative.t = view_.t;
    relative.other = v;
    relative.position_m = vector();
    relative.velocity_mps = vector();
    relative.yaw_rad = number();
    action.has_tracks = view_.t % (2 * kTick) == 0;
    action.tracks.resize(1);
    Track& track = action.tracks[0];
    track.id = 3;
    track.t = view_.t;
    track.position_m = vector();
    track.velocity_mps = vector();
    track.acceleration_mps2 = vector();
    track.covariance.topLeftCorner<3, 3>() = covariance();
    track.num_detections = 4;
    track.corrected = true;
  }

  /// Each vehicle's detections of the other vehicle, and a false estimate of its tracker.
  void fill_scores() {
    scores_.clear();
    team_.clear();
    team_.push(kNoVehicle, {view_.t, number()});
    for (VehicleId v = 0; v < 2; ++v) {
      for (const bool is_false : {false, true}) {
        DetectionScore score;
        score.t = view_.t - kTick;
        score.stage = is_false ? DetectionScore::Stage::kTracker : DetectionScore::Stage::kDetector;
        score.target = is_false ? kNoVehicle : 1 - v;
        score.distance_m = 20.0 + number();
        score.visible_points = is_false ? -1 : 12;
        score.found = !is_false;
        score.track_id = is_false ? 7 : 0;
        score.position_error_m = number();
        score.speed_error_mps = number();
        score.direction_error_rad = number();
        score.nees = number();
        score.latency_s = number();
        scores_.push(v, score);
      }
    }
  }

  void fill_scans(VehicleId v, int k) {
    scans_[v].clear();
    if (k % 10 != 0 || k == 0) return;
    const TimeNs stamp = view_.t - 100'000'000;
    const bool rolling = k % 20 != 0;
    if (v == 0) {
      scans_[v].push_back(make_scan("os1", ouster_, stamp, rolling));
    } else {
      scans_[v].push_back(make_scan("mid360", livox_, stamp, rolling));
      scans_[v].push_back(make_scan("puck", velodyne_, stamp, rolling));
    }
  }

  RunInfo info_;
  Airframe airframe_;
  std::shared_ptr<const BeamTable> ouster_, livox_, velodyne_;
  std::array<VehicleState, 2> states_;
  std::array<Observation, 2> observations_;
  std::array<Action, 2> actions_;
  std::vector<const Action*> action_pointers_;
  std::array<std::vector<std::shared_ptr<const LabeledScan>>, 2> scans_;
  std::array<double, 2> clearance_{};
  std::vector<Event> events_;
  SeriesOf<DetectionScore> scores_;
  SeriesOf<TeamSpread> team_;
  std::vector<std::unique_ptr<Agent>> agents_;
  TickView view_;
  double phase_ = 0.0;
};

}  // namespace swiftlet::sim
