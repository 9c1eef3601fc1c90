// SPDX-License-Identifier: BSD-3-Clause
// Which messages are sent when; tests/readers compares every value of every message.
#include "sim/recorders/ros_topics.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

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
void expect_pose(const RosReading& message, const std::string& position, const std::string& rotation, const Pose& T) {
  expect_near(message.vector(position), T.translation());
  EXPECT_LT((message.rotation(rotation).toRotationMatrix() - T.linear()).norm(), 1e-9);
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

// A corrected estimate is published in the world, its covariance with it: positions turned from the local axes,
// rotations from those of the body.
TEST_P(RosTopicsTest, PlacesCorrectedEstimatesInTheWorld) {
  RosRun run(config_of({"estimate", "tf"}), GetParam());
  for (int k = 0; k < 8; ++k) run.tick();
  const StateEstimate& estimate = run.tick().actions[1]->estimate;
  const Pose &T_world_local = estimate.T_world_local, T_world_body = T_world_local * estimate.T_local_body;
  const RosReading tf = run.sink.read_all("/tf").at(0), read = run.sink.read_all("/uav_2/estimate").at(0);
  EXPECT_EQ(tf.text("transforms[3].child_frame_id"), "uav_2/local");
  expect_pose(tf, "transforms[3].transform.translation", "transforms[3].transform.rotation", T_world_local);
  EXPECT_EQ(read.text("header.frame_id"), "world");
  EXPECT_EQ(read.text("child_frame_id"), "uav_2/body");
  EXPECT_EQ(read.time("header.stamp"), estimate.t);
  expect_pose(read, "pose.pose.position", "pose.pose.orientation", T_world_body);
  expect_near(read.vector("twist.twist.linear"), estimate.T_local_body.linear().transpose() * estimate.v_local_mps);
  Matrix6 turn = Matrix6::Zero();
  turn.topLeftCorner<3, 3>() = T_world_local.linear();
  turn.bottomRightCorner<3, 3>() = T_world_body.linear();
  const Matrix6 expected = turn * estimate.covariance * turn.transpose();
  const std::vector<double> found = read.array("pose.covariance");
  ASSERT_EQ(found.size(), 36U);
  for (Eigen::Index i = 0; i < 36; ++i)
    EXPECT_NEAR(found[static_cast<std::size_t>(i)], expected(i / 6, i % 6), 1e-9) << i;
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

TEST_P(RosTopicsTest, SendsWorldAndVehiclesAsTriangles) {
  RosRun run(config_of({"world", "models"}), GetParam());
  run.tick();
  const RosReading world = run.sink.read_all("/world").at(0), model = run.sink.read_all("/uav_2/model").at(0);
  ASSERT_EQ(world.count("markers"), 1U) << "only materials with triangles";
  EXPECT_EQ(world.text("markers[0].header.frame_id"), "world");
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
    EXPECT_EQ(model.number(marker + ".frame_locked"), 1);
    EXPECT_EQ(model.number(marker + ".type"), 11) << "TRIANGLE_LIST";
    expect_near(model.vector(marker + ".scale"), Vector3::Ones());
  }
  EXPECT_LT(model.number("markers[1].color.a"), 1.0) << "discs are transparent";
  for (std::size_t i = 0; i < model.count("markers[1].points"); ++i) {
    const Vector3 from_hub_m = model.vector("markers[1].points[" + std::to_string(i) + "]") - Vector3(0.2, 0.0, 0.1);
    EXPECT_NEAR(from_hub_m.norm(), i % 3 == 0 ? 0.0 : 0.15, 1e-6);
    EXPECT_NEAR(from_hub_m.z(), 0.0, 1e-6);
  }
  run.tick();
  EXPECT_THAT(run.topics_sent(), IsEmpty()) << "once is enough";
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
  EXPECT_EQ(tick.sink.read_all("/a/estimate").size(), 1U) << "two ticks with the same estimate of time 0";
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

}  // namespace
}  // namespace swiftlet::sim
