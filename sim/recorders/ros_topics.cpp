// SPDX-License-Identifier: BSD-3-Clause
#include "sim/recorders/ros_topics.hpp"

#include <algorithm>
#include <type_traits>

#include "sim/recorders/geodesy.hpp"
#include "sim/recorders/ros_markers.hpp"
#include "sim/recorders/ros_points.hpp"
#include "sim/recorders/ros_rows.hpp"
#include "swiftlet/core/messages/kind.hpp"
#include "swiftlet/sim/io/text_row.hpp"
#include "swiftlet/sim/metrics/metrics.hpp"
#include "swiftlet/sim/world/thinned_scene.hpp"

namespace swiftlet::sim {
namespace {

/// All selectable topics.
std::vector<std::string> ros_topic_names() {
  std::vector<std::string> names = {"points", "world",      "models", "truth",     "estimate", "tf",
                                    "clock",  "detections", "tracks", "relatives", "messages", "events"};
  const Observation nothing;
  Observation::each_samples(nothing, [&]<class Sample>(const std::vector<Sample>&) { names.push_back(Sample::kName); });
  for (const TableType& table : sample_tables()) names.push_back(table.name);
  for (TableType& series : series_types()) names.push_back(std::move(series.name));
  return names;
}

// Constants of sensor_msgs/NavSatStatus and NavSatFix.
constexpr std::int8_t kStatusFix = 0;
constexpr std::uint16_t kServiceGps = 1;
constexpr std::uint8_t kCovarianceDiagonalKnown = 2;

/// nav_msgs/Odometry; the twist is in body axes, as the message requires.
struct OdometryMessage {
  TimeNs t;
  std::string frame, child_frame;
  Pose T_frame_body;
  Matrix6 pose_covariance = Matrix6::Zero();
  Vector3 v_frame_mps = Vector3::Zero();
  Vector3 omega_body_radps = Vector3::Zero();
};

void encode_odometry(const OdometryMessage& odometry, std::uint32_t sequence, RosEncoder& out) {
  out.begin();
  out.header(sequence, odometry.t, odometry.frame);
  out.text(odometry.child_frame);
  out.pose(odometry.T_frame_body);
  out.row_major(odometry.pose_covariance);
  out.vector3(odometry.T_frame_body.linear().transpose() * odometry.v_frame_mps);
  out.vector3(odometry.omega_body_radps);
  out.row_major(Matrix6::Zero());
}

/// Covariance with the rotation in world axes, as nav_msgs/Odometry requires.
Matrix6 covariance_in_world_axes(const StateEstimate& estimate) {
  Matrix6 J = Matrix6::Identity();
  if (estimate.correction_revision > 0) J.topLeftCorner<3, 3>() = estimate.T_world_local.linear();
  J.bottomRightCorner<3, 3>() = estimate.T_world_body().linear();
  return J * estimate.covariance * J.transpose();
}

void encode_transform(std::uint32_t sequence, TimeNs t, const std::string& parent, const std::string& child,
                      const Vector3& position, const Eigen::Quaterniond& rotation, RosEncoder& out) {
  out.header(sequence, t, parent);
  out.text(child);
  out.put_pose(position, rotation);
}

/// Further input of a sample's message.
struct SampleContext {
  std::string local, body;  // frames
  Geodetic datum;
  const std::vector<std::string>& vehicle_names;
};

void encode(const ImuSample& sample, const SampleContext& context, std::uint32_t sequence, RosEncoder& out) {
  out.begin();
  out.header(sequence, sample.t, context.body);
  out.rotation(Eigen::Quaterniond::Identity());
  Matrix3 no_orientation = Matrix3::Zero();
  no_orientation(0, 0) = -1.0;  // "no orientation estimate" by the convention of sensor_msgs/Imu
  out.row_major(no_orientation);
  out.vector3(sample.omega_body_radps);
  out.row_major(Matrix3::Zero());
  out.vector3(sample.specific_force_body_mps2);
  out.row_major(Matrix3::Zero());
}

void encode(const GnssSample& sample, const SampleContext& context, std::uint32_t sequence, RosEncoder& out) {
  const Geodetic position = geodetic_of_world(sample.p_world_m, context.datum);
  out.begin();
  out.header(sequence, sample.t, context.body);
  out.put(kStatusFix);
  out.put(kServiceGps);
  out.put(position.latitude_deg);
  out.put(position.longitude_deg);
  out.put(position.altitude_m);
  out.row_major(Matrix3(sample.sigma_p_m.cwiseAbs2().asDiagonal()));
  out.put(kCovarianceDiagonalKnown);
}

void encode(const OdometrySample& sample, const SampleContext& context, std::uint32_t sequence, RosEncoder& out) {
  encode_odometry(
      {sample.t, context.local, context.body, sample.T_local_body, Matrix6::Zero(), sample.v_local_body_mps}, sequence,
      out);
}

void encode(const PoseSample& sample, const SampleContext& context, std::uint32_t sequence, RosEncoder& out) {
  encode_odometry({sample.t, "world", context.body, sample.T_world_body, Matrix6::Zero(), sample.v_world_mps,
                   sample.omega_body_radps},
                  sequence, out);
}

template <class Sample>
void encode(const Sample& sample, const SampleContext& context, std::uint32_t sequence, RosEncoder& out) {
  RosRow row(out, context.vehicle_names);
  row.begin(sequence, sample.t, context.body);
  put_columns(sample, row);
}

RosType type_of(const ImuSample&) { return kImu; }
RosType type_of(const GnssSample&) { return kNavSatFix; }
RosType type_of(const OdometrySample&) { return kOdometry; }
RosType type_of(const PoseSample&) { return kOdometry; }
template <class Sample>
RosType type_of(const Sample&) {
  return row_type(Sample::kName, columns_of<Sample>());
}

/// True for a valid name in a topic. ROS 2 allows no leading digit.
bool begins_as_topic(const std::string& name) { return !name.empty() && (name[0] < '0' || name[0] > '9'); }

}  // namespace

std::string ros_name(std::string name) {
  for (char& c : name) {
    const bool fine = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
    if (!fine) c = '_';
  }
  return name;
}

std::string expected_ros_name(const std::string& name, std::map<std::string, std::string>& taken) {
  if (!begins_as_topic(name)) return "a name that begins with a letter, because a recorder writes ROS topics";
  const auto [other, is_new] = taken.emplace(ros_name(name), name);
  if (is_new) return "";
  return "a name that differs from " + other->second + " in ROS topics, where both are " + other->first;
}

void RosConfig::visit_common(ConfigVisitor& v) {
  v.field("vehicles", vehicles, "[-] names of the vehicles to write; empty: all");
  v.field("sensors", sensors, "[-] names of the LiDARs to write; empty: all");
  static const std::vector<std::string> names = ros_topic_names();
  static const std::string doc = "[-] topics to write: " + listed(names);
  v.field("topics", topics, doc.c_str());
  const bool known = std::all_of(topics.begin(), topics.end(), [](const std::string& topic) {
    return std::find(names.begin(), names.end(), topic) != names.end();
  });
  v.check(known, "topics", "a list of " + listed(names));
  v.field("rate_hz", rate_hz, "[Hz] rate of truth, estimate, tf and clock; 0: every tick", Range::between(0.0, 1e5));
  v.check(rate_hz == 0.0 || rate_hz >= 1e-3, "rate_hz", "0, or at least 0.001");
  v.field("every", every, "[-] every n-th scan of each LiDAR is written", Range{1, 1e9, false, false});
  v.choice("points_layout", points_layout, {"auto", "ouster", "livox", "velodyne", "small"},
           "[-] point layout of the manufacturer's driver; auto: selected by the rows; small: only returns, as x, y, "
           "z, intensity");
  v.field("points_step_m", points_step_m,
          "[m] step to which coordinates are rounded, for better compression; 0: no rounding",
          Range::between(0.0, 1.0));
  v.field("world_triangles", world_triangles,
          "[-] largest number of triangles of the world; a larger world is coarsened", Range{1000, 1e7, false, false});
  v.field("datum_deg", datum_deg, "[deg] latitude and longitude of the world's origin (WGS 84)",
          Range::between(-180, 180));
  v.check(datum_deg.x() >= -90.0 && datum_deg.x() <= 90.0, "datum_deg", "a latitude within -90..90");
  v.field("datum_altitude_m", datum_altitude_m, "[m] height of the world's origin above the ellipsoid");
}

RosTopics::RosTopics(const RosConfig& config, const RunInfo& info, RosDialect dialect, RosSink& sink)
    : config_(config),
      sink_(sink),
      message_(dialect, info.start_time),
      gate_(config.rate_hz),
      selected_(select_vehicles(config.vehicles, info.vehicle_names)),
      last_estimate_(info.vehicle_names.size(), -1),
      series_(info.series),
      scene_(info.scene),
      vehicle_shapes_(info.vehicle_shapes) {
  for (const std::string& name : info.vehicle_names) names_.push_back(ros_name(name));
}

void RosTopics::write(const TickView& tick) {
  write_solids(tick.t);
  const bool sample = gate_.due(tick.t);
  if (sample && wants("clock")) write_clock(tick.t);
  if (sample && wants("tf")) write_tf(tick);
  for (VehicleId vehicle = 0; vehicle < static_cast<VehicleId>(names_.size()); ++vehicle) {
    if (!selected_[vehicle]) continue;
    if (sample && wants("truth")) write_truth(tick, vehicle);
    if (sample && wants("estimate")) write_estimate(tick, vehicle);
    write_samples(tick, vehicle);
    if (wants("messages")) write_messages(tick, vehicle);
    write_markers(tick, vehicle);
    if (wants("points")) write_scans(tick, vehicle);
  }
  if (wants("events")) write_events(tick);
  write_series(tick);
}

bool RosTopics::wants(const char* topic) const {
  return std::find(config_.topics.begin(), config_.topics.end(), topic) != config_.topics.end();
}

RosTopics::Channel& RosTopics::channel(const std::string& topic, const RosType& type, bool latched) {
  return channel(
      topic, [&type]() -> const RosType& { return type; }, latched);
}

template <class TypeOf>
requires std::is_invocable_v<TypeOf> RosTopics::Channel& RosTopics::channel(const std::string& topic,
                                                                            const TypeOf& type_of, bool latched) {
  const auto found = channels_.find(topic);
  if (found != channels_.end()) return found->second;
  return channels_.emplace(topic, Channel{sink_.add_channel(topic, type_of(), latched)}).first->second;
}

void RosTopics::send(Channel& channel, TimeNs t) {
  sink_.write(channel.id, channel.sequence++, message_.recorded(t), message_.bytes());
}

/// Writes world and vehicles once; latched topics keep them for late subscribers.
void RosTopics::write_solids(TimeNs t) {
  if (solids_written_) return;
  solids_written_ = true;
  if (wants("world") && scene_ != nullptr && !scene_->instances.empty()) {
    Channel& world = channel("/world", kMarkerArray, true);
    encode_world_markers(thinned_scene(*scene_, static_cast<std::size_t>(config_.world_triangles)), t, world.sequence,
                         message_);
    send(world, t);
  }
  for (std::size_t i = 0; i < names_.size(); ++i) {
    if (!selected_[i] || !wants("models") || vehicle_shapes_[i] == nullptr) continue;
    Channel& model = channel("/" + names_[i] + "/model", kMarkerArray, true);
    encode_vehicle_markers(*vehicle_shapes_[i], names_[i] + "/body", t, model.sequence, message_);
    send(model, t);
  }
}

void RosTopics::write_clock(TimeNs t) {
  Channel& clock = channel("/clock", kClock);
  message_.begin();
  message_.time(t);
  send(clock, t);
}

void RosTopics::write_tf(const TickView& tick) {
  Channel& tf = channel("/tf", kTFMessage);
  const auto publishes_frame = [&](std::size_t i) {
    return tick.actions[i] != nullptr && tick.actions[i]->estimate.valid;
  };
  std::size_t count = 0;
  for (std::size_t i = 0; i < names_.size(); ++i) count += selected_[i] ? 1 + publishes_frame(i) : 0;
  message_.begin();
  message_.count(count);
  for (std::size_t i = 0; i < names_.size(); ++i) {
    if (!selected_[i]) continue;
    const VehicleState& state = tick.states[i];
    encode_transform(tf.sequence, tick.t, "world", names_[i] + "/body", state.p_world_m, state.q_world_body, message_);
    if (!publishes_frame(i)) continue;
    const Pose& T_world_local = tick.actions[i]->estimate.T_world_local;
    encode_transform(tf.sequence, tick.t, "world", names_[i] + "/local", T_world_local.translation(),
                     Eigen::Quaterniond(T_world_local.linear()), message_);
  }
  send(tf, tick.t);
}

void RosTopics::write_truth(const TickView& tick, VehicleId vehicle) {
  Channel& truth = channel("/" + names_[vehicle] + "/truth/pose", kPoseStamped);
  const VehicleState& state = tick.states[vehicle];
  message_.begin();
  message_.header(truth.sequence, tick.t, "world");
  message_.put_pose(state.p_world_m, state.q_world_body);
  send(truth, tick.t);
}

void RosTopics::write_estimate(const TickView& tick, VehicleId vehicle) {
  const Action* action = tick.actions[vehicle];
  if (!action || !action->estimate.valid || action->estimate.t == last_estimate_[vehicle]) return;
  const StateEstimate& estimate = action->estimate;
  last_estimate_[vehicle] = estimate.t;
  Channel& topic = channel("/" + names_[vehicle] + "/estimate", kOdometry);
  encode_odometry({estimate.t, "world", names_[vehicle] + "/body", estimate.T_world_body(),
                   covariance_in_world_axes(estimate), estimate.v_world_mps(), estimate.omega_body_radps},
                  topic.sequence, message_);
  send(topic, tick.t);
}

void RosTopics::write_samples(const TickView& tick, VehicleId vehicle) {
  const std::string& name = names_[vehicle];
  const SampleContext context{name + "/local",
                              name + "/body",
                              {config_.datum_deg.x(), config_.datum_deg.y(), config_.datum_altitude_m},
                              names_};
  Observation::each_samples(tick.observations[vehicle], [&]<class Sample>(const std::vector<Sample>& samples) {
    if (samples.empty() || !wants(Sample::kName)) return;
    Channel& topic = channel("/" + name + "/" + Sample::kName, [&] { return type_of(samples.front()); });
    for (const Sample& sample : samples) {
      encode(sample, context, topic.sequence, message_);
      send(topic, tick.t);
    }
  });
  RosRow row(message_, names_);
  for (const auto& samples : tick.observations[vehicle].others) {
    if (samples->size() == 0 || !wants(samples->name())) continue;
    Channel& topic = channel("/" + name + "/" + ros_name(samples->name()),
                             [&] { return row_type(samples->name(), samples->columns()); });
    for (std::size_t i = 0; i < samples->size(); ++i) {
      row.begin(topic.sequence, samples->time_of(i), context.body);
      samples->put(i, row);
      send(topic, tick.t);
    }
  }
}

void RosTopics::write_messages(const TickView& tick, VehicleId vehicle) {
  RosRow row(message_, names_);
  for (const Message& message : tick.observations[vehicle].messages) {
    const MessageKind* kind = find_message_kind(message.topic);
    if (kind == nullptr || kind->read(message, nullptr) != Reading::kDone) continue;
    Channel& topic = channel("/" + names_[vehicle] + "/radio/" + ros_name(message.topic),
                             [&] { return row_type(message.topic + "_message", message_columns(*kind)); });
    row.begin(topic.sequence, message.received, "");
    put_message(*kind, message, row);
    send(topic, tick.t);
  }
}

void RosTopics::write_events(const TickView& tick) {
  RosRow row(message_, names_);
  for (const Event& event : tick.events) {
    if (event.vehicle != kNoVehicle && !selected_[event.vehicle]) continue;
    Channel& topic = channel("/events", [] { return row_type("event", columns_of<Event>()); });
    row.begin(topic.sequence, event.t, "world");
    put_columns(event, row);
    send(topic, tick.t);
  }
}

void RosTopics::write_series(const TickView& tick) {
  RosRow row(message_, names_);
  for (const Series* series : series_) {
    if (!wants(series->name().c_str())) continue;
    for (std::size_t i = 0; i < series->size(); ++i) {
      const VehicleId about = series->about(i);
      if (about != kNoVehicle && !selected_[about]) continue;
      const std::string prefix = about == kNoVehicle ? "" : "/" + names_[about];
      Channel& topic =
          channel(prefix + "/" + ros_name(series->name()), [&] { return row_type(series->name(), series->columns()); });
      row.begin(topic.sequence, tick.t, "");
      series->put(i, row);
      send(topic, tick.t);
    }
  }
}

void RosTopics::write_markers(const TickView& tick, VehicleId vehicle) {
  const Action* action = tick.actions[vehicle];
  if (!action) return;
  if (action->has_detections && wants("detections")) {
    Channel& detections = channel("/" + names_[vehicle] + "/detections", kMarkerArray);
    encode_detection_markers(action->detections, tick.t, detections.sequence, message_);
    send(detections, tick.t);
  }
  if (!action->relatives.empty() && wants(RelativeEstimate::kName)) {
    Channel& relatives = channel("/" + names_[vehicle] + "/relatives",
                                 [] { return row_type(RelativeEstimate::kName, columns_of<RelativeEstimate>()); });
    RosRow row(message_, names_);
    for (const RelativeEstimate& relative : action->relatives) {
      row.begin(relatives.sequence, relative.t, "world");
      put_columns(relative, row);
      send(relatives, tick.t);
    }
  }
  if (action->has_tracks && wants("tracks")) {
    Channel& tracks = channel("/" + names_[vehicle] + "/tracks", kMarkerArray);
    encode_track_markers(action->tracks, tick.t, tracks.sequence, message_);
    send(tracks, tick.t);
  }
}

void RosTopics::write_scans(const TickView& tick, VehicleId vehicle) {
  if (tick.scans.empty()) return;
  for (const auto& labeled : tick.scans[vehicle]) {
    const Scan& scan = labeled->scan;
    if (!selects(config_.sensors, scan.sensor)) continue;
    const std::string frame = names_[vehicle] + "/" + ros_name(scan.sensor);
    const std::string topic = "/" + frame + "/points";
    if (num_scans_[topic]++ % config_.every != 0) continue;
    announce_sensor(names_[vehicle] + "/body", frame, scan.T_body_lidar, tick.t);
    Channel& points = channel(topic, kPointCloud2);
    encode_points(scan, config_.points_layout, static_cast<float>(config_.points_step_m), points.sequence, frame,
                  message_);
    send(points, tick.t);
  }
}

void RosTopics::announce_sensor(const std::string& parent, const std::string& child, const Pose& T_body_lidar,
                                TimeNs t) {
  const bool is_known = std::any_of(static_transforms_.begin(), static_transforms_.end(),
                                    [&](const StaticTransform& transform) { return transform.child == child; });
  if (is_known || !wants("tf")) return;
  static_transforms_.push_back({parent, child, T_body_lidar});
  // All transforms every time: a latched topic keeps only its last message.
  Channel& tf_static = channel("/tf_static", kTFMessage, true);
  message_.begin();
  message_.count(static_transforms_.size());
  for (const StaticTransform& transform : static_transforms_) {
    encode_transform(tf_static.sequence, t, transform.parent, transform.child, transform.T_parent_child.translation(),
                     Eigen::Quaterniond(transform.T_parent_child.linear()), message_);
  }
  send(tf_static, t);
}

}  // namespace swiftlet::sim
