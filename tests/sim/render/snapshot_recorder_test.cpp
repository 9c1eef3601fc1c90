// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/render/snapshot_recorder.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "render_support.hpp"
#include "sim/render/picture_scene.hpp"
#include "swiftlet/sim/errors.hpp"
#include "swiftlet/sim/io/files.hpp"
#include "swiftlet/sim/raycast/ray_scene.hpp"
#include "swiftlet/sim/world/labeled_scan.hpp"
#include "tests/support/temporary_directory.hpp"

namespace swiftlet::sim {
namespace {

using testing::ElementsAre;

CameraConfig small_camera(const char* name, CameraConfig::Type type) {
  CameraConfig camera;
  camera.name = name;
  camera.type = type;
  camera.width_px = 160;
  camera.height_px = 90;
  return camera;
}

TEST(WantsPicture, AtListedTimesAndAtMultiples) {
  CameraConfig camera;
  camera.times_s = {0.0, 1.5};
  EXPECT_TRUE(wants_picture({{camera}}, -1, from_seconds(0.004)));
  EXPECT_FALSE(wants_picture({{camera}}, 0, from_seconds(0.004)));
  EXPECT_TRUE(wants_picture({{camera}}, from_seconds(1.496), from_seconds(1.5)));
  EXPECT_FALSE(wants_picture({{camera}}, from_seconds(1.5), from_seconds(1.504)));
  camera.times_s.clear();
  camera.every_s = 0.1;
  int count = 0;
  for (int k = 0; k < 2500; ++k) count += camera.is_due(k * 4'000'000LL, (k + 1) * 4'000'000LL) ? 1 : 0;
  EXPECT_EQ(count, 100);
}

TEST(Trail, KeepsItsMemoryBoundedAndItsEnds) {
  std::vector<Eigen::Vector3f> trail;
  for (int i = 0; i < 100'000; ++i) extend_trail(trail, {0.06F * static_cast<float>(i), 0, 0});
  EXPECT_LT(trail.size(), 9000U);
  EXPECT_EQ(trail.front().x(), 0.0F);
  EXPECT_NEAR(trail.back().x(), 6000.0F, 0.2F);
  for (std::size_t i = 1; i < trail.size(); ++i) ASSERT_LT(trail[i - 1].x(), trail[i].x());
  const std::size_t before = trail.size();
  extend_trail(trail, trail.back());
  EXPECT_EQ(trail.size(), before) << "a vehicle that hovers";
}

TEST(Cloud, LiesWhereTheSensorTrulyWasColumnByColumn) {
  LabeledScan labeled;
  auto beams = std::make_shared<BeamTable>();
  beams->rows = 1;
  beams->cols = 3;
  beams->directions_lidar.assign(3, Eigen::Vector3f::UnitX());
  beams->origins_lidar.assign(3, Eigen::Vector3f(0, 0, 0.5F));
  labeled.scan.beams = beams;
  labeled.scan.range_m = {2.0F, 0.0F, 4.0F};
  for (int column = 0; column < 3; ++column) {
    labeled.truth.T_world_lidar.push_back(make_pose({10.0 * column, 0, 1}, Eigen::Quaterniond::Identity()));
  }
  const PictureCloud cloud = cloud_of(labeled, 1);
  EXPECT_THAT(cloud.points_world_m, ElementsAre(Eigen::Vector3f(2, 0, 1.5F), Eigen::Vector3f(24, 0, 1.5F)));
}

class SnapshotRecorderTest : public testing::Test {
 protected:
  SnapshotRecorderTest() {
    world_.add({-20, -20, -1}, {20, 20, 0}, {0.5F, 0.5F, 0.5F}, SurfaceClass::kGround);
    info_.scene = &world_.scene();
    info_.vehicle_names = {"uav1", "uav2"};
    info_.vehicle_shapes = {make_test_shape(), make_test_shape()};
    info_.directory = folder_.path();
    states_.resize(2);
    scans_.resize(2);
  }

  /// Ticks of 10 ms from 0 to `end_s`.
  std::vector<std::filesystem::path> fly(std::vector<CameraConfig> cameras, double end_s) {
    const auto recorder = make_snapshot_recorder(std::move(cameras));
    recorder->begin(info_);
    for (TimeNs t = 0; t <= from_seconds(end_s); t += 10'000'000) {
      for (std::size_t v = 0; v < 2; ++v) {
        states_[v].t = t;
        states_[v].p_world_m = {to_seconds(t), static_cast<double>(v) * 3.0, 2.0};
      }
      TickView tick;
      tick.t = t;
      tick.states = states_;
      tick.scans = scans_;
      recorder->write(tick);
    }
    return recorder->finish();
  }

  TemporaryDirectory folder_;
  BoxWorld world_;
  RunInfo info_;
  std::vector<VehicleState> states_;
  std::vector<std::vector<std::shared_ptr<const LabeledScan>>> scans_;
};

TEST_F(SnapshotRecorderTest, WritesEachCamerasPicturesAtItsTimes) {
  CameraConfig top = small_camera("above", CameraConfig::Type::kTop);
  top.times_s = {0.05, 0.2};
  CameraConfig depth = small_camera("depth", CameraConfig::Type::kDepth);
  depth.vehicle = "uav2";
  depth.every_s = 0.1;
  depth.times_s = {};
  CameraConfig lidar = small_camera("os1", CameraConfig::Type::kLidarRange);
  lidar.times_s = {0.2};
  CameraConfig never = small_camera("never", CameraConfig::Type::kFollow);
  const auto written = fly({top, depth, lidar, never}, 0.2);
  EXPECT_THAT(written,
              testing::UnorderedElementsAre("snapshots/above_0000.050s.png", "snapshots/above_0000.200s.png",
                                            "snapshots/depth_0000.000s.png", "snapshots/depth_0000.100s.png",
                                            "snapshots/depth_0000.200s.png", "snapshots/depth_0000.000s.mm.png",
                                            "snapshots/depth_0000.100s.mm.png", "snapshots/depth_0000.200s.mm.png",
                                            "snapshots/os1_0000.200s.png"));
  std::size_t files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder_.path() / "snapshots")) {
    EXPECT_EQ(entry.path().extension(), ".png");
    ++files;
  }
  EXPECT_EQ(files, written.size());
}

TEST_F(SnapshotRecorderTest, WritesPaperAsPngAndAsSvgOfTheSizeAsked) {
  CameraConfig camera = small_camera("figure", CameraConfig::Type::kTop);
  camera.times_s = {0.1};
  camera.style = PictureMedium::kPaper;
  camera.width_mm = 40.0;
  camera.height_mm = 30.0;
  camera.dpi = 254.0;
  EXPECT_THAT(fly({camera}, 0.1),
              testing::UnorderedElementsAre("snapshots/figure_0000.100s.png", "snapshots/figure_0000.100s.svg"));
  const std::string svg = read_whole_file(folder_.path() / "snapshots/figure_0000.100s.svg");
  EXPECT_THAT(svg, testing::HasSubstr("width=\"40mm\" height=\"30mm\" viewBox=\"0 0 400 300\""));
  for (const char* text : {">uav1</text>", ">uav2</text>", " m</text>", ">x</text>", "<image "}) {
    EXPECT_THAT(svg, testing::HasSubstr(text));
  }
  EXPECT_THAT(svg, testing::Not(testing::HasSubstr("t = 0.100 s</text>"))) << "captions are off";
  EXPECT_THAT(svg, testing::HasSubstr("figure, t = 0.100 s</title>"));
}

TEST_F(SnapshotRecorderTest, DrawsNoTrailAndNoMarksOnBoard) {
  // Flying backwards, uav1 would look along its own trail, as wide as the picture.
  CameraConfig camera = small_camera("onboard", CameraConfig::Type::kOnboard);
  camera.position_m = {0.0, 0.0, 0.6};
  camera.target_m = {-1.0, 0.0, 0.6};
  camera.times_s = {1.0};
  fly({camera}, 1.0);
  const std::string with = read_whole_file(folder_.path() / "snapshots/onboard_0001.000s.png");
  camera.trails = false;
  fly({camera}, 1.0);
  EXPECT_EQ(read_whole_file(folder_.path() / "snapshots/onboard_0001.000s.png"), with);
}

TEST_F(SnapshotRecorderTest, LetsAFollowCameraGoRoundWhatTheWorldBlocks) {
  CameraConfig camera = small_camera("chase", CameraConfig::Type::kFollow);
  camera.vehicle = "uav1";
  camera.position_m = {-8, 0, 3};
  camera.times_s = {0.1};
  const auto picture_with = [&](bool traced) {
    info_.static_scene = traced ? std::make_shared<const StaticScene>(world_.scene()) : nullptr;
    fly({camera}, 0.1);
    return read_whole_file(folder_.path() / "snapshots/chase_0000.100s.png");
  };
  EXPECT_EQ(picture_with(true), picture_with(false)) << "nothing is in the way";
  world_.add({-3.5F, -15, 0}, {-3, 15, 6}, {0.5F, 0.5F, 0.5F}, SurfaceClass::kWall);
  EXPECT_NE(picture_with(true), picture_with(false));
}

TEST(CameraConfig, TellsItsSizeInPixels) {
  CameraConfig camera;
  EXPECT_EQ(camera.size_px(), Eigen::Vector2i(1280, 720));
  camera.width_mm = 127.0;
  camera.dpi = 100.0;
  EXPECT_EQ(camera.size_px(), Eigen::Vector2i(1280, 720)) << "a screen has no millimeters";
  camera.style = PictureMedium::kPaper;
  EXPECT_EQ(camera.size_px(), Eigen::Vector2i(500, 281));
  camera.height_mm = 50.8;
  EXPECT_EQ(camera.size_px(), Eigen::Vector2i(500, 200));
  camera.width_mm = 0.0;
  EXPECT_EQ(camera.size_px(), Eigen::Vector2i(356, 200)) << "as wide as 1280 is to 720";
}

TEST_F(SnapshotRecorderTest, NamesAVehicleThatIsNotThere) {
  CameraConfig camera = small_camera("onboard", CameraConfig::Type::kOnboard);
  camera.vehicle = "uav7";
  try {
    fly({camera}, 0.0);
    FAIL() << "no exception";
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(), "snapshots[0].vehicle: expected the name of a vehicle, found \"uav7\"");
  }
}

TEST_F(SnapshotRecorderTest, TouchesNothingWhenNoPictureIsDue) {
  CameraConfig camera = small_camera("late", CameraConfig::Type::kTop);
  camera.times_s = {100.0};
  EXPECT_TRUE(fly({camera}, 0.1).empty());
  EXPECT_TRUE(std::filesystem::is_empty(folder_.path()));
}

}  // namespace
}  // namespace swiftlet::sim
