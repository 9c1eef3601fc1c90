// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/world/two_rooms_gap.hpp"

#include "sim/world/building.hpp"
#include "sim/world/materials.hpp"
#include "sim/world/scene_builder.hpp"
#include "swiftlet/core/math/angles.hpp"

namespace swiftlet::sim {
namespace {

// [m] Thickness of the walls, and thus depth of the gap. Larger values make a deeper gap that hides more behind it.
constexpr double kRoomWall_m = 0.2;
// [m] Thickness of the ceiling. Only its lower side is seen from inside.
constexpr double kCeiling_m = 0.15;
// [m] Width of the floor outside of the building. Larger values give vehicles outside a larger ground.
constexpr double kFloorMargin_m = 5.0;
// [-] Factors of safe distance and map resolution in the width of the gap [Pritzl 2024, eq. 1].
constexpr double kSafeDistances = 2.0, kMapResolutions = 1.5;

}  // namespace

void TwoRoomsGapConfig::visit(ConfigVisitor& v) {
  v.field("gap_width_m", gap_width_m,
          "[m] width of the gap; 0: 2 safe_distance_m + 1.5 map_resolution_m [Pritzl 2024, eq. 1]",
          Range::non_negative());
  v.field("safe_distance_m", safe_distance_m, "[m] safe distance d_S of the planner, in the formula of gap_width_m",
          Range::positive());
  v.field("map_resolution_m", map_resolution_m, "[m] voxel size of the planner's map, in the formula of gap_width_m",
          Range::positive());
  v.field("gap_height_m", gap_height_m, "[m] height of the gap; 0: height_m", Range::non_negative());
  v.field("gap_offset_m", gap_offset_m,
          "[m] displacement of the rooms relative to the gap, to the left in the direction of yaw_deg");
  v.field("room_size_m", room_size_m, "[m] inner size of each room: along the path through the gap, and across it",
          Range::positive());
  v.field("height_m", height_m, "[m] inner height of the rooms", Range::positive());
  v.field("yaw_deg", yaw_deg, "[deg] direction of the path through the gap, in the world");
  v.field("position_m", position_m, "[m] position of the center of the gap, world frame");
  v.check(gap_width() + 2.0 * std::abs(gap_offset_m) < room_size_m.y(), "gap_width_m", "a gap that fits into its wall");
  v.check(gap_height_m <= height_m, "gap_height_m", "at most height_m");
}

double TwoRoomsGapConfig::gap_width() const {
  return gap_width_m > 0.0 ? gap_width_m : kSafeDistances * safe_distance_m + kMapResolutions * map_resolution_m;
}

Scene make_two_rooms_gap(const TwoRoomsGapConfig& config, std::uint64_t /*seed*/) {
  const double yaw_rad = radians(config.yaw_deg);
  const Eigen::Vector2d& room_m = config.room_size_m;
  const double thickness_m = kRoomWall_m;
  const double gap_top_m = config.gap_height_m > 0.0 ? config.gap_height_m : config.height_m;

  // Middle planes of the walls in the building's frame, with the origin in the gap and the x axis through it.
  const double end_x = room_m.x() + thickness_m;
  const double low_y = config.gap_offset_m - 0.5 * (room_m.y() + thickness_m);
  const double high_y = config.gap_offset_m + 0.5 * (room_m.y() + thickness_m);
  const double corner_m = 0.5 * thickness_m;  // extension of walls along x, shortening of walls along y
  Mesh walls;
  add_wall(walls, {-end_x - corner_m, low_y}, {end_x + corner_m, low_y}, config.height_m, thickness_m);
  add_wall(walls, {-end_x - corner_m, high_y}, {end_x + corner_m, high_y}, config.height_m, thickness_m);
  add_wall(walls, {-end_x, low_y + corner_m}, {-end_x, high_y - corner_m}, config.height_m, thickness_m);
  add_wall(walls, {end_x, low_y + corner_m}, {end_x, high_y - corner_m}, config.height_m, thickness_m);
  const Opening gap = {-(low_y + corner_m), config.gap_width(), 0.0, gap_top_m};
  add_wall(walls, {0.0, low_y + corner_m}, {0.0, high_y - corner_m}, config.height_m, thickness_m, {&gap, 1});

  Mesh floor;
  const Eigen::Vector2d margin_m(kFloorMargin_m, kFloorMargin_m);
  add_floor(floor, Eigen::Vector2d(-end_x, low_y) - margin_m, Eigen::Vector2d(end_x, high_y) + margin_m, 0.0);
  Mesh ceiling;
  add_wall(ceiling, {-end_x - corner_m, config.gap_offset_m}, {end_x + corner_m, config.gap_offset_m}, kCeiling_m,
           room_m.y() + 2.0 * thickness_m, {}, config.height_m);

  SceneBuilder scene;
  const Eigen::Vector3d gap_foot_m(config.position_m.x(), config.position_m.y(), 0.0);
  const Eigen::Affine3f T_world_building = transform(gap_foot_m.cast<float>(), static_cast<float>(yaw_rad));
  scene.place(scene.add_mesh(std::move(floor), materials::concrete(), SurfaceClass::kGround), 0, T_world_building);
  scene.place(scene.add_mesh(std::move(walls), materials::plaster(), SurfaceClass::kWall), 1, T_world_building);
  scene.place(scene.add_mesh(std::move(ceiling), materials::concrete(), SurfaceClass::kCeiling), 1, T_world_building);
  scene.add_object({1,
                    SurfaceClass::kDoor,
                    "gap",
                    gap_foot_m + Eigen::Vector3d(0, 0, 0.5 * gap_top_m),
                    yaw_rad,
                    {{"width_m", config.gap_width()}, {"height_m", gap_top_m}}});
  return scene.finish();
}

}  // namespace swiftlet::sim
