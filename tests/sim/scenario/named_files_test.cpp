// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/scenario/named_files.hpp"

#include <gtest/gtest.h>

#include "swiftlet/sim/scenario/loader.hpp"

namespace swiftlet::sim {
namespace {

TEST(NamedFiles, AreListedWithTheirKeys) {
  const Scenario scenario = load_scenario("import_mesh");
  const auto files = named_files(scenario);
  ASSERT_EQ(files.size(), 1U);
  EXPECT_EQ(files[0].key, "world.file");
  EXPECT_TRUE(files[0].path.ends_with(".obj") || files[0].path.ends_with(".ply") || files[0].path.ends_with(".stl"));
}

// (key, place) of what the first vehicle with this guidance is to reach.
std::vector<std::pair<std::string, Eigen::Vector3d>> destinations(const std::string& guidance) {
  const Scenario scenario = load_scenario("square", {{"vehicles[0].agent.guidance", guidance}});
  std::vector<std::pair<std::string, Eigen::Vector3d>> found;
  for (const NamedPlace& place : destinations_of(scenario.vehicles[0])) found.emplace_back(place.key, place.p_world_m);
  return found;
}

TEST(Destinations, AreWorldPlacesWithTheirKeys) {
  const std::string key = "agent.guidance.";
  using Found = std::vector<std::pair<std::string, Eigen::Vector3d>>;
  EXPECT_EQ(destinations("{type: waypoints, waypoints_m: [[1, 2, 3], [4, 5, 6]]}"),
            (Found{{key + "waypoints_m[0]", {1, 2, 3}}, {key + "waypoints_m[1]", {4, 5, 6}}}));
  EXPECT_EQ(destinations("{type: navigate, goals_m: [[1, 2, 3]]}"), (Found{{key + "goals_m[0]", {1, 2, 3}}}));
  EXPECT_EQ(destinations("{type: hover, at: point, point_m: [1, 2, 3]}"), (Found{{key + "point_m", {1, 2, 3}}}));
  EXPECT_EQ(destinations("{type: trajectory, shape: line, from_m: [1, 2, 3], to_m: [4, 5, 6]}"),
            (Found{{key + "from_m", {1, 2, 3}}, {key + "to_m", {4, 5, 6}}}));
  for (const char* type : {"rbl", "orca", "share_paths"}) {
    EXPECT_EQ(destinations("{type: " + std::string(type) + ", goal_m: [1, 2, 3]}"),
              (Found{{key + "goal_m", {1, 2, 3}}}))
        << type;
  }
  EXPECT_EQ(destinations("{type: bird, perches_m: [[1, 2, 3]]}"), (Found{{key + "perches_m[0]", {1, 2, 3}}}));
  for (const char* nowhere :
       {"hover", "{type: waypoints, frame: start, waypoints_m: [[1, 2, 3]]}", "{type: trajectory, shape: circle}",
        "{type: rbl, variant: 2d, goal_m: [1, 2, 3]}", "{type: rbl, lidar: {enabled: true}}",
        "{type: share_paths, planar: true}", "{type: takeoff_land}"}) {
    EXPECT_TRUE(destinations(nowhere).empty()) << nowhere;
  }
}

TEST(NamedFiles, NoneWhereNoneIsNamed) { EXPECT_TRUE(named_files(load_scenario("square")).empty()); }

}  // namespace
}  // namespace swiftlet::sim
