// SPDX-License-Identifier: BSD-3-Clause
#include "sim/recorders/csv.hpp"

#include <algorithm>
#include <limits>

#include "sim/io/output_file.hpp"
#include "sim/io/text_row.hpp"
#include "sim/recorders/selection.hpp"
#include "sim/world/vehicle_state.hpp"

namespace swiftlet::sim {
namespace {

constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();

/// What one row is made from.
struct Source {
  const TickView& tick;
  VehicleId vehicle;
  int num_rotors;
  const std::vector<std::string>& names;
  TextRow& row;
  OutputFile& file;

  const VehicleState& state() const { return tick.states[vehicle]; }
  const Observation& observation() const { return tick.observations[vehicle]; }
  const Action* action() const { return tick.actions[vehicle]; }
  TextRow& begin_row(TimeNs t) const {
    row.clear();
    return row.add_seconds(t);
  }
  void end_row() const { file.append(row.line()); }
};

void add_rotation(TextRow& row, const Matrix3& R) { row.add(Eigen::Quaterniond(R).coeffs()); }

/// Upper triangle, row by row.
template <int N>
void add_covariance(TextRow& row, const Eigen::Matrix<double, N, N>& covariance) {
  for (int i = 0; i < N; ++i) {
    for (int j = i; j < N; ++j) row.add(covariance(i, j));
  }
}

void write_state(const Source& source) {
  const VehicleState& state = source.state();
  TextRow& row = source.begin_row(source.tick.t);
  row.add(state.p_world_m).add(state.q_world_body.coeffs()).add(state.v_world_mps).add(state.omega_body_radps);
  row.add(static_cast<int>(state.crashed));
  row.add(source.tick.clearance_m.empty() ? kMissing : source.tick.clearance_m[source.vehicle]);
  const Action* action = source.action();
  if (action && action->estimate.valid) {
    const StateEstimate& estimate = action->estimate;
    row.add_seconds(estimate.t).add(estimate.T_world_body.translation());
    add_rotation(row, estimate.T_world_body.linear());
    row.add(estimate.v_world_mps).add(estimate.omega_body_radps);
  } else {
    for (int i = 0; i < 14; ++i) row.add(kMissing);
  }
  const Reference reference = action ? action->reference : Reference{};
  row.add(reference.position_m).add(reference.velocity_mps).add(reference.acceleration_mps2);
  row.add(reference.yaw_rad).add(reference.yaw_rate_radps);
  for (int i = 0; i < source.num_rotors; ++i) row.add(state.rotor_speed_radps[i]);
  source.end_row();
}

void write_imu(const Source& source) {
  for (const ImuSample& sample : source.observation().imu) {
    source.begin_row(sample.t).add(sample.omega_body_radps).add(sample.specific_force_body_mps2);
    source.end_row();
  }
}

void write_gnss(const Source& source) {
  for (const GnssSample& sample : source.observation().gnss) {
    TextRow& row = source.begin_row(sample.t);
    row.add(sample.p_world_m).add(sample.v_world_mps).add(sample.sigma_p_m).add(sample.sigma_v_mps);
    source.end_row();
  }
}

void write_odometry(const Source& source) {
  for (const OdometrySample& sample : source.observation().odometry) {
    TextRow& row = source.begin_row(sample.t).add(sample.T_local_body.translation());
    add_rotation(row, sample.T_local_body.linear());
    row.add(sample.v_local_body_mps);
    source.end_row();
  }
}

void write_altimeter(const Source& source) {
  for (const AltimeterSample& sample : source.observation().altimeter) {
    source.begin_row(sample.t).add(sample.height_m).add(sample.sigma_m);
    source.end_row();
  }
}

void write_compass(const Source& source) {
  for (const CompassSample& sample : source.observation().compass) {
    source.begin_row(sample.t).add(sample.yaw_rad).add(sample.sigma_rad);
    source.end_row();
  }
}

void write_pose(const Source& source) {
  for (const PoseSample& sample : source.observation().pose) {
    TextRow& row = source.begin_row(sample.t).add(sample.T_world_body.translation());
    add_rotation(row, sample.T_world_body.linear());
    row.add(sample.v_world_mps).add(sample.omega_body_radps);
    source.end_row();
  }
}

void write_neighbors(const Source& source) {
  for (const NeighborSample& sample : source.observation().neighbors) {
    TextRow& row = source.begin_row(sample.t);
    row.add(sample.id == kNoVehicle ? std::string_view() : std::string_view(source.names[sample.id]));
    row.add(sample.p_body_m);
    add_covariance<3>(row, sample.covariance_body);
    source.end_row();
  }
}

void write_detections(const Source& source) {
  if (!source.action()) return;
  for (const Detection& detection : source.action()->detections) {
    TextRow& row = source.begin_row(detection.t).add(detection.position_m);
    add_covariance<3>(row, detection.covariance);
    row.add(detection.extent_m).add(detection.num_points).add(detection.confidence);
    source.end_row();
  }
}

void write_tracks(const Source& source) {
  if (!source.action() || !source.action()->has_tracks) return;
  for (const Track& track : source.action()->tracks) {
    TextRow& row = source.begin_row(track.t).add(track.id);
    row.add(track.position_m).add(track.velocity_mps).add(track.acceleration_mps2);
    add_covariance<3>(row, track.covariance.topLeftCorner<3, 3>());
    row.add(track.num_detections).add(static_cast<int>(track.corrected));
    source.end_row();
  }
}

void write_scores(const Source& source) {
  for (const DetectionScore& score : source.tick.detection_scores) {
    if (score.observer != source.vehicle) continue;
    TextRow& row = source.begin_row(score.t);
    row.add(std::string_view(score.stage == DetectionScore::Stage::kDetector ? "detector" : "tracker"));
    row.add(score.target == kNoVehicle ? std::string_view() : std::string_view(source.names[score.target]));
    row.add(score.distance_m).add(score.visible_points).add(static_cast<int>(score.found)).add(score.track_id);
    row.add(score.position_error_m).add(score.speed_error_mps).add(score.direction_error_rad);
    row.add(score.nees).add(score.latency_s);
    source.end_row();
  }
}

struct Topic {
  const char* name;
  bool sampled;  ///< written at rate_hz; the others as they come
  const char* header;
  void (*write)(const Source& source);
};

#define COVARIANCE3 "cov_xx_m2,cov_xy_m2,cov_xz_m2,cov_yy_m2,cov_yz_m2,cov_zz_m2"
constexpr Topic kTopics[] = {
    {"state", true,
     "t_s,x_m,y_m,z_m,qx,qy,qz,qw,vx_mps,vy_mps,vz_mps,omega_x_radps,omega_y_radps,omega_z_radps,crashed,clearance_m,"
     "est_t_s,est_x_m,est_y_m,est_z_m,est_qx,est_qy,est_qz,est_qw,est_vx_mps,est_vy_mps,est_vz_mps,"
     "est_omega_x_radps,est_omega_y_radps,est_omega_z_radps,"
     "ref_x_m,ref_y_m,ref_z_m,ref_vx_mps,ref_vy_mps,ref_vz_mps,ref_ax_mps2,ref_ay_mps2,ref_az_mps2,ref_yaw_rad,"
     "ref_yaw_rate_radps",
     write_state},
    {"imu", false, "t_s,omega_x_radps,omega_y_radps,omega_z_radps,f_x_mps2,f_y_mps2,f_z_mps2", write_imu},
    {"gnss", false,
     "t_s,x_m,y_m,z_m,vx_mps,vy_mps,vz_mps,sigma_x_m,sigma_y_m,sigma_z_m,sigma_vx_mps,sigma_vy_mps,sigma_vz_mps",
     write_gnss},
    {"odometry", false, "t_s,x_m,y_m,z_m,qx,qy,qz,qw,vx_mps,vy_mps,vz_mps", write_odometry},
    {"altimeter", false, "t_s,height_m,sigma_m", write_altimeter},
    {"compass", false, "t_s,yaw_rad,sigma_rad", write_compass},
    {"pose", false, "t_s,x_m,y_m,z_m,qx,qy,qz,qw,vx_mps,vy_mps,vz_mps,omega_x_radps,omega_y_radps,omega_z_radps",
     write_pose},
    {"neighbors", false, "t_s,neighbor,x_body_m,y_body_m,z_body_m," COVARIANCE3, write_neighbors},
    {"detections", false, "t_s,x_m,y_m,z_m," COVARIANCE3 ",extent_x_m,extent_y_m,extent_z_m,num_points,confidence",
     write_detections},
    {"tracks", false,
     "t_s,id,x_m,y_m,z_m,vx_mps,vy_mps,vz_mps,ax_mps2,ay_mps2,az_mps2," COVARIANCE3 ",num_detections,corrected",
     write_tracks},
    {"scores", false,
     "t_s,stage,target,distance_m,visible_points,found,id,position_error_m,speed_error_mps,direction_error_rad,nees,"
     "latency_s",
     write_scores},
};
#undef COVARIANCE3

const Topic* find_topic(const std::string& name) {
  const auto found =
      std::find_if(std::begin(kTopics), std::end(kTopics), [&](const Topic& t) { return name == t.name; });
  return found == std::end(kTopics) ? nullptr : found;
}

std::string topic_names() {
  std::string names;
  for (const Topic& topic : kTopics) names += (names.empty() ? "" : ", ") + std::string(topic.name);
  return names;
}

class CsvRecorder : public Recorder {
 public:
  explicit CsvRecorder(CsvConfig config) : config_(std::move(config)), gate_(config_.rate_hz) {}

  void begin(const RunInfo& info) override {
    names_ = info.vehicle_names;
    const std::vector<bool> selected = select_vehicles(config_.vehicles, names_);
    for (std::size_t i = 0; i < selected.size(); ++i) {
      if (!selected[i]) continue;
      const int num_rotors = info.airframes[i]->num_rotors();
      for (const Topic& topic : kTopics) {
        if (config_.topics.empty() || !selects(config_.topics, topic.name)) continue;
        const std::string name = "csv/" + names_[i] + "/" + topic.name + ".csv";
        tables_.push_back({static_cast<VehicleId>(i), num_rotors, &topic, OutputFile(info.directory / name)});
        tables_.back().file.append(header_of(topic, num_rotors));
        paths_.push_back(name);
      }
    }
  }

  void write(const TickView& tick) override {
    const bool sample = gate_.due(tick.t);
    for (Table& table : tables_) {
      if (table.topic->sampled && !sample) continue;
      table.topic->write({tick, table.vehicle, table.num_rotors, names_, row_, table.file});
    }
  }

  std::vector<std::filesystem::path> finish() override {
    for (Table& table : tables_) table.file.finish();
    return paths_;
  }

 private:
  struct Table {
    VehicleId vehicle;
    int num_rotors;
    const Topic* topic;
    OutputFile file;
  };

  static std::string header_of(const Topic& topic, int num_rotors) {
    std::string header = topic.header;
    for (int i = 0; topic.write == write_state && i < num_rotors; ++i) {
      header += ",rotor" + std::to_string(i) + "_radps";
    }
    return header + "\n";
  }

  CsvConfig config_;
  RateGate gate_;
  std::vector<std::string> names_;
  std::vector<Table> tables_;
  std::vector<std::filesystem::path> paths_;
  TextRow row_{','};
};

}  // namespace

void CsvConfig::visit(ConfigVisitor& v) {
  v.field("vehicles", vehicles, "[-] names of the vehicles to write; empty: all");
  v.field("rate_hz", rate_hz, "[Hz] rows of the topic state a second; 0: every tick", Range::non_negative());
  v.field("topics", topics,
          "[-] tables to write: state (truth, estimate, reference, rotors), imu, gnss, odometry, altimeter, compass, "
          "pose, neighbors, detections, tracks, scores (of detections and tracks, against the truth)");
  const bool known = std::all_of(topics.begin(), topics.end(), [](const std::string& t) { return find_topic(t); });
  v.check(known, "topics", "a list of " + topic_names());
}

std::unique_ptr<Recorder> make_csv_recorder(const ModuleConfig& config) {
  return std::make_unique<CsvRecorder>(dynamic_cast<const CsvConfig&>(config));
}

}  // namespace swiftlet::sim
