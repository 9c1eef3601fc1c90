// SPDX-License-Identifier: BSD-3-Clause
// A sequence of made-up ticks, read back file by file.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <map>
#include <numbers>

#include "sim/dataset/frame_writer.hpp"
#include "sim/dataset/hash.hpp"
#include "sim/dataset/sequence_recorder.hpp"
#include "swiftlet/sim/scenario/scenario.hpp"
#include "swiftlet/sim/world/vehicle_shape.hpp"
#include "tests/sim/dataset/read_files.hpp"
#include "tests/support/temporary_directory.hpp"
#include "tests/support/test_scene.hpp"

namespace swiftlet::sim {
namespace {

namespace fs = std::filesystem;

std::shared_ptr<BeamTable> beams_all_around(int rows, int cols) {
  auto beams = std::make_shared<BeamTable>();
  beams->rows = rows;
  beams->cols = cols;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < cols; ++column) {
      const double azimuth = -2.0 * std::numbers::pi * column / cols;
      const double elevation = (0.5 * (rows - 1) - row) * 2.0 * std::numbers::pi / 180.0;
      beams->directions_lidar.emplace_back(std::cos(elevation) * std::cos(azimuth),
                                           std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
      beams->origins_lidar.emplace_back(0, 0, 0);
    }
  }
  for (int column = 0; column < cols; ++column)
    beams->column_offset_s.push_back(0.1F * static_cast<float>(column) / static_cast<float>(cols));
  return beams;
}

/// Two UAVs: one with a LiDAR that flies along x, one that comes out slowly from behind a wall ahead. A tick every 10
/// ms, a sweep every 100 ms. Its ranges, classes and points on the other are made up.
class Flight2 {
 public:
  static constexpr TimeNs kTick = 10'000'000;
  static constexpr int kScans = 30;

  Flight2() {
    TestScene scene;
    scene.add_wall({-90, -90, 0}, {90, -90, 0}, {90, 90, 0}, {-90, 90, 0}, SurfaceClass::kGround);
    scene.add_box({20, -5, 0}, {20.1F, 0, 20});
    world = std::make_shared<const StaticScene>(scene.scene());
    const auto shape = std::make_shared<const VehicleShape>(make_vehicle_shape(Scenario().vehicles[0].airframe));
    info_.vehicle_names = {"uav1", "uav2"};
    info_.vehicle_shapes = {shape, shape};
  }

  /// @return statistics of the sequence recorded in `directory`
  SequenceStatistics record(const ContentConfig& content, const fs::path& directory) {
    info_.directory = directory;
    scans.clear();
    const auto statistics = std::make_shared<SequenceStatistics>();
    const auto recorder = make_sequence_recorder(content, 0, "os", world, statistics);
    recorder->begin(info_);
    const auto beams = beams_all_around(16, 90);
    flown_m = 0.0;
    for (int k = 1; k <= 10 * kScans; ++k) {
      VehicleState states[2];
      for (VehicleId v = 0; v < 2; ++v) states[v] = state_of(v, k * kTick);
      if (k > 1) flown_m += (states[0].p_world_m - state_of(0, (k - 1) * kTick).p_world_m).norm();
      std::vector<std::shared_ptr<const LabeledScan>> completed[2];
      if (k % 10 == 0) {
        scans.push_back(make_scan(beams, k / 10 - 1));
        auto other = std::make_shared<LabeledScan>(*scans.back());
        other->scan.sensor = "other";
        completed[0] = {other, scans.back()};
        completed[1] = {scans.back()};  // a sensor of the same name on another vehicle
      }
      const Observation observations[2];
      Action action;
      action.estimate.valid = k > 5;
      action.estimate.t = k * kTick;
      action.estimate.T_local_body = states[0].T_world_body();
      action.estimate.T_local_body.translation().x() += 0.25;
      const Action* const actions[2] = {&action, nullptr};
      const double clearance_m[2] = {5.0 + k, k == 77 ? 0.375 : 9.0};
      TickView view;
      view.t = k * kTick;
      view.states = states;
      view.observations = observations;
      view.actions = actions;
      if (k > 2) view.scans = completed;
      if (k != 78) view.clearance_m = clearance_m;
      recorder->write(view);
    }
    EXPECT_TRUE(recorder->finish().empty());
    return *statistics;
  }

  static VehicleState state_of(VehicleId vehicle, TimeNs t) {
    const double t_s = to_seconds(t);
    VehicleState state;
    state.t = t;
    state.p_world_m = vehicle == 0 ? Vector3(0.5 * t_s, 0, 10) : Vector3(30, -0.6 + 0.4 * t_s, 10.3);
    state.v_world_mps = vehicle == 0 ? Vector3(0.5, 0, 0) : Vector3(0, 0.4, 0);
    state.q_world_body = Eigen::AngleAxisd(0.1 * t_s, Vector3::UnitZ());
    return state;
  }
  static Pose body_from_lidar() {
    return make_pose({0.05, 0, 0.3}, Eigen::Quaterniond(Eigen::AngleAxisd(0.2, Vector3::UnitZ())));
  }
  Pose world_from_lidar(TimeNs t) const { return state_of(0, t).T_world_body() * body_from_lidar(); }

  std::shared_ptr<const StaticScene> world;
  std::vector<std::shared_ptr<const LabeledScan>> scans;
  double flown_m = 0.0;
  bool is_localized_outside = false;

 private:
  std::shared_ptr<LabeledScan> make_scan(const std::shared_ptr<const BeamTable>& beams, int n) const {
    auto labeled = std::make_shared<LabeledScan>();
    Scan& scan = labeled->scan;
    scan.sensor = "os";
    scan.beams = beams;
    scan.stamp = n * 100'000'000LL;
    scan.duration = 100'000'000;
    scan.range_max_m = 120.0;
    scan.T_body_lidar = body_from_lidar();
    const auto size = static_cast<std::size_t>(scan.size());
    ScanTruth& truth = labeled->truth;
    truth.T_body_lidar = body_from_lidar();
    for (std::size_t i = 0; i < size; ++i) {
      const int kind = static_cast<int>(i) % 7;
      // Both sides of every edge of a bin, and beyond the last.
      scan.range_m.push_back(kind == 3 ? 0.0F : static_cast<float>(i % 64) * 2.0F + (kind == 1 ? 1.99F : 0.0F));
      scan.intensity.push_back(0.01F * static_cast<float>(i % 50));
      scan.reflectivity.push_back(0.02F * static_cast<float>(i % 50));
      truth.range_m.push_back(scan.range_m.back());
      truth.incidence_rad.push_back(0.5F);
      truth.surface_class.push_back(static_cast<std::uint16_t>(kind == 2 ? 70 : kind == 3 ? 71 : kind == 4 ? 0 : 40));
      truth.instance.push_back(0);
      truth.part.push_back(0);
    }
    // Number of points on the other vehicle: 0 to 6.
    for (int i = 0; i < n % 7; ++i) {
      const auto at = static_cast<std::size_t>(10 + i);
      scan.range_m[at] = 30.0F;
      truth.surface_class[at] = 300;
      truth.instance[at] = 2;
    }
    for (int column = 0; column < scan.cols(); ++column)
      truth.T_world_lidar.push_back(world_from_lidar(scan.time_of(column)));
    if (is_localized_outside) {
      for (const double t_s : {0.0, 0.05, 0.1}) {
        Pose T = state_of(0, scan.stamp + from_seconds(t_s)).T_world_body();
        T.translation().y() += 0.5;
        scan.external_poses.push_back({scan.stamp + from_seconds(t_s), T});
      }
    }
    return labeled;
  }

  RunInfo info_;
};

class SequenceRecorderTest : public ::testing::Test {
 protected:
  TemporaryDirectory directory;
  Flight2 flight;
  ContentConfig content;

  std::vector<std::map<std::string, std::string>> boxes() const {
    const auto lines = split(read_whole_file(directory.path() / "boxes.csv"), '\n');
    const auto head = split(lines.at(0), ',');
    std::vector<std::map<std::string, std::string>> rows;
    for (std::size_t i = 1; i < lines.size(); ++i) {
      const auto cells = split(lines[i], ',');
      EXPECT_EQ(cells.size(), head.size());
      auto& row = rows.emplace_back();
      for (std::size_t k = 0; k < head.size(); ++k) row[head[k]] = cells[k];
    }
    return rows;
  }
  static Vector3 vector(std::map<std::string, std::string>& row, const char* x, const char* y, const char* z) {
    return {std::stod(row[x]), std::stod(row[y]), std::stod(row[z])};
  }
};

TEST_F(SequenceRecorderTest, RecordsTruthAndBeliefPerFrame) {
  flight.record(content, directory.path());
  const auto poses = split(read_whole_file(directory.path() / "poses.txt"), '\n'),
             times = split(read_whole_file(directory.path() / "times.txt"), '\n'),
             beliefs = split(read_whole_file(directory.path() / "estimate.tum"), '\n'),
             calibration = split(read_whole_file(directory.path() / "calib.txt"), '\n');
  ASSERT_EQ(poses.size(), 30U);
  ASSERT_EQ(times.size(), 30U);
  ASSERT_EQ(beliefs.size(), 31U);
  EXPECT_EQ(beliefs[0], "# t_s x_m y_m z_m qx qy qz qw");
  for (std::size_t n = 0; n < 30; ++n) {
    const TimeNs t = static_cast<TimeNs>(n) * 100'000'000;
    EXPECT_NEAR(std::stod(times[n]), to_seconds(t), 1e-12);
    const Pose T = flight.world_from_lidar(t);
    const auto matrix = numbers_of(poses[n]);
    ASSERT_EQ(matrix.size(), 12U);
    for (int i = 0; i < 12; ++i) EXPECT_NEAR(matrix[static_cast<std::size_t>(i)], T.matrix()(i / 4, i % 4), 1e-12);
    const auto belief = numbers_of(beliefs[n + 1]);
    ASSERT_EQ(belief.size(), 8U);
    EXPECT_NEAR(belief[0], to_seconds(t), 1e-12);
    const Pose expected = [&] {  // the first belief is of 60 ms
      Pose believed = Flight2::state_of(0, std::max<TimeNs>(t, 60'000'000)).T_world_body();
      believed.translation().x() += 0.25;
      return Pose(believed * Flight2::body_from_lidar());
    }();
    for (int axis = 0; axis < 3; ++axis)
      EXPECT_NEAR(belief[static_cast<std::size_t>(1 + axis)], expected.translation()[axis], 1e-9);
    const Eigen::Quaterniond q(belief[7], belief[4], belief[5], belief[6]);
    EXPECT_LT((q.toRotationMatrix() - expected.linear()).norm(), 1e-9);
  }
  ASSERT_EQ(calibration.size(), 6U);
  const char* const names[] = {"P0:", "P1:", "P2:", "P3:", "Tr:", "T_body_lidar:"};
  for (std::size_t k = 0; k < 6; ++k) {
    EXPECT_TRUE(calibration[k].starts_with(names[k]));
    const auto matrix = numbers_of(calibration[k].substr(calibration[k].find(' ') + 1));
    ASSERT_EQ(matrix.size(), 12U);
    const Pose T = k < 5 ? Pose::Identity() : Flight2::body_from_lidar();
    for (int i = 0; i < 12; ++i) EXPECT_NEAR(matrix[static_cast<std::size_t>(i)], T.matrix()(i / 4, i % 4), 1e-12);
  }
}

TEST_F(SequenceRecorderTest, PrefersExternalLocalizationOverTheEstimate) {
  flight.is_localized_outside = true;
  flight.record(content, directory.path());
  const auto beliefs = split(read_whole_file(directory.path() / "estimate.tum"), '\n');
  ASSERT_EQ(beliefs.size(), 31U);
  for (std::size_t n = 0; n < 30; ++n) {
    Pose T = Flight2::state_of(0, static_cast<TimeNs>(n) * 100'000'000).T_world_body();
    T.translation().y() += 0.5;
    const auto belief = numbers_of(beliefs[n + 1]);
    EXPECT_NEAR(belief[2], (T * Flight2::body_from_lidar()).translation().y(), 1e-6);
  }
}

TEST_F(SequenceRecorderTest, PlacesBoxesAtPointObservationTimes) {
  const SequenceStatistics statistics = flight.record(content, directory.path());
  auto rows = boxes();
  ASSERT_EQ(rows.size(), 30U);
  std::array<SequenceStatistics::RangeBin, 50> expected{};
  for (std::size_t n = 0; n < rows.size(); ++n) {
    auto& row = rows[n];
    EXPECT_EQ(row["frame"], std::to_string(n));
    EXPECT_EQ(row["vehicle"], "uav2");
    EXPECT_EQ(row["instance"], "2");
    const TimeNs t = from_seconds(std::stod(row["t_s"]));
    const int points = static_cast<int>(n % 7);
    EXPECT_EQ(row["num_points"], std::to_string(points));
    if (points > 0) {
      // Columns 10 to 9 + points of 90, in 100 ms.
      const double mean_s = 0.1 * (10.0 + 0.5 * (points - 1)) / 90.0;
      EXPECT_NEAR(to_seconds(t) - 0.1 * static_cast<double>(n), mean_s, 1e-7);
    }
    const TimeNs known = std::max(t, Flight2::kTick);  // no data before the first tick
    const Vector3 p_world = vector(row, "x_world_m", "y_world_m", "z_world_m"),
                  p_lidar = vector(row, "x_m", "y_m", "z_m");
    EXPECT_LT((flight.world_from_lidar(known) * p_lidar - p_world).norm(), 1e-6);
    const VehicleState truth = Flight2::state_of(1, known);
    EXPECT_LT((p_world - truth.p_world_m).head<2>().norm(), 0.06) << "the box is about the body";
    EXPECT_NEAR(std::stod(row["range_m"]), p_lidar.norm(), 1e-9);
    EXPECT_LT((vector(row, "vx_world_mps", "vy_world_mps", "vz_world_mps") - truth.v_world_mps).norm(), 1e-9);
    const Eigen::Quaterniond q(std::stod(row["qw_world"]), std::stod(row["qx_world"]), std::stod(row["qy_world"]),
                               std::stod(row["qz_world"]));
    EXPECT_LT((q.toRotationMatrix() - truth.q_world_body.toRotationMatrix()).norm(), 1e-6);
    const double visible = std::stod(row["visible_fraction"]);
    auto& bin = expected[static_cast<std::size_t>(std::stod(row["range_m"]) / 2.0)];
    ++bin.boxes;
    bin.in_view += visible >= 0.1 ? 1 : 0;
    bin.detected += points >= 1 ? 1 : 0;
    bin.well_detected += points >= 5 ? 1 : 0;
    bin.points += points;
  }
  for (std::size_t i = 0; i < 50; ++i) {
    const auto& found = statistics.vehicles_by_range[i];
    EXPECT_EQ(found.boxes, expected[i].boxes) << i;
    EXPECT_EQ(found.in_view, expected[i].in_view) << i;
    EXPECT_EQ(found.detected, expected[i].detected) << i;
    EXPECT_EQ(found.well_detected, expected[i].well_detected) << i;
    EXPECT_EQ(found.points, expected[i].points) << i;
  }
}

TEST_F(SequenceRecorderTest, PlacesDeskewedBoxesInStartFrame) {
  content.deskew = true;
  flight.record(content, directory.path());
  auto rows = boxes();
  for (std::size_t n = 0; n < rows.size(); ++n) {
    const Vector3 p_world = vector(rows[n], "x_world_m", "y_world_m", "z_world_m");
    const Vector3 p_lidar = vector(rows[n], "x_m", "y_m", "z_m");
    EXPECT_LT((flight.world_from_lidar(static_cast<TimeNs>(n) * 100'000'000) * p_lidar - p_world).norm(), 1e-6);
  }
}

TEST_F(SequenceRecorderTest, CountsMatchItsScans) {
  const SequenceStatistics found = flight.record(content, directory.path());
  EXPECT_EQ(found.frames, 30);
  EXPECT_EQ(found.rows, 16);
  EXPECT_EQ(found.columns, 90);
  EXPECT_NEAR(found.duration_s, 3.0, 1e-12);
  EXPECT_NEAR(found.flown_m, flight.flown_m, 1e-9);
  EXPECT_EQ(found.least_clearance_m, 0.375);
  EXPECT_EQ(found.pixel_shift_by_row, std::vector<int>(16, 0));
  std::int64_t points = 0;
  std::map<std::uint16_t, std::int64_t> by_class;
  std::array<std::int64_t, 50> by_range{};
  for (const auto& scan : flight.scans) {
    for (std::size_t i = 0; i < scan->scan.range_m.size(); ++i) {
      const float range_m = scan->scan.range_m[i];
      if (range_m <= 0.0F) continue;
      ++points;
      ++by_class[scan->truth.surface_class[i]];
      ++by_range[std::min<std::size_t>(static_cast<std::size_t>(range_m / 2.0F), 49)];
    }
  }
  EXPECT_EQ(found.points, points);
  EXPECT_EQ(found.points_by_class, by_class);
  EXPECT_EQ(found.points_by_range, by_range);
}

TEST_F(SequenceRecorderTest, CountsFramesNotEnclosedByWalls) {
  EXPECT_EQ(flight.record(content, directory.path()).frames_outside, 30);
  // Out through the east wall of a room: the LiDAR flies from x = 0.05 m to 1.5 m.
  constexpr float kEast_m = 0.75F;
  TestScene room;
  room.add_box({-5, -5, 0}, {-4.9F, 5, 20});
  room.add_box({kEast_m, -5, 0}, {kEast_m + 0.001F, 5, 20});
  room.add_box({-5, -5.1F, 0}, {kEast_m, -5, 20});
  room.add_box({-5, 5, 0}, {kEast_m, 5.1F, 20});
  flight.world = std::make_shared<const StaticScene>(room.scene());
  const TemporaryDirectory again;
  int outside = 0;
  for (int n = 0; n < Flight2::kScans; ++n) {
    outside += flight.world_from_lidar(n * 100'000'000LL).translation().x() > static_cast<double>(kEast_m) ? 1 : 0;
  }
  EXPECT_GT(outside, 5);
  EXPECT_LT(outside, 25);
  EXPECT_EQ(flight.record(content, again.path()).frames_outside, outside);
}

TEST_F(SequenceRecorderTest, ListsFrameFilesWithTheirHashes) {
  const SequenceStatistics found = flight.record(content, directory.path());
  ASSERT_EQ(found.files.size(), 30U * 5U);
  std::map<std::string, int> folders;
  for (const FileEntry& file : found.files) {
    const std::string bytes = read_whole_file(directory.path() / file.path);
    EXPECT_EQ(file.bytes, bytes.size());
    EXPECT_EQ(file.xxh128, hex(hash_of(bytes)));
    ++folders[file.path.substr(0, file.path.rfind('/'))];
  }
  EXPECT_EQ(
      folders,
      (std::map<std::string, int>{
          {"images/intensity", 30}, {"images/range", 30}, {"labels", 30}, {"point_truth", 30}, {"velodyne", 30}}));
  for (int n = 0; n < 30; ++n) {
    Frame frame;
    encode_frame(*flight.scans[static_cast<std::size_t>(n)], content, frame);
    const std::string stored = read_whole_file(directory.path() / frame_file("velodyne", n, "bin"));
    EXPECT_EQ(std::memcmp(stored.data(), frame.velodyne.bytes().data(), stored.size()), 0);
  }
  EXPECT_GT(found.beside_s, 0.0);
}

TEST_F(SequenceRecorderTest, WritesEveryNthScanAsRequested) {
  content.every = 4;
  content.images = false;
  content.point_truth = false;
  const SequenceStatistics found = flight.record(content, directory.path());
  EXPECT_EQ(found.frames, 8);
  const auto times = split(read_whole_file(directory.path() / "times.txt"), '\n');
  ASSERT_EQ(times.size(), 8U);
  EXPECT_EQ(std::stod(times[1]), 0.4);
  EXPECT_EQ(boxes().size(), 8U);
  EXPECT_EQ(boxes().back()["frame"], "7");
  EXPECT_EQ(found.files.size(), 16U);
  EXPECT_FALSE(fs::exists(directory.path() / "images"));
  EXPECT_FALSE(fs::exists(directory.path() / "point_truth"));
}

TEST(FrameWriter, ReportsFailedWrites) {
  const TemporaryDirectory directory;
  std::ofstream(directory.path() / "velodyne") << "in the way";
  auto scan = std::make_shared<LabeledScan>();
  scan->scan.beams = beams_all_around(1, 1);
  scan->scan.range_m = scan->scan.intensity = scan->scan.reflectivity = {1.0F};
  scan->truth.range_m = scan->truth.incidence_rad = {1.0F};
  scan->truth.surface_class = scan->truth.instance = {0};
  scan->truth.T_world_lidar = {Pose::Identity()};
  FrameWriter writer(ContentConfig(), directory.path());
  writer.push(scan);
  EXPECT_THROW(writer.finish(), std::runtime_error);
  FrameWriter again(ContentConfig(), directory.path());
  EXPECT_THROW(
      {
        for (int i = 0; i < 1000; ++i) again.push(scan);
      },
      std::runtime_error);
}

}  // namespace
}  // namespace swiftlet::sim
