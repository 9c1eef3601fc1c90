// SPDX-License-Identifier: BSD-3-Clause
// Usage: write_recordings DIR. Records a synthetic run with every recorder, and writes the recorded values to
// DIR/expected.json. The independent readers in this folder compare the recordings with them.
#include <cmath>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>

#include "swiftlet/sim/recorders/csv.hpp"
#include "swiftlet/sim/recorders/map.hpp"
#include "swiftlet/sim/recorders/mcap.hpp"
#include "swiftlet/sim/recorders/pcd.hpp"
#include "swiftlet/sim/recorders/ply.hpp"
#include "swiftlet/sim/recorders/rosbag.hpp"
#include "swiftlet/sim/registry/recorders.hpp"
#include "tests/support/synthetic_run.hpp"

namespace swiftlet::sim {
namespace {

using nlohmann::json;

json json_of(const Vector3& v) { return {v.x(), v.y(), v.z()}; }
json json_of(const Eigen::Quaterniond& q) { return {q.x(), q.y(), q.z(), q.w()}; }
json json_of(const Pose& pose) {
  return {{"p", json_of(Vector3(pose.translation()))}, {"q", json_of(Eigen::Quaterniond(pose.linear()))}};
}
template <class Derived>
json json_of_matrix(const Eigen::MatrixBase<Derived>& m) {
  json values = json::array();
  for (int i = 0; i < m.rows(); ++i) {
    for (int j = 0; j < m.cols(); ++j) values.push_back(m(i, j));
  }
  return values;
}

json json_of(const LabeledScan& labeled) {
  const Scan& scan = labeled.scan;
  json out{{"sensor", scan.sensor},
           {"stamp_ns", scan.stamp},
           {"duration_ns", scan.duration},
           {"rows", scan.rows()},
           {"cols", scan.cols()},
           {"T_body_lidar", json_of(scan.T_body_lidar)},
           {"range", scan.range_m},
           {"intensity", scan.intensity},
           {"reflectivity", scan.reflectivity},
           {"range_true", labeled.truth.range_m},
           {"incidence", labeled.truth.incidence_rad},
           {"class", labeled.truth.surface_class},
           {"instance", labeled.truth.instance},
           {"part", labeled.truth.part},
           {"column_offset_s", scan.beams->column_offset_s}};
  out["row_offset_s"] = scan.beams->row_offset_s;
  if (scan.beams->row_offset_s.empty()) out["row_offset_s"] = std::vector<float>(scan.rows(), 0.0F);
  for (int i = 0; i < scan.size(); ++i) {
    out["directions"].push_back(json_of(Vector3(scan.beams->directions_lidar[i].cast<double>())));
    out["origins"].push_back(json_of(Vector3(scan.beams->origins_lidar[i].cast<double>())));
  }
  for (const Pose& pose : labeled.truth.T_world_lidar) out["T_world_lidar"].push_back(json_of(pose));
  return out;
}

json json_of(const TickView& tick, const SeriesOf<DetectionScore>& scores, int vehicle) {
  const VehicleState& state = tick.states[vehicle];
  const Observation& observation = tick.observations[vehicle];
  const Action& action = *tick.actions[vehicle];
  json out{{"p", json_of(state.p_world_m)},
           {"q", json_of(state.q_world_body)},
           {"v", json_of(state.v_world_mps)},
           {"omega", json_of(state.omega_body_radps)},
           {"rotors",
            {state.rotor_speed_radps[0], state.rotor_speed_radps[1], state.rotor_speed_radps[2],
             state.rotor_speed_radps[3]}},
           {"clearance", tick.clearance_m[vehicle]}};
  const StateEstimate& estimate = action.estimate;
  out["estimate"] = {{"valid", estimate.valid},
                     {"t_ns", estimate.t},
                     {"pose", json_of(estimate.T_local_body)},
                     {"correction", json_of(estimate.T_world_local)},
                     {"v", json_of(estimate.v_local_mps)},
                     {"omega", json_of(estimate.omega_body_radps)},
                     {"covariance", json_of_matrix(estimate.covariance)}};
  for (const auto& s : observation.imu) {
    out["imu"].push_back(
        {{"t_ns", s.t}, {"omega", json_of(s.omega_body_radps)}, {"f", json_of(s.specific_force_body_mps2)}});
  }
  for (const auto& s : observation.odometry) {
    out["odometry"].push_back({{"t_ns", s.t}, {"pose", json_of(s.T_local_body)}, {"v", json_of(s.v_local_body_mps)}});
  }
  out["gnss"] = json::array();
  for (const auto& s : observation.gnss) {
    out["gnss"].push_back({{"t_ns", s.t}, {"p", json_of(s.p_world_m)}, {"sigma", json_of(s.sigma_p_m)}});
  }
  const NeighborSample& neighbor = observation.neighbors.front();
  out["neighbor"] = {
      {"id", neighbor.id}, {"p", json_of(neighbor.p_body_m)}, {"covariance", json_of_matrix(neighbor.covariance_body)}};
  const Track& track = action.tracks.front();
  out["track"] = {{"written", action.has_tracks},
                  {"t_ns", track.t},
                  {"id", track.id},
                  {"p", json_of(track.position_m)},
                  {"v", json_of(track.velocity_mps)},
                  {"covariance", json_of_matrix(track.covariance.topLeftCorner<3, 3>())}};
  const Detection& detection = action.detections.front();
  out["detection"] = {{"t_ns", detection.t},
                      {"p", json_of(detection.position_m)},
                      {"covariance", json_of_matrix(detection.covariance)},
                      {"extent", json_of(detection.extent_m)},
                      {"points", detection.num_points},
                      {"confidence", detection.confidence}};
  out["scores"] = json::array();
  for (std::size_t i = 0; i < scores.size(); ++i) {
    const DetectionScore& score = scores.rows()[i];
    if (scores.about(i) != vehicle) continue;
    out["scores"].push_back(
        {{"t_ns", score.t},
         {"stage", score.stage == DetectionScore::Stage::kDetector ? "detector" : "tracker"},
         {"target", score.target},
         {"numbers",
          {score.distance_m, score.visible_points, score.found ? 1 : 0, score.track_id, score.position_error_m,
           score.speed_error_mps, score.direction_error_rad, score.nees, score.latency_s}}});
  }
  out["scans"] = json::array();
  for (const auto& scan : tick.scans[vehicle]) out["scans"].push_back(json_of(*scan));
  return out;
}

template <class Config>
Module module_of(const char* type, Config config) {
  Module module(recorder_module_types(), type);
  module.as<Config>() = config;
  return module;
}

json json_of(const MapVoxels& map) {
  json out{{"name", map.name}, {"edge", map.edge_m}, {"occupied_from", map.occupied_from}, {"voxels", json::array()}};
  for (std::size_t i = 0; i < map.size(); ++i) {
    const Eigen::Vector3f& at = map.centers_local_m[i];
    const json value = std::isinf(map.value[i]) ? json("inf") : json(map.value[i]);
    out["voxels"].push_back({at.x(), at.y(), at.z(), map.state[i], value});
  }
  return out;
}

std::vector<Module> every_recorder() {
  MapConfig map;
  map.times_s = {0.2, 0.05};
  MapConfig occupied_map;
  occupied_map.vehicles = {"uav1"};
  occupied_map.maps = {"detector"};
  occupied_map.voxels = MapConfig::Voxels::kOccupied;
  occupied_map.format = MapConfig::Format::kPcd;
  MapConfig octree;
  octree.format = MapConfig::Format::kOt;
  MapConfig binary_octree;
  binary_octree.format = MapConfig::Format::kBt;
  CsvConfig csv;
  csv.rate_hz = 0;
  csv.topics = {"state",     "imu",        "gnss",   "odometry", "altimeter",        "compass",
                "neighbors", "detections", "tracks", "scores",   "message_neighbor", "spread"};
  PcdConfig pcd_lidar;
  pcd_lidar.organized = true;
  pcd_lidar.folder = "scans_organized";
  PcdConfig pcd_world;
  pcd_world.frame = ScanFilesConfig::Frame::kWorld;
  PlyConfig ply;
  ply.frame = ScanFilesConfig::Frame::kWorld;
  McapConfig mcap;
  mcap.datum_deg = {49.363, 14.261};
  mcap.datum_altitude_m = 470.0;
  McapConfig plain_mcap = mcap;
  plain_mcap.compression = McapConfig::Compression::kNone;
  plain_mcap.file = "plain.mcap";
  RosbagConfig bag;
  bag.datum_deg = mcap.datum_deg;
  bag.datum_altitude_m = mcap.datum_altitude_m;
  RosbagConfig plain_bag = bag;
  plain_bag.compression = RosbagConfig::Compression::kNone;
  plain_bag.file = "plain.bag";
  McapConfig rows_mcap;  // topics without a standard ROS message type
  rows_mcap.topics = {"altimeter", "compass", "neighbors", "scores", "messages", "events", "spread"};
  rows_mcap.file = "rows.mcap";
  RosbagConfig rows_bag;
  rows_bag.topics = rows_mcap.topics;
  rows_bag.file = "rows.bag";
  return {Module(recorder_module_types(), "tum"),
          Module(recorder_module_types(), "events"),
          module_of("csv", csv),
          module_of("pcd", pcd_lidar),
          module_of("pcd", pcd_world),
          module_of("ply", ply),
          module_of("map", map),
          module_of("map", occupied_map),
          module_of("map", octree),
          module_of("map", binary_octree),
          module_of("mcap", mcap),
          module_of("mcap", plain_mcap),
          module_of("rosbag", bag),
          module_of("mcap", rows_mcap),
          module_of("rosbag", plain_bag),
          module_of("rosbag", rows_bag)};
}

void write_recordings(const std::filesystem::path& directory) {
  std::filesystem::remove_all(directory);
  SyntheticRun run(directory);
  std::vector<std::unique_ptr<Recorder>> recorders;
  for (const Module& module : every_recorder()) {
    recorders.push_back(make_recorder(module));
    recorders.back()->begin(run.info());
  }
  json expected{{"vehicles", run.info().vehicle_names}, {"datum", {49.363, 14.261, 470.0}}};
  for (int k = 0; k <= 30; ++k) {
    const TickView& tick = run.tick(k);
    for (auto& recorder : recorders) recorder->write(tick);
    json out{{"t_ns", tick.t}, {"events", json::array()}};
    for (const Event& event : tick.events) {
      out["events"].push_back({{"kind", event.kind},
                               {"vehicle", event.vehicle},
                               {"partner", event.partner},
                               {"p", json_of(event.p_world_m)},
                               {"note", event.note}});
    }
    for (int v = 0; v < 2; ++v) out["vehicles"].push_back(json_of(tick, run.scores(), v));
    expected["ticks"].push_back(out);
  }
  for (const MapVoxels& map : made_up_maps()) expected["maps"].push_back(json_of(map));
  for (auto& recorder : recorders) {
    for (const auto& path : recorder->finish()) expected["paths"].push_back(path.string());
  }
  std::ofstream(directory / "expected.json") << expected.dump();
}

}  // namespace
}  // namespace swiftlet::sim

int main(int argc, char** argv) {
  if (argc != 2) {
    std::cerr << "usage: write_recordings DIR\n";
    return 2;
  }
  swiftlet::sim::write_recordings(argv[1]);
}
