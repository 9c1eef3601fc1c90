// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/replay/replay.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>

#include "sim/replay/block.hpp"
#include "sim/replay/scan_tables.hpp"
#include "sim/replay/world_tables.hpp"
#include "swiftlet/sim/io/files.hpp"
#include "tests/sim/replay/decode.hpp"
#include "tests/support/synthetic_run.hpp"
#include "tests/support/temporary_directory.hpp"

namespace swiftlet::sim {
namespace {

TEST(ReplayBlock, OmitsNanAndClampsLargeValues) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  ReplayTable table("{}", {{"x", 1.0}});
  for (const double x : {1.0, std::nan(""), 2.0, kInfinity, 1e300, -1e300, 3.0}) table.add({x});
  ReplayBlock block("{}");
  block.add(table);
  const std::vector<double> read = read_block(block.bytes()).tables[0]["x"];
  EXPECT_EQ(read[0], 1.0);
  EXPECT_TRUE(std::isnan(read[1]));
  EXPECT_EQ(read[2], 2.0);
  EXPECT_TRUE(std::isnan(read[3]));
  EXPECT_EQ(read[4], (1 << 29) - 1);
  EXPECT_EQ(read[5], -((1 << 29) - 1));
  EXPECT_EQ(read[6], 3.0);
}

TEST(ReplayBlock, BytesSurviveGzip) {
  std::string bytes;
  for (int i = 0; i < 40; ++i) bytes.push_back(static_cast<char>(37 * i));
  EXPECT_EQ(gunzip(gzip(bytes)), bytes);
}

class ReplayOfMadeUpRun : public ::testing::Test {
 protected:
  std::string write(const std::string& name, const ReplayConfig& config = {}, int ticks = 450) {
    SyntheticRun run(folder_.path());
    auto recorder = make_replay_recorder(config, folder_.path() / name);
    recorder->begin(run.info());
    for (int k = 1; k <= ticks; ++k) recorder->write(run.tick(k));
    recorder->finish();
    return read_whole_file(folder_.path() / name);
  }

  TemporaryDirectory folder_;
};

TEST_F(ReplayOfMadeUpRun, IsTheSameFileTwice) { EXPECT_EQ(write("a.html"), write("b.html")); }

TEST_F(ReplayOfMadeUpRun, HoldsTrueStatesAtTheirRate) {
  const auto blocks = read_page(write("a.html"));
  ASSERT_FALSE(blocks.empty());
  EXPECT_EQ(blocks.front().about["kind"], "head");
  EXPECT_EQ(blocks.front().about["vehicles"], (nlohmann::json{"uav1", "uav-2"}));
  EXPECT_EQ(blocks.back().about["kind"], "end");
  EXPECT_EQ(blocks.back().about["t_s"], 4.5);

  SyntheticRun again(folder_.path());
  std::map<int, Vector3> truth_world_m;  // positions of the first vehicle by tick
  for (int k = 1; k <= 450; ++k) truth_world_m[k] = again.tick(k).states[0].p_world_m;
  std::size_t rows = 0;
  for (const ReadBlock& block : blocks) {
    for (const ReadTable& table : block.tables) {
      if (table.about["table"] != "state" || table.about["vehicle"] != 0) continue;
      for (std::size_t i = 0; i < table.rows(); ++i, ++rows) {
        const Vector3& p = truth_world_m.at(static_cast<int>(std::lround(100.0 * table["t_s"][i])));
        EXPECT_NEAR(table["x_m"][i], p.x(), 0.002);
        EXPECT_NEAR(table["z_m"][i], p.z(), 0.002);
      }
    }
  }
  EXPECT_NEAR(static_cast<double>(rows), 4.5 * 20.0, 2.0);
}

TEST_F(ReplayOfMadeUpRun, HoldsEveryKindOfRecordedData) {
  std::map<std::string, std::size_t> rows;
  for (const ReadBlock& block : read_page(write("a.html"))) {
    for (const ReadTable& table : block.tables) rows[table.about["table"].get<std::string>()] += table.rows();
  }
  for (const char* kind : {"state", "detections", "tracks", "scan", "radio", "series", "overlay"})
    EXPECT_GT(rows[kind], 0U) << kind;
}

TEST_F(ReplayOfMadeUpRun, OmitsDataAtZeroRate) {
  ReplayConfig config;
  config.scan_rate_hz = config.overlay_rate_hz = 0.0;
  for (const ReadBlock& block : read_page(write("a.html", config))) {
    for (const ReadTable& table : block.tables) {
      EXPECT_NE(table.about["table"], "scan");
      EXPECT_NE(table.about["table"], "overlay");
    }
  }
}

TEST_F(ReplayOfMadeUpRun, RequestsOverlaysOnlyAtTheirRate) {
  SyntheticRun run(folder_.path());
  ReplayConfig config;
  config.overlay_rate_hz = 2.0;
  auto recorder = make_replay_recorder(config, folder_.path() / "a.html");
  recorder->begin(run.info());
  int requests = 0;
  for (int k = 1; k <= 400; ++k) {
    requests += recorder->wants_overlays(k * SyntheticRun::kTick) ? 1 : 0;
    recorder->write(run.tick(k));
  }
  EXPECT_NEAR(requests, 8, 1);
}

TEST_F(ReplayOfMadeUpRun, LeavesNothingAfterAnEarlyEnd) {
  SyntheticRun run(folder_.path());
  {
    auto recorder = make_replay_recorder({}, folder_.path() / "a.html");
    recorder->begin(run.info());
    recorder->write(run.tick(1));
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder_.path()));
}

TEST_F(ReplayOfMadeUpRun, NamesNeverBecomeMarkup) {
  SyntheticRun run(folder_.path());
  RunInfo info = run.info();
  info.scenario = "</script><script>alert('replay')</script>";
  info.vehicle_names[0] = "<img src=x onerror=alert(1)>\xff";
  auto recorder = make_replay_recorder({}, folder_.path() / "a.html");
  recorder->begin(info);
  recorder->write(run.tick(1));
  recorder->finish();
  const std::string page = read_whole_file(folder_.path() / "a.html");
  EXPECT_EQ(page.find("alert('replay')"), std::string::npos);
  EXPECT_EQ(page.find("onerror"), std::string::npos);
  EXPECT_NE(page.find("default-src 'none'"), std::string::npos);
  EXPECT_EQ(read_page(page).front().about["scenario"], info.scenario);
}

TEST(ReplayScan, PlacesPointsThinnedToTheLimit) {
  TemporaryDirectory folder;
  SyntheticRun run(folder.path());
  const TickView& tick = run.tick(10);  // frozen after tick 20, rolling after tick 10
  const LabeledScan& labeled = *tick.scans[0].front();
  ReplayBlock all("{}"), few("{}");
  const std::size_t count = append_scan(labeled, 0, 100000, 0, all);
  std::size_t hits = 0;
  for (int i = 0; i < labeled.scan.size(); ++i) hits += labeled.scan.hit(i) ? 1 : 0;
  EXPECT_EQ(count, hits);
  const ReadBlock read = read_block(all.bytes());
  const ReadTable &points = read.tables[0], &poses = read.tables[1];
  EXPECT_EQ(points.about["sensor"], "os1");
  EXPECT_EQ(poses.rows(), 5U);
  for (std::size_t i = 0; i < points.rows(); ++i) {
    const int beam = static_cast<int>(points["row"][i]) * labeled.scan.cols() + static_cast<int>(points["col"][i]);
    const double az = points["azimuth_rad"][i], el = points["elevation_rad"][i], r = points["range_m"][i];
    const Vector3 p_lidar_m = r * Vector3(std::cos(el) * std::cos(az), std::cos(el) * std::sin(az), std::sin(el));
    EXPECT_LT((p_lidar_m - labeled.scan.point_lidar(beam).cast<double>()).norm(),
              0.15);  // made-up beams begin anywhere
    EXPECT_NEAR(points["intensity_dB"][i], std::max(-40.0, 10.0 * std::log10(labeled.scan.intensity[beam])), 0.51);
    EXPECT_EQ(points["class"][i], labeled.truth.surface_class[beam]);
    EXPECT_EQ(points["instance"][i], labeled.truth.instance[beam]);
  }
  EXPECT_LE(append_scan(labeled, 0, 20, 0, few), 20U);
}

TEST(ReplayScan, AlwaysKeepsReturnsFromOtherVehicles) {
  TemporaryDirectory folder;
  SyntheticRun run(folder.path());
  LabeledScan labeled = *run.tick(10).scans[0].front();
  std::size_t others = 0;
  for (int i = 0; i < labeled.scan.size(); i += 3) {
    labeled.truth.surface_class[i] = static_cast<std::uint16_t>(SurfaceClass::kVehicle);
    labeled.truth.instance[i] = i % 2 == 0 ? 1 : 2;  // the vehicle itself, or the other one
    others += labeled.scan.hit(i) && i % 2 == 1 ? 1 : 0;
  }
  ReplayBlock block("{}");
  append_scan(labeled, 0, 1, 0, block);
  const ReadTable points = read_block(block.bytes()).tables[0];
  std::size_t kept = 0;
  for (std::size_t i = 0; i < points.rows(); ++i)
    kept += points["class"][i] == 300 && points["instance"][i] == 2 ? 1 : 0;
  EXPECT_EQ(kept, others);
}

/// A square of n x n cells, and as many loose leaves above.
Scene square_with_leaves(int n) {
  Scene scene;
  scene.materials.resize(1);
  scene.meshes.resize(2);
  Mesh &ground = scene.meshes[0], &leaves = scene.meshes[1];
  ground.surface_class = SurfaceClass::kGround;
  leaves.surface_class = SurfaceClass::kVegetation;
  for (int y = 0; y <= n; ++y) {
    for (int x = 0; x <= n; ++x) ground.vertices_mesh_m.emplace_back(0.1F * x, 0.1F * y, 0.0F);
  }
  const auto at = [&](int x, int y) { return static_cast<std::uint32_t>(y * (n + 1) + x); };
  for (int y = 0; y < n; ++y) {
    for (int x = 0; x < n; ++x) {
      ground.triangles.push_back({at(x, y), at(x + 1, y), at(x, y + 1)});
      ground.triangles.push_back({at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)});
      const auto first = static_cast<std::uint32_t>(leaves.vertices_mesh_m.size());
      for (const auto& [dx, dy] : {std::pair(0.0F, 0.0F), {0.05F, 0.0F}, {0.0F, 0.05F}})
        leaves.vertices_mesh_m.emplace_back(0.1F * x + dx, 0.1F * y + dy, 5.0F);
      leaves.triangles.push_back({first, first + 1, first + 2});
    }
  }
  for (std::uint32_t mesh = 0; mesh < 2; ++mesh) scene.instances.push_back({mesh, Eigen::Affine3f::Identity(), 0});
  return scene;
}

TEST(ReplayWorld, CoarsensOnlyLargeWorlds) {
  const Scene scene = square_with_leaves(40);
  const auto triangles = [&](std::size_t most) {
    ReplayBlock block("{}");
    append_world(scene, most, block);
    std::vector<std::size_t> counts;
    for (const ReadTable& table : read_block(block.bytes()).tables) {
      if (table.about["table"] == "triangles") counts.push_back(table.rows());
    }
    return counts;
  };
  EXPECT_EQ(triangles(100000), (std::vector<std::size_t>{3200, 1600}));
  const auto coarse = triangles(1000);
  EXPECT_LE(coarse[0] + coarse[1], 1010U);
  EXPECT_GT(coarse[0], 50U);
  EXPECT_GT(coarse[1], 50U);
}

}  // namespace
}  // namespace swiftlet::sim
