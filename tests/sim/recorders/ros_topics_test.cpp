// SPDX-License-Identifier: BSD-3-Clause
// Every message, read back by its own definition, against its tick.
#include "sim/recorders/ros_topics.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <numbers>
#include <set>

#include "sim/recorders/geodesy.hpp"
#include "tests/sim/recorders/ros_reader.hpp"
#include "tests/support/synthetic_run.hpp"
#include "tests/support/temporary_directory.hpp"

namespace swiftlet::sim {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::UnorderedElementsAreArray;

constexpr const char* kNames[] = {"uav1", "uav_2"};  // valid ROS names
const std::vector<std::string> kAllTopics = {"points", "world",      "models",   "truth",     "estimate", "tf",
                                             "clock",  "detections", "tracks",   "relatives", "messages", "events",
                                             "imu",    "odometry",   "gnss",     "altimeter", "compass",  "pose",
                                             "scores", "spread",     "neighbors"};

Scene small_scene() {
  Scene scene;
  scene.materials = {{.name = "nothing"}, {.name = "wall", .color_rgb = {0.25F, 0.5F, 0.75F}}};
  Mesh mesh;
  mesh.vertices_mesh_m = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.triangles = {{0, 1, 2}};
  mesh.material = 1;
  scene.meshes = {mesh};
  Instance instance;
  instance.T_world_mesh = Eigen::Affine3f(Eigen::Translation3f(10.0F, 0.0F, 2.0F));
  scene.instances = {instance};
  return scene;
}

std::shared_ptr<const VehicleShape> small_shape() {
  VehicleShape shape;
  shape.materials = {{.name = "frame", .color_rgb = {0.125F, 0.25F, 0.375F}}, {.name = "rotor"}};
  Mesh mesh;
  mesh.vertices_mesh_m = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  mesh.triangles = {{0, 1, 2}, {1, 2, 3}};
  shape.meshes = {mesh};
  VehicleShape::RotorShape rotor;
  rotor.hub_body_m = {0.2F, 0.0F, 0.1F};
  rotor.radius_m = 0.15F;
  shape.rotors = {rotor};
  return std::make_shared<const VehicleShape>(shape);
}

/// A SyntheticRun in a world, written to a sink. The second vehicle has learned where its local frame lies.
class RosRun {
 public:
  RosRun(const RosConfig& config, RosDialect dialect, TimeNs start_time = 0) : sink(dialect), info_(run_.info()) {
    info_.start_time = start_time;
    info_.scene = &scene_;
    info_.vehicle_shapes[1] = small_shape();
    topics_.emplace(config, info_, dialect, sink);
  }

  /// Writes the next tick; earlier messages are dropped.
  const TickView& tick() {
    sink.sent.clear();
    view = run_.tick(k_++);
    for (std::size_t i = 0; i < 2; ++i) {
      actions_[i] = *view.actions[i];
      pointers_[i] = &actions_[i];
    }
    actions_[1].estimate.correct(
        make_pose({3, -2, 1}, Eigen::Quaterniond(Eigen::AngleAxisd(0.7, Vector3(1, 2, 3).normalized()))));
    view.actions = pointers_;
    topics_->write(view);
    return view;
  }
  std::multiset<std::string> topics_sent() const {
    std::multiset<std::string> topics;
    for (const auto& message : sink.sent) topics.insert(sink.topic_of(message));
    return topics;
  }

  KeepingSink sink;
  TickView view;

 private:
  TemporaryDirectory directory_;
  SyntheticRun run_{directory_.path()};
  Scene scene_ = small_scene();
  RunInfo info_;
  std::array<Action, 2> actions_;
  std::array<const Action*, 2> pointers_{};
  std::optional<RosTopics> topics_;
  int k_ = 0;
};

RosConfig config_of(std::vector<std::string> topics) {
  RosConfig config;
  config.topics = std::move(topics);
  return config;
}

void expect_near(const Vector3& found, const Vector3& expected) {
  EXPECT_LT((found - expected).norm(), 1e-9) << found.transpose() << " and " << expected.transpose();
}
void expect_pose(const RosReading& message, const std::string& position, const std::string& rotation, const Vector3& p,
                 const Matrix3& R) {
  expect_near(message.vector(position), p);
  EXPECT_NEAR(message.rotation(rotation).norm(), 1.0, 1e-12);
  EXPECT_LT((message.rotation(rotation).toRotationMatrix() - R).norm(), 1e-9);
}
void expect_pose(const RosReading& message, const std::string& pose, const Pose& T) {
  expect_pose(message, pose + ".position", pose + ".orientation", T.translation(), T.linear());
}
template <class Matrix>
void expect_matrix(const RosReading& message, const std::string& path, const Matrix& expected) {
  const std::vector<double> found = message.array(path);
  ASSERT_EQ(found.size(), static_cast<std::size_t>(expected.size()));
  for (Eigen::Index i = 0; i < expected.rows(); ++i) {
    for (Eigen::Index j = 0; j < expected.cols(); ++j)
      EXPECT_NEAR(found[static_cast<std::size_t>(i * expected.cols() + j)], expected(i, j), 1e-9) << path;
  }
}
void expect_color(const RosReading& message, const std::string& marker, std::array<double, 4> rgba) {
  const char* const kParts[] = {".color.r", ".color.g", ".color.b", ".color.a"};
  for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(message.number(marker + kParts[i]), rgba[i], 1e-6) << marker;
}

class RosTopicsTest : public ::testing::TestWithParam<RosDialect> {};
INSTANTIATE_TEST_SUITE_P(Dialects, RosTopicsTest, ::testing::Values(RosDialect::kRos1, RosDialect::kRos2),
                         [](const auto& dialect) { return dialect.param == RosDialect::kRos1 ? "Ros1" : "Ros2"; });

TEST_P(RosTopicsTest, SendsExactlyWhatEachTickHolds) {
  RosConfig config = config_of(kAllTopics);
  config.rate_hz = 50.0;  // every second tick
  RosRun run(config, GetParam());
  std::map<std::string, std::uint32_t> sequences;
  for (int k = 0; k <= 30; ++k) {
    const TickView& view = run.tick();
    std::vector<std::string> expected;
    const bool sampled = k % 2 == 0;
    if (k == 0) expected.insert(expected.end(), {"/world", "/uav_2/model"});
    if (sampled) expected.insert(expected.end(), {"/clock", "/tf"});
    if (k == 7 || k == 9) expected.emplace_back("/events");
    expected.emplace_back("/spread");
    for (const std::string name : kNames) {
      const std::string at = "/" + name;
      expected.insert(expected.end(),
                      {at + "/imu", at + "/imu", at + "/odometry", at + "/altimeter", at + "/compass", at + "/pose",
                       at + "/neighbors", at + "/scores", at + "/scores", at + "/detections", at + "/relatives"});
      if (sampled) expected.push_back(at + "/truth/pose");
      if (sampled && k >= 5) expected.push_back(at + "/estimate");
      if (k % 5 == 0) expected.push_back(at + "/gnss");
      if (k % 3 != 0) expected.push_back(at + "/radio/neighbor");
      if (k % 2 == 0) expected.push_back(at + "/tracks");
    }
    if (k > 0 && k % 10 == 0)
      expected.insert(expected.end(), {"/uav1/os1/points", "/uav_2/mid360/points", "/uav_2/puck/points"});
    if (k == 10) expected.insert(expected.end(), {"/tf_static", "/tf_static", "/tf_static"});
    EXPECT_THAT(run.topics_sent(), UnorderedElementsAreArray(expected)) << "tick " << k;

    for (const KeepingSink::Sent& message : run.sink.sent) {
      const std::string& topic = run.sink.topic_of(message);
      EXPECT_EQ(message.t, view.t) << topic;
      EXPECT_EQ(message.sequence, sequences[topic]++) << topic;
      const RosReading read = run.sink.read(message);
      // Only ROS 1 headers have a counter.
      for (const std::string header : {"header", "transforms[0].header", "markers[0].header"}) {
        if (read.has(header + ".seq")) {
          EXPECT_EQ(read.number(header + ".seq"), message.sequence) << topic;
        }
      }
    }
  }
  for (const KeepingSink::Channel& channel : run.sink.channels) {
    const bool stays = channel.topic == "/world" || channel.topic == "/uav_2/model" || channel.topic == "/tf_static";
    EXPECT_EQ(channel.latched, stays) << channel.topic;
  }
}

TEST_P(RosTopicsTest, PlacesAreThoseOfTheTick) {
  RosRun run(config_of({"truth", "estimate", "tf", "clock", "pose", "odometry"}), GetParam());
  for (int k = 0; k <= 8; ++k) {
    const TickView& view = run.tick();
    EXPECT_EQ(run.sink.read_all("/clock").at(0).time("clock"), view.t);
    const RosReading tf = run.sink.read_all("/tf").at(0);
    ASSERT_EQ(tf.count("transforms"), k >= 5 ? 4U : 2U);
    std::size_t place = 0;
    for (std::size_t v = 0; v < 2; ++v) {
      const std::string name = kNames[v], at = "/" + name;
      const VehicleState& state = view.states[v];
      const Observation& sensed = view.observations[v];
      const StateEstimate& estimate = view.actions[v]->estimate;
      const auto expect_transform = [&](const std::string& child, const Pose& T) {
        const std::string transform = "transforms[" + std::to_string(place++) + "]";
        EXPECT_EQ(tf.text(transform + ".header.frame_id"), "world");
        EXPECT_EQ(tf.time(transform + ".header.stamp"), view.t);
        EXPECT_EQ(tf.text(transform + ".child_frame_id"), child);
        expect_pose(tf, transform + ".transform.translation", transform + ".transform.rotation", T.translation(),
                    T.linear());
      };
      expect_transform(name + "/body", state.T_world_body());
      if (k >= 5) expect_transform(name + "/local", estimate.T_world_local);

      const RosReading truth = run.sink.read_all(at + "/truth/pose").at(0);
      EXPECT_EQ(truth.text("header.frame_id"), "world");
      EXPECT_EQ(truth.time("header.stamp"), view.t);
      expect_pose(truth, "pose", state.T_world_body());

      const auto expect_odometry = [&](const RosReading& read, TimeNs t, const std::string& frame, const Pose& T,
                                       const Vector3& v_frame_mps, const Vector3& omega_radps, const Matrix6& P) {
        EXPECT_EQ(read.text("header.frame_id"), frame);
        EXPECT_EQ(read.text("child_frame_id"), name + "/body");
        EXPECT_EQ(read.time("header.stamp"), t);
        expect_pose(read, "pose.pose", T);
        expect_near(read.vector("twist.twist.linear"), T.linear().transpose() * v_frame_mps);
        expect_near(read.vector("twist.twist.angular"), omega_radps);
        expect_matrix(read, "pose.covariance", P);
        expect_matrix(read, "twist.covariance", Matrix6(Matrix6::Zero()));
      };
      const OdometrySample& odometry = sensed.odometry.at(0);
      expect_odometry(run.sink.read_all(at + "/odometry").at(0), odometry.t, name + "/local", odometry.T_local_body,
                      odometry.v_local_body_mps, Vector3::Zero(), Matrix6::Zero());
      const PoseSample& pose = sensed.pose.at(0);
      expect_odometry(run.sink.read_all(at + "/pose").at(0), pose.t, "world", pose.T_world_body, pose.v_world_mps,
                      pose.omega_body_radps, Matrix6::Zero());
      const auto told = run.sink.read_all(at + "/estimate");
      ASSERT_EQ(told.size(), k >= 5 ? 1U : 0U);
      if (k < 5) continue;
      // Position turned from the local axes to those of the world, rotation from the body's.
      Matrix6 turn = Matrix6::Zero();
      turn.topLeftCorner<3, 3>() = estimate.T_world_local.linear();
      turn.bottomRightCorner<3, 3>() = estimate.T_world_local.linear() * estimate.T_local_body.linear();
      expect_odometry(told[0], estimate.t, "world", estimate.T_world_local * estimate.T_local_body,
                      estimate.T_world_local.linear() * estimate.v_local_mps, estimate.omega_body_radps,
                      turn * estimate.covariance * turn.transpose());
    }
  }
}

TEST_P(RosTopicsTest, SamplesAreThoseOfTheTick) {
  RosConfig config = config_of({"imu", "gnss", "altimeter", "compass", "neighbors", "messages"});
  config.datum_deg = {-33.5, 151.25};
  config.datum_altitude_m = 40.0;
  RosRun run(config, GetParam());
  for (int k = 0; k <= 5; ++k) {
    const TickView& view = run.tick();
    for (std::size_t v = 0; v < 2; ++v) {
      const std::string name = kNames[v], other = kNames[1 - v], at = "/" + name + "/";
      const Observation& sensed = view.observations[v];
      const auto imu = run.sink.read_all(at + "imu");
      ASSERT_EQ(imu.size(), 2U);
      for (std::size_t i = 0; i < 2; ++i) {
        EXPECT_EQ(imu[i].text("header.frame_id"), name + "/body");
        EXPECT_EQ(imu[i].time("header.stamp"),
                  std::max<TimeNs>(sensed.imu[i].t, GetParam() == RosDialect::kRos1 ? 0 : -kNsPerSecond));
        EXPECT_TRUE(imu[i].rotation("orientation").isApprox(Eigen::Quaterniond::Identity()));
        Matrix3 unknown = Matrix3::Zero();
        unknown(0, 0) = -1.0;
        expect_matrix(imu[i], "orientation_covariance", unknown);
        expect_near(imu[i].vector("angular_velocity"), sensed.imu[i].omega_body_radps);
        expect_near(imu[i].vector("linear_acceleration"), sensed.imu[i].specific_force_body_mps2);
        expect_matrix(imu[i], "angular_velocity_covariance", Matrix3(Matrix3::Zero()));
        expect_matrix(imu[i], "linear_acceleration_covariance", Matrix3(Matrix3::Zero()));
      }
      const auto gnss = run.sink.read_all(at + "gnss");
      ASSERT_EQ(gnss.size(), k % 5 == 0 ? 1U : 0U);
      if (!gnss.empty()) {
        const GnssSample& sample = sensed.gnss.at(0);
        EXPECT_EQ(gnss[0].number("status.status"), 0) << "STATUS_FIX";
        EXPECT_EQ(gnss[0].number("status.service"), 1) << "SERVICE_GPS";
        EXPECT_EQ(gnss[0].number("position_covariance_type"), 2) << "COVARIANCE_TYPE_DIAGONAL_KNOWN";
        const Geodetic place = geodetic_of_world(sample.p_world_m, {-33.5, 151.25, 40.0});
        EXPECT_EQ(gnss[0].number("latitude"), place.latitude_deg);
        EXPECT_EQ(gnss[0].number("longitude"), place.longitude_deg);
        EXPECT_EQ(gnss[0].number("altitude"), place.altitude_m);
        expect_matrix(gnss[0], "position_covariance",
                      Matrix3(sample.sigma_p_m.cwiseProduct(sample.sigma_p_m).asDiagonal()));
      }
      const RosReading altimeter = run.sink.read_all(at + "altimeter").at(0);
      EXPECT_EQ(altimeter.time("header.stamp"), view.t);
      EXPECT_EQ(altimeter.text("header.frame_id"), name + "/body");
      EXPECT_EQ(altimeter.time("t_s"), sensed.altimeter.at(0).t);
      EXPECT_EQ(altimeter.number("height_m"), sensed.altimeter.at(0).height_m);
      EXPECT_EQ(run.sink.read_all(at + "compass").at(0).number("yaw_rad"), sensed.compass.at(0).yaw_rad);
      const RosReading neighbor = run.sink.read_all(at + "neighbors").at(0);
      EXPECT_EQ(neighbor.text("neighbor"), other);
      EXPECT_EQ(neighbor.number("y_body_m"), sensed.neighbors.at(0).p_body_m.y());
      EXPECT_EQ(neighbor.number("cov_xz_m2"), sensed.neighbors.at(0).covariance_body(0, 2));
      const auto heard = run.sink.read_all(at + "radio/neighbor");
      ASSERT_EQ(heard.size(), k % 3 == 0 ? 0U : 1U) << "a newer program's words are not read";
      if (heard.empty()) continue;
      const Message& message = sensed.messages.at(0);
      EXPECT_EQ(heard[0].time("header.stamp"), message.received);
      EXPECT_EQ(heard[0].text("header.frame_id"), "");
      EXPECT_EQ(heard[0].text("sender"), other);
      EXPECT_EQ(heard[0].time("received_s"), message.received);
      NeighborPosition said;
      ASSERT_EQ(read_message(message, said), Reading::kDone);
      EXPECT_EQ(heard[0].number("z_m"), said.p_world_m.z());
    }
  }
}

TEST_P(RosTopicsTest, NamesSubjectsOfEventsAndSeries) {
  RosRun run(config_of({"events", "scores", "spread"}), GetParam());
  for (int k = 0; k <= 9; ++k) {
    const TickView& view = run.tick();
    const auto events = run.sink.read_all("/events");
    if (k == 7) {
      EXPECT_EQ(events.at(0).time("header.stamp"), view.t);
      EXPECT_EQ(events.at(0).text("header.frame_id"), "world");
      EXPECT_EQ(events.at(0).text("kind"), "crash");
      EXPECT_EQ(events.at(0).text("vehicle"), "uav_2");
      EXPECT_EQ(events.at(0).text("partner"), "trunk \"17\"");
      EXPECT_EQ(events.at(0).number("position_z_m"), view.events[0].p_world_m.z());
      EXPECT_EQ(events.at(0).text("note"), "motors\nstopped");
    }
    if (k == 9) {
      EXPECT_EQ(events.at(0).text("vehicle"), "") << "about the whole run";
    }
    const auto scores = run.sink.read_all("/uav_2/scores");
    ASSERT_EQ(scores.size(), 2U);
    EXPECT_EQ(scores[0].time("header.stamp"), view.t);
    EXPECT_EQ(scores[0].text("header.frame_id"), "");
    EXPECT_EQ(scores[0].text("target"), "uav1");
    EXPECT_EQ(scores[0].number("found"), 1.0);
    EXPECT_EQ(scores[0].number("visible_points"), 12.0);
    EXPECT_EQ(scores[1].text("target"), "");
    EXPECT_EQ(scores[1].number("visible_points"), -1.0);
    EXPECT_EQ(run.sink.read_all("/spread").at(0).time("t_s"), view.t);
  }
}

/// Time of a point in the layout of Livox [ns].
double timestamp_of(const RosReading& cloud, std::size_t point) {
  double timestamp = 0.0;
  std::memcpy(&timestamp, cloud.text("data").data() + point * 26 + 18, sizeof timestamp);
  return timestamp;
}

TEST_P(RosTopicsTest, CountsTimeFromStartTime) {
  constexpr TimeNs kStart = 1'700'000'000 * kNsPerSecond;
  RosConfig config = config_of(kAllTopics);
  config.rate_hz = 0.0;
  RosRun from_zero(config, GetParam()), from_epoch(config, GetParam(), kStart);
  std::set<std::string> compared;
  for (int k = 0; k <= 20; ++k) {
    from_zero.tick();
    from_epoch.tick();
    ASSERT_EQ(from_zero.sink.sent.size(), from_epoch.sink.sent.size());
    for (std::size_t i = 0; i < from_zero.sink.sent.size(); ++i) {
      const auto &sent = from_zero.sink.sent[i], &moved = from_epoch.sink.sent[i];
      const std::string& topic = from_zero.sink.topic_of(sent);
      EXPECT_EQ(moved.t - sent.t, kStart) << topic;
      const RosReading at_zero = from_zero.sink.read(sent), at_epoch = from_epoch.sink.read(moved);
      for (const char* stamp : {"header.stamp", "clock", "transforms[0].header.stamp", "markers[0].header.stamp",
                                "markers[1].header.stamp", "t_s", "received_s", "seen_s"}) {
        if (!at_zero.has(std::string(stamp) + ".sec")) continue;
        // ROS 1 has no time before zero.
        const bool cut = GetParam() == RosDialect::kRos1 && at_zero.time(stamp) == 0;
        const TimeNs moved_by = at_epoch.time(stamp) - at_zero.time(stamp);
        EXPECT_TRUE(cut || moved_by == kStart) << topic << " " << stamp << " moved by " << moved_by;
        compared.insert(topic + " " + stamp);
      }
      if (topic != "/uav_2/mid360/points") continue;
      for (std::size_t point = 0; point < 120; ++point)
        EXPECT_NEAR(timestamp_of(at_epoch, point) - static_cast<double>(kStart), timestamp_of(at_zero, point), 256.0);
      compared.insert("points");
    }
  }
  for (const char* what : {"/clock clock", "/tf transforms[0].header.stamp", "/uav1/imu header.stamp",
                           "/uav1/tracks markers[1].header.stamp", "/events t_s", "points"})
    EXPECT_TRUE(compared.contains(what)) << what;
}

TEST(RosNames, AreAlphanumericAndDistinct) {
  EXPECT_EQ(ros_name("uav-1.b"), "uav_1_b");
  std::map<std::string, std::string> taken = {{"body", "body"}};
  EXPECT_EQ(expected_ros_name("uav1", taken), "");
  EXPECT_EQ(expected_ros_name("uav-1", taken), "");
  EXPECT_EQ(expected_ros_name("uav.1", taken), "a name that differs from uav-1 in ROS topics, where both are uav_1");
  EXPECT_EQ(expected_ros_name("body", taken), "a name that differs from body in ROS topics, where both are body");
  EXPECT_EQ(expected_ros_name("2nd", taken), "a name that begins with a letter, because a recorder writes ROS topics");
}

TEST_P(RosTopicsTest, MarkersShowDetectionsAndTracks) {
  RosRun run(config_of({"detections", "tracks", "relatives"}), GetParam());
  bool turned_over = false;
  for (int k = 0; k <= 12; ++k) {
    const TickView& view = run.tick();
    for (std::size_t v = 0; v < 2; ++v) {
      const std::string at = "/" + std::string(kNames[v]);
      const Action& action = *view.actions[v];
      const auto expect_first_deletes = [&](const RosReading& read) {
        EXPECT_EQ(read.number("markers[0].action"), 3) << "DELETEALL";
        EXPECT_EQ(read.text("markers[0].header.frame_id"), "world");
        EXPECT_EQ(read.time("markers[0].header.stamp"), view.t);
        for (std::size_t i = 0; i < read.count("markers"); ++i) {
          const std::string marker = "markers[" + std::to_string(i) + "]";
          EXPECT_EQ(read.number(marker + ".lifetime.sec"), 0);
          EXPECT_EQ(read.number(marker + ".lifetime.nanosec"), 0);
          EXPECT_EQ(read.count(marker + ".colors"), 0U);
          EXPECT_EQ(read.number(marker + ".frame_locked"), 0);
          EXPECT_EQ(read.number(marker + ".mesh_use_embedded_materials"), 0);
          if (i > 0) {
            EXPECT_EQ(read.number(marker + ".action"), 0) << "ADD";
            EXPECT_EQ(read.text(marker + ".header.frame_id"), "world");
          }
        }
      };
      const RosReading detections = run.sink.read_all(at + "/detections").at(0);
      ASSERT_EQ(detections.count("markers"), 1U + action.detections.size());
      expect_first_deletes(detections);
      for (std::size_t i = 0; i < action.detections.size(); ++i) {
        const std::string marker = "markers[" + std::to_string(i + 1) + "]";
        const Detection& detection = action.detections[i];
        EXPECT_EQ(detections.text(marker + ".ns"), "detections");
        EXPECT_EQ(detections.number(marker + ".id"), static_cast<double>(i));
        EXPECT_EQ(detections.number(marker + ".type"), 1) << "CUBE";
        EXPECT_EQ(detections.time(marker + ".header.stamp"),
                  std::max<TimeNs>(detection.t, GetParam() == RosDialect::kRos1 ? 0 : -kNsPerSecond));
        expect_near(detections.vector(marker + ".pose.position"), detection.position_m);
        EXPECT_TRUE(detections.rotation(marker + ".pose.orientation").isApprox(Eigen::Quaterniond::Identity()));
        expect_near(detections.vector(marker + ".scale"), detection.extent_m.cwiseMax(0.1));
      }
      const RosReading relative = run.sink.read_all(at + "/relatives").at(0);
      EXPECT_EQ(relative.time("header.stamp"), action.relatives[0].t);
      EXPECT_EQ(relative.text("header.frame_id"), "world");
      EXPECT_EQ(relative.text("other"), kNames[v]);
      EXPECT_EQ(relative.number("yaw_rad"), action.relatives[0].yaw_rad);

      const auto tracks = run.sink.read_all(at + "/tracks");
      ASSERT_EQ(tracks.size(), k % 2 == 0 ? 1U : 0U);
      if (tracks.empty()) continue;
      const Track& track = action.tracks.at(0);
      const RosReading& read = tracks[0];
      ASSERT_EQ(read.count("markers"), 5U);
      expect_first_deletes(read);
      for (std::size_t i = 1; i < 5; ++i) {
        EXPECT_EQ(read.number("markers[" + std::to_string(i) + "].id"), track.id);
        EXPECT_EQ(read.time("markers[" + std::to_string(i) + "].header.stamp"), track.t);
      }
      EXPECT_EQ(read.text("markers[1].ns"), "tracks");
      EXPECT_EQ(read.number("markers[1].type"), 2) << "SPHERE";
      expect_near(read.vector("markers[1].pose.position"), track.position_m);
      EXPECT_GT(read.vector("markers[1].scale").minCoeff(), 0.0) << "it can be seen";
      EXPECT_EQ(read.text("markers[2].ns"), "covariance");
      EXPECT_EQ(read.number("markers[2].type"), 2);
      expect_near(read.vector("markers[2].pose.position"), track.position_m);
      // Three standard deviations to each side along the axes.
      const Eigen::Quaterniond axes = read.rotation("markers[2].pose.orientation");
      EXPECT_NEAR(axes.norm(), 1.0, 1e-9);
      const Vector3 sigma_m = read.vector("markers[2].scale") / 6.0;
      const Matrix3 P =
          axes.toRotationMatrix() * sigma_m.cwiseAbs2().asDiagonal() * axes.toRotationMatrix().transpose();
      EXPECT_LT((P - track.covariance.topLeftCorner<3, 3>()).norm(), 1e-9 * P.norm());
      const Matrix3 as_solved =
          Eigen::SelfAdjointEigenSolver<Matrix3>(track.covariance.topLeftCorner<3, 3>()).eigenvectors();
      turned_over = turned_over || as_solved.determinant() < 0.0;
      EXPECT_EQ(read.text("markers[3].ns"), "velocity");
      EXPECT_EQ(read.number("markers[3].type"), 0) << "ARROW";
      ASSERT_EQ(read.count("markers[3].points"), 2U);
      expect_near(read.vector("markers[3].points[0]"), track.position_m);
      expect_near(read.vector("markers[3].points[1]") - track.position_m, track.velocity_mps);
      EXPECT_GT(read.number("markers[3].scale.y"), read.number("markers[3].scale.x")) << "a head wider than its shaft";
      EXPECT_GT(read.number("markers[3].scale.x"), 0.0);
      EXPECT_EQ(read.number("markers[3].scale.z"), 0.0) << "the head's length is the viewer's choice";
      EXPECT_EQ(read.text("markers[4].ns"), "names");
      EXPECT_EQ(read.number("markers[4].type"), 9) << "TEXT_VIEW_FACING";
      EXPECT_EQ(read.text("markers[4].text"), std::to_string(track.id));
      const Vector3 above_m = read.vector("markers[4].pose.position") - track.position_m;
      EXPECT_GT(above_m.z(), read.number("markers[1].scale.z") / 2.0) << "above the sphere";
      EXPECT_EQ(above_m.head<2>().norm(), 0.0);
      EXPECT_GT(read.number("markers[4].scale.z"), 0.0) << "height of the letters";
      EXPECT_EQ(read.vector("markers[4].scale").head<2>().norm(), 0.0) << "only z counts for text";
    }
  }
  EXPECT_TRUE(turned_over) << "some axes were left-handed before";
}

TEST_P(RosTopicsTest, SendsWorldAndVehiclesAsTriangles) {
  RosRun run(config_of({"world", "models"}), GetParam());
  run.tick();
  const RosReading world = run.sink.read_all("/world").at(0), model = run.sink.read_all("/uav_2/model").at(0);
  ASSERT_EQ(world.count("markers"), 1U);
  EXPECT_EQ(world.text("markers[0].header.frame_id"), "world");
  EXPECT_EQ(world.text("markers[0].ns"), "world");
  EXPECT_EQ(world.number("markers[0].frame_locked"), 0);
  expect_color(world, "markers[0]", {0.25, 0.5, 0.75, 1.0});
  ASSERT_EQ(world.count("markers[0].points"), 3U);
  expect_near(world.vector("markers[0].points[1]"), {11, 0, 2});

  ASSERT_EQ(model.count("markers"), 2U) << "a mesh, and the discs of the rotors";
  expect_color(model, "markers[0]", {0.125, 0.25, 0.375, 1.0});
  ASSERT_EQ(model.count("markers[0].points"), 6U);
  expect_near(model.vector("markers[0].points[5]"), {0, 0, 1});
  for (const std::string marker : {"markers[0]", "markers[1]"}) {
    EXPECT_EQ(model.text(marker + ".header.frame_id"), "uav_2/body");
    EXPECT_EQ(model.text(marker + ".ns"), "model");
    EXPECT_EQ(model.number(marker + ".frame_locked"), 1);
    EXPECT_EQ(model.number(marker + ".id"), marker == "markers[0]" ? 0 : 1);
    EXPECT_EQ(model.number(marker + ".type"), 11) << "TRIANGLE_LIST";
    expect_near(model.vector(marker + ".scale"), Vector3::Ones());
  }
  EXPECT_GT(model.number("markers[1].color.a"), 0.0);
  EXPECT_LT(model.number("markers[1].color.a"), 1.0) << "one sees through a disc";
  // Triangles from the hub to the rim all around, each from above and from below: twice the area of the disc.
  const std::size_t corners = model.count("markers[1].points");
  ASSERT_EQ(corners % 3, 0U);
  double above_m2 = 0.0, below_m2 = 0.0;
  for (std::size_t i = 0; i < corners; i += 3) {
    const auto corner = [&](std::size_t j) { return model.vector("markers[1].points[" + std::to_string(i + j) + "]"); };
    const double up_m2 = 0.5 * (corner(1) - corner(0)).cross(corner(2) - corner(0)).z();
    (up_m2 > 0.0 ? above_m2 : below_m2) += std::abs(up_m2);
  }
  const auto sides = static_cast<double>(corners) / 6.0;
  const double polygon_m2 = 0.5 * sides * std::sin(2.0 * std::numbers::pi / sides) * 0.15 * 0.15;
  EXPECT_NEAR(above_m2, polygon_m2, 1e-6);
  EXPECT_NEAR(below_m2, polygon_m2, 1e-6);
  EXPECT_GT(polygon_m2, 0.95 * std::numbers::pi * 0.15 * 0.15) << "nearly round";
  run.tick();
  EXPECT_THAT(run.topics_sent(), IsEmpty()) << "once is enough";
}

TEST_P(RosTopicsTest, LatchesLidarMountsWithFirstScan) {
  RosRun run(config_of({"points", "tf"}), GetParam());
  for (int k = 0; k < 10; ++k) run.tick();
  const TickView& view = run.tick();
  const auto told = run.sink.read_all("/tf_static");
  ASSERT_EQ(told.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) ASSERT_EQ(told[i].count("transforms"), i + 1);
  const std::pair<std::string, const Scan*> lidars[] = {{"uav1/os1", &view.scans[0][0]->scan},
                                                        {"uav_2/mid360", &view.scans[1][0]->scan},
                                                        {"uav_2/puck", &view.scans[1][1]->scan}};
  for (std::size_t i = 0; i < 3; ++i) {
    const std::string transform = "transforms[" + std::to_string(i) + "]", &child = lidars[i].first;
    EXPECT_EQ(told[2].text(transform + ".child_frame_id"), child);
    EXPECT_EQ(told[2].text(transform + ".header.frame_id"), child.substr(0, child.find('/')) + "/body");
    EXPECT_EQ(told[2].time(transform + ".header.stamp"), view.t);
    const Pose& T = lidars[i].second->T_body_lidar;
    expect_pose(told[2], transform + ".transform.translation", transform + ".transform.rotation", T.translation(),
                T.linear());
    const RosReading points = run.sink.read_all("/" + child + "/points").at(0);
    EXPECT_EQ(points.text("header.frame_id"), child);
    EXPECT_EQ(points.time("header.stamp"), lidars[i].second->stamp);
  }
}

TEST(RosTopics, SendsOnlyRequestedTopics) {
  const std::pair<std::string, std::set<std::string>> all[] = {
      {"points", {"/uav1/os1/points", "/uav_2/mid360/points", "/uav_2/puck/points"}},
      {"world", {"/world"}},
      {"models", {"/uav_2/model"}},
      {"truth", {"/uav1/truth/pose", "/uav_2/truth/pose"}},
      {"estimate", {"/uav1/estimate", "/uav_2/estimate"}},
      {"tf", {"/tf"}},
      {"clock", {"/clock"}},
      {"detections", {"/uav1/detections", "/uav_2/detections"}},
      {"tracks", {"/uav1/tracks", "/uav_2/tracks"}},
      {"relatives", {"/uav1/relatives", "/uav_2/relatives"}},
      {"messages", {"/uav1/radio/neighbor", "/uav_2/radio/neighbor"}},
      {"events", {"/events"}},
      {"imu", {"/uav1/imu", "/uav_2/imu"}},
      {"scores", {"/uav1/scores", "/uav_2/scores"}},
      {"spread", {"/spread"}}};
  for (const auto& [name, topics] : all) {
    RosRun run(config_of({name}), RosDialect::kRos2);
    std::set<std::string> sent;
    for (int k = 0; k <= 10; ++k) {
      run.tick();
      for (const std::string& topic : run.topics_sent()) sent.insert(topic);
    }
    EXPECT_EQ(sent, topics) << name;
  }
}

TEST(RosTopics, OmitsUnnamedVehiclesFromAllTopics) {
  RosConfig config = config_of(kAllTopics);
  config.vehicles = {"uav1"};
  RosRun run(config, RosDialect::kRos2);
  std::set<std::string> sent;
  for (int k = 0; k <= 10; ++k) {
    const TickView& view = run.tick();
    for (const std::string& topic : run.topics_sent()) sent.insert(topic);
    const RosReading tf = run.sink.read_all("/tf").at(0);
    ASSERT_EQ(tf.count("transforms"), k >= 5 ? 2U : 1U);
    EXPECT_EQ(tf.text("transforms[0].child_frame_id"), "uav1/body");
    EXPECT_EQ(run.sink.read_all("/events").size(), k == 9 ? 1U : 0U) << "the crash is another's";
    EXPECT_EQ(run.sink.read_all("/spread").size(), 1U);
    EXPECT_EQ(view.t, k * SyntheticRun::kTick);
  }
  for (const std::string& topic : sent) EXPECT_FALSE(topic.starts_with("/uav_2")) << topic;
  EXPECT_THAT(sent, Contains("/uav1/os1/points"));
}

TEST(RosTopics, SendsEveryNthNamedLidarScan) {
  RosConfig config = config_of({"points"});
  config.every = 2;
  config.sensors = {"puck", "os1"};
  RosRun run(config, RosDialect::kRos2);
  std::map<std::string, std::vector<int>> sent;
  for (int k = 0; k <= 60; ++k) {
    run.tick();
    for (const std::string& topic : run.topics_sent()) sent[topic].push_back(k);
  }
  EXPECT_THAT(sent, ElementsAre(std::pair("/uav1/os1/points", std::vector{10, 30, 50}),
                                std::pair("/uav_2/puck/points", std::vector{10, 30, 50})));
}

/// One vehicle in one tick of which only the action is given.
class OneTick {
 public:
  explicit OneTick(const std::vector<std::string>& topics, std::vector<std::string> vehicle_names = {"a"})
      : states_(vehicle_names.size()), observations_(vehicle_names.size()), actions_(vehicle_names.size(), nullptr) {
    info_.vehicle_names = std::move(vehicle_names);
    info_.vehicle_shapes.resize(info_.vehicle_names.size());
    topics_.emplace(config_of(topics), info_, RosDialect::kRos2, sink);
  }
  void write(TimeNs t, const Action* action) {
    actions_[0] = action;
    TickView view;
    view.t = t;
    view.states = states_;
    view.observations = observations_;
    view.actions = actions_;
    topics_->write(view);
  }

  KeepingSink sink{RosDialect::kRos2};

 private:
  RunInfo info_;
  std::vector<VehicleState> states_;
  std::vector<Observation> observations_;
  std::vector<const Action*> actions_;
  std::optional<RosTopics> topics_;
};

TEST(RosTopics, SendsExistingEstimateExactlyOnce) {
  OneTick tick({"estimate", "tf", "detections", "tracks"});
  Action action;
  action.estimate.t = 0;
  tick.write(0, nullptr);
  tick.write(20'000'000, &action);
  EXPECT_EQ(tick.sink.read_all("/a/estimate").size(), 0U) << "not valid";
  EXPECT_EQ(tick.sink.read_all("/tf").at(1).count("transforms"), 1U);
  action.estimate.valid = true;
  for (const TimeNs t : {40'000'000, 60'000'000}) tick.write(t, &action);
  EXPECT_EQ(tick.sink.read_all("/a/estimate").size(), 1U) << "of time 0, twice the same";
  EXPECT_EQ(tick.sink.read_all("/tf").at(3).count("transforms"), 2U);
  action.estimate.t = 70'000'000;
  tick.write(80'000'000, &action);
  EXPECT_EQ(tick.sink.read_all("/a/estimate").size(), 2U);
  EXPECT_THAT(tick.sink.read_all("/a/detections"), IsEmpty());
  EXPECT_THAT(tick.sink.read_all("/a/tracks"), IsEmpty());
}

TEST(RosTopics, NumbersMarkersAndClampsNegativeThickness) {
  OneTick tick({"detections", "tracks"});
  Action action;
  action.has_detections = action.has_tracks = true;
  action.detections.resize(3);
  action.tracks.resize(2);
  action.tracks[0].id = 11;
  action.tracks[1].id = 12;
  action.tracks[1].covariance(2, 2) = -1e-12;  // a rounding error of a plane
  tick.write(0, &action);
  const RosReading detections = tick.sink.read_all("/a/detections").at(0);
  ASSERT_EQ(detections.count("markers"), 4U);
  for (int i = 0; i < 3; ++i) {
    const std::string marker = "markers[" + std::to_string(i + 1) + "]";
    EXPECT_EQ(detections.number(marker + ".id"), i);
    expect_near(detections.vector(marker + ".scale"), Vector3::Constant(0.1));  // a box without extent can be seen
  }
  const RosReading tracks = tick.sink.read_all("/a/tracks").at(0);
  ASSERT_EQ(tracks.count("markers"), 9U);
  EXPECT_EQ(tracks.text("markers[8].text"), "12");
  EXPECT_EQ(tracks.vector("markers[6].scale").minCoeff(), 0.0);
}

TEST(RosTopics, ReplacesOtherCharactersWithUnderscores) {
  OneTick tick({"truth"}, {"azAZ09_", "`{@[/:-"});
  tick.write(0, nullptr);
  std::vector<std::string> topics;
  for (const auto& channel : tick.sink.channels) topics.push_back(channel.topic);
  EXPECT_THAT(topics, ElementsAre("/azAZ09_/truth/pose", "/_______/truth/pose"));
}

}  // namespace
}  // namespace swiftlet::sim
