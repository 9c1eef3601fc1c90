// SPDX-License-Identifier: BSD-3-Clause
#include "sim/run/prior_map.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "swiftlet/sim/errors/errors.hpp"
#include "tests/support/temporary_directory.hpp"

namespace swiftlet::sim {
namespace {

class PriorMapTest : public ::testing::Test {
 protected:
  std::string write(const char* name, const std::string& text) const {
    std::ofstream(directory_.path() / name) << text;
    return (directory_.path() / name).string();
  }
  /// A cloud of points in text.
  std::string write_cloud(const char* name, const std::string& points) const {
    const auto count = std::to_string(std::count(points.begin(), points.end(), '\n'));
    return write(name, "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH " + count +
                           "\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " + count + "\nDATA ascii\n" + points);
  }

 private:
  TemporaryDirectory directory_;
};

Scene one_triangle() {
  Scene scene;
  Mesh mesh;
  mesh.vertices_mesh_m = {{0.0F, 0.0F, 0.1F}, {4.0F, 0.0F, 0.1F}, {0.0F, 3.0F, 0.1F}};
  mesh.triangles = {{0, 1, 2}};
  scene.meshes.push_back(mesh);
  Instance instance;
  instance.T_world_mesh.translation() = Eigen::Vector3f(10.0F, 0.0F, 0.0F);
  scene.instances.push_back(instance);
  return scene;
}

TEST_F(PriorMapTest, SamplesSurfacesDensely) {
  PriorConfig config;
  config.world = true;
  const auto prior = make_prior_map(config, 0.25, one_triangle());
  ASSERT_NE(prior, nullptr);
  std::set<std::pair<int, int>> cells;
  for (const Eigen::Vector3f& p : prior->occupied_world_m) {
    EXPECT_FLOAT_EQ(p.z(), 0.1F);
    cells.emplace(static_cast<int>(std::floor((p.x() - 10.0F) / 0.25F)), static_cast<int>(std::floor(p.y() / 0.25F)));
  }
  // Every cell whose center lies in the triangle has a point.
  for (int x = 0; x < 16; ++x) {
    for (int y = 0; y < 12; ++y) {
      const double cx = (x + 0.5) * 0.25, cy = (y + 0.5) * 0.25;
      if (cx / 4.0 + cy / 3.0 < 1.0) {
        EXPECT_TRUE(cells.contains({x, y})) << x << ' ' << y;
      }
    }
  }
}

TEST_F(PriorMapTest, IsAbsentUnlessRequested) { EXPECT_EQ(make_prior_map({}, 0.25, one_triangle()), nullptr); }

TEST_F(PriorMapTest, ReadsClouds) {
  write_cloud("000000.pcd", "1 2 3\n");
  write_cloud("000001.pcd", "4 5 6\n");
  PriorConfig config;
  config.recorded = write("pcd_index.csv", "file,stamp_s\n000000.pcd,0.0\n000001.pcd,0.1\n");
  config.free = write_cloud("free.pcd", "7 8 9\n");
  const auto prior = make_prior_map(config, 0.25, Scene{});
  ASSERT_NE(prior, nullptr);
  EXPECT_EQ(prior->occupied_world_m, (std::vector<Eigen::Vector3f>{{1.0F, 2.0F, 3.0F}, {4.0F, 5.0F, 6.0F}}));
  EXPECT_EQ(prior->free_world_m, (std::vector<Eigen::Vector3f>{{7.0F, 8.0F, 9.0F}}));
  config = {};
  config.occupied = write_cloud("two.pcd", "1 2 3\n-4 5 6\n");
  EXPECT_EQ(make_prior_map(config, 0.25, Scene{})->occupied_world_m,
            (std::vector<Eigen::Vector3f>{{1.0F, 2.0F, 3.0F}, {-4.0F, 5.0F, 6.0F}}));
  config.recorded = write("other.csv", "x,y,z\n1,2,3\n");
  EXPECT_THROW(make_prior_map(config, 0.25, Scene{}), InputError);
}

TEST_F(PriorMapTest, SamplesMeshesAndCountsSkippedFaces) {
  const std::string wall = "v 0 0 0\nv 4 0 0\nv 4 0 2\nv 0 0 2\nf 1 2 3\nf 1 3 4\n";
  PriorConfig config;
  config.mesh = write("wall.obj", wall);
  const auto mesh = make_prior_map(config, 0.25, Scene{});
  ASSERT_NE(mesh, nullptr);
  EXPECT_GT(mesh->occupied_world_m.size(), 100U);
  for (const Eigen::Vector3f& p : mesh->occupied_world_m) EXPECT_NEAR(p.y(), 0.0F, 1e-5F);
  ASSERT_EQ(mesh->counters.size(), 1U);
  EXPECT_EQ(mesh->counters[0].count, 0U);
  config.mesh = write("wall.obj", wall + "f 1 2\n");
  EXPECT_EQ(make_prior_map(config, 0.25, Scene{})->counters.at(0).count, 1U);
  EXPECT_EQ(make_prior_map(config, 0.25, Scene{})->counters.at(0).setting, "prior.mesh");
}

TEST_F(PriorMapTest, RefusesFilesWithoutFinitePoints) {
  PriorConfig occupied, free, recorded;
  occupied.occupied = free.free = write_cloud("nan.pcd", "nan nan nan\nnan nan nan\n");
  recorded.recorded = write("pcd_index.csv", "file,stamp_s\nnan.pcd,0.0\n");
  for (const PriorConfig& config : {occupied, free, recorded}) {
    try {
      make_prior_map(config, 0.25, Scene{});
      ADD_FAILURE() << "nothing was thrown";
    } catch (const InputError& problem) {
      EXPECT_NE(std::string(problem.what()).find("finite coordinates"), std::string::npos) << problem.what();
    }
  }
}

TEST_F(PriorMapTest, RefusesFilesThatAreNoIndex) {
  for (const std::string& file : {write("notes.csv", "t_s,x_m\n0,1\n"), std::string("/nowhere/pcd_index.csv")}) {
    PriorConfig config;
    config.recorded = file;
    try {
      make_prior_map(config, 0.25, Scene{});
      ADD_FAILURE() << "nothing was thrown";
    } catch (const InputError& problem) {
      EXPECT_NE(std::string(problem.what()).find("prior.recorded: "), std::string::npos) << problem.what();
      EXPECT_NE(std::string(problem.what()).find(file), std::string::npos) << problem.what();
    }
  }
}

}  // namespace
}  // namespace swiftlet::sim
