// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/render/snapshot_recorder.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <png.h>

#include <algorithm>
#include <cstdio>

#include "render_support.hpp"
#include "sim/render/picture_scene.hpp"
#include "swiftlet/sim/errors/errors.hpp"
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

TEST(PictureScene, MatchesOverlayNamesWithOptionalVehicle) {
  const auto chosen = [](const std::string& name, std::vector<std::string> names) {
    Overlay overlay;
    overlay.name = name;
    return is_chosen(overlay, names);
  };
  EXPECT_TRUE(chosen("uav1/path", {"path"}));
  EXPECT_TRUE(chosen("uav1/path", {"other", "uav1/path"}));
  EXPECT_TRUE(chosen("uav1/path", {"*"}));
  EXPECT_TRUE(chosen("path", {"path"}));
  EXPECT_FALSE(chosen("uav1/path", {"uav2/path"}));
  EXPECT_FALSE(chosen("uav1/path", {"uav1"}));
  EXPECT_FALSE(chosen("uav1/path", {}));
}

TEST(Trail, KeepsItsEndsInBoundedMemory) {
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

TEST(PictureScene, KeepsClassAndReflectivityOfReturns) {
  LabeledScan labeled;
  auto beams = std::make_shared<BeamTable>();
  beams->rows = 2;
  beams->cols = 3;
  beams->directions_lidar.assign(6, Eigen::Vector3f::UnitX());
  beams->origins_lidar.assign(6, Eigen::Vector3f::Zero());
  labeled.scan.beams = beams;
  labeled.scan.range_m = {1, 0, 3, 4, 5, 0};
  labeled.scan.reflectivity = {0.1F, 0.2F, 0.3F, 0.4F, 0.5F, 0.6F};
  labeled.truth.surface_class = {10, 11, 12, 13, 14, 15};
  EXPECT_TRUE(cloud_of(labeled, 2).points_world_m.empty()) << "without a pose";
  for (int column = 0; column < 3; ++column)
    labeled.truth.T_world_lidar.push_back(make_pose({100.0 * column, 0, 0}, Eigen::Quaterniond::Identity()));
  const PictureCloud rolling = cloud_of(labeled, 2);
  EXPECT_EQ(rolling.vehicle, 2);
  EXPECT_EQ(rolling.points_world_m, (std::vector<Eigen::Vector3f>{{1, 0, 0}, {203, 0, 0}, {4, 0, 0}, {105, 0, 0}}));
  EXPECT_EQ(rolling.surface_class, (std::vector<std::uint16_t>{10, 12, 13, 14}));
  EXPECT_EQ(rolling.intensity, (std::vector<float>{0.1F, 0.3F, 0.4F, 0.5F}));
  labeled.truth.T_world_lidar.resize(1);
  labeled.scan.reflectivity.clear();
  labeled.truth.surface_class.pop_back();
  const PictureCloud frozen = cloud_of(labeled, 2);
  EXPECT_EQ(frozen.points_world_m[1], Eigen::Vector3f(3, 0, 0));
  EXPECT_TRUE(frozen.intensity.empty() && frozen.surface_class.empty());
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

TEST_F(SnapshotRecorderTest, WritesCameraPicturesAtTheirTimes) {
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

TEST_F(SnapshotRecorderTest, WritesPaperAsPngAndSvg) {
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

TEST_F(SnapshotRecorderTest, OmitsTrailAndMarksOnBoard) {
  // In backward flight, uav1 would look along its own trail, as wide as the picture.
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

TEST_F(SnapshotRecorderTest, MovesFollowCamerasAroundObstacles) {
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

TEST(CameraConfig, ReportsItsSizeInPixels) {
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

TEST_F(SnapshotRecorderTest, RefusesUnknownVehicles) {
  CameraConfig camera = small_camera("onboard", CameraConfig::Type::kOnboard);
  camera.vehicle = "uav7";
  try {
    fly({camera}, 0.0);
    FAIL() << "no exception";
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(), "snapshots[0].vehicle: expected the name of a vehicle, found \"uav7\"");
  }
}

TEST_F(SnapshotRecorderTest, ChangesNothingWithoutDuePictures) {
  CameraConfig camera = small_camera("late", CameraConfig::Type::kTop);
  camera.times_s = {100.0};
  EXPECT_TRUE(fly({camera}, 0.1).empty());
  EXPECT_TRUE(std::filesystem::is_empty(folder_.path()));
}

/// The texts of an SVG file.
std::vector<std::string> texts_of(const std::string& svg) {
  std::vector<std::string> texts;
  for (std::size_t at = svg.find("<text"); at != std::string::npos; at = svg.find("<text", at + 1)) {
    const std::size_t begin = svg.find('>', at) + 1;
    texts.push_back(svg.substr(begin, svg.find('<', begin) - begin));
  }
  return texts;
}

class PaperTest : public SnapshotRecorderTest {
 protected:
  static CameraConfig paper(const char* name, CameraConfig::Type type) {
    CameraConfig camera = small_camera(name, type);
    camera.style = PictureMedium::kPaper;
    camera.width_mm = 40.0;
    camera.height_mm = 30.0;
    camera.dpi = 130.0;
    camera.text_pt = 4.0;
    camera.times_s = {0.1};
    return camera;
  }
  /// SVGs of cameras with different names, from one flight.
  std::vector<std::string> svgs_of(const std::vector<CameraConfig>& cameras) {
    fly(cameras, 0.1);
    std::vector<std::string> svgs;
    svgs.reserve(cameras.size());
    for (const CameraConfig& camera : cameras)
      svgs.push_back(read_whole_file(folder_.path() / "snapshots" / (camera.name + "_0000.100s.svg")));
    return svgs;
  }
  std::string svg_of(const CameraConfig& camera) { return svgs_of({camera}).front(); }
  std::shared_ptr<const LabeledScan> scan(const std::string& sensor, float range_m) {
    auto labeled = std::make_shared<LabeledScan>();
    auto beams = std::make_shared<BeamTable>();
    beams->rows = 1;
    beams->cols = 4;
    beams->directions_lidar = {{1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}};
    beams->origins_lidar.assign(4, Eigen::Vector3f::Zero());
    labeled->scan.beams = beams;
    labeled->scan.sensor = sensor;
    labeled->scan.range_m.assign(4, range_m);
    labeled->scan.intensity.assign(4, 0.5F);
    labeled->scan.reflectivity.assign(4, 0.5F);
    labeled->truth.surface_class = {71, 71, 71, 351};
    labeled->truth.instance.assign(4, 1);
    labeled->truth.T_world_lidar = {make_pose({0, 0, 2}, Eigen::Quaterniond::Identity())};
    return labeled;
  }
};

TEST_F(PaperTest, NamesScenarioCameraAndVehicle) {
  info_.scenario = "forest";
  CameraConfig second = paper("second", CameraConfig::Type::kFollow);
  second.vehicle = "uav2";
  const std::vector<std::string> svgs =
      svgs_of({paper("top", CameraConfig::Type::kTop), paper("chase", CameraConfig::Type::kFollow), second,
               paper("eye", CameraConfig::Type::kOnboard), paper("pole", CameraConfig::Type::kFixed)});
  EXPECT_THAT(svgs[0], testing::HasSubstr("<title>forest  /  top, t = 0.100 s"));
  EXPECT_THAT(svgs[1], testing::HasSubstr("<title>forest  /  chase, t"));
  EXPECT_THAT(svgs[2], testing::HasSubstr("<title>forest  /  second  /  uav2, t"));
  EXPECT_THAT(svgs[3], testing::HasSubstr("<title>forest  /  eye  /  uav1, t"));
  EXPECT_THAT(svgs[4], testing::HasSubstr("<title>forest  /  pole, t"));
}

TEST_F(PaperTest, ExplainsTheColorsOfClouds) {
  using testing::Contains;
  using testing::Not;
  const auto camera = [](const char* name, CloudColors by) {
    CameraConfig made = paper(name, CameraConfig::Type::kTop);
    made.cloud = by;
    made.span_m = 30.0;
    return made;
  };
  const CameraConfig by_vehicle = camera("vehicle", CloudColors::kVehicle),
                     by_intensity = camera("intensity", CloudColors::kIntensity);
  scans_[0] = {scan("os1", 3.0F)};
  scans_[1] = {scan("os2", 5.0F)};
  const std::vector<std::string> svgs =
      svgs_of({camera("none", CloudColors::kNone), by_intensity, by_vehicle, camera("height", CloudColors::kHeight),
               camera("label", CloudColors::kLabel)});
  EXPECT_THAT(texts_of(svgs[0]), Not(Contains("z [m]")));
  EXPECT_THAT(texts_of(svgs[1]), Contains("reflectivity [-]"));
  EXPECT_THAT(texts_of(svgs[2]), Contains("scan of uav1"));
  EXPECT_THAT(texts_of(svgs[2]), Contains("scan of uav2"));
  EXPECT_THAT(texts_of(svgs[3]), Contains("z [m]"));
  EXPECT_THAT(texts_of(svgs[4]), Contains("trunk"));
  EXPECT_THAT(texts_of(svgs[4]), Contains("wall"));
  EXPECT_THAT(texts_of(svgs[4]), Not(Contains("z [m]")));
  scans_[0].clear();
  scans_[1].clear();
  const std::vector<std::string> without = svgs_of({by_vehicle, by_intensity});
  EXPECT_THAT(texts_of(without[0]), Not(Contains("scan of uav2")));
  EXPECT_THAT(texts_of(without[1]), Not(Contains("reflectivity [-]"))) << "no scan, nothing to explain";
}

TEST_F(PaperTest, ShowsTheScanOfItsSensor) {
  CameraConfig camera = paper("lidar", CameraConfig::Type::kLidarRange);
  const auto texts_for = [&](const std::string& vehicle, const std::string& sensor) {
    camera.vehicle = vehicle;
    camera.sensor = sensor;
    return texts_of(svg_of(camera));
  };
  EXPECT_THAT(texts_for("", ""), ElementsAre("no scan yet"));
  scans_[0] = {scan("os1", 3.0F), scan("puck", 90.0F)};
  scans_[1] = {scan("os2", 700.0F)};
  const auto end_of_scale = [&](const std::string& vehicle, const std::string& sensor) {
    double most = 0.0;
    for (const std::string& text : texts_for(vehicle, sensor)) {
      if (text.find_first_not_of("0123456789.") == std::string::npos) most = std::max(most, std::stod(text));
    }
    return most;
  };
  EXPECT_NEAR(end_of_scale("", ""), 3.0, 1.0) << "the first one of the first";
  EXPECT_NEAR(end_of_scale("uav1", "puck"), 100.0, 20.0);
  EXPECT_NEAR(end_of_scale("uav2", ""), 800.0, 200.0);
  EXPECT_THAT(texts_for("uav2", "puck"), ElementsAre("no scan yet"));
  camera.max_range_m = 50.0;
  EXPECT_NEAR(end_of_scale("uav1", "os1"), 50.0, 10.0);
  camera.type = CameraConfig::Type::kLidarIntensity;
  EXPECT_THAT(texts_for("uav2", ""), testing::Contains("power [dB]"));
}

TEST_F(PaperTest, WritesDepthInMillimeters) {
  CameraConfig camera = paper("depth", CameraConfig::Type::kDepth);
  camera.position_m = {0, 0, 0.6};
  camera.target_m = {1, 0, -0.4};
  EXPECT_THAT(texts_of(svg_of(camera)), testing::Contains("depth [m]"));
  const Eigen::Vector2i size = camera.size_px();
  std::FILE* file = std::fopen((folder_.path() / "snapshots/depth_0000.100s.mm.png").c_str(), "rb");
  ASSERT_NE(file, nullptr);
  png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(png);
  png_init_io(png, file);
  png_read_info(png, info);
  ASSERT_EQ(static_cast<int>(png_get_image_width(png, info)), size.x());
  std::vector<std::uint8_t> row(2 * static_cast<std::size_t>(size.x()));
  for (int y = 0; y <= size.y() / 2; ++y) png_read_row(png, row.data(), nullptr);
  png_destroy_read_struct(&png, &info, nullptr);
  std::fclose(file);
  const int middle = 2 * (size.x() / 2);  // the floor straight ahead, 2.6 m below at 45 degrees
  EXPECT_NEAR(256 * row[middle] + row[middle + 1], 1000.0 * 2.6 * std::sqrt(2.0), 60.0);
}

}  // namespace
}  // namespace swiftlet::sim
