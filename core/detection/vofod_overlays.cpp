// SPDX-License-Identifier: BSD-3-Clause
#include "core/detection/vofod_overlays.hpp"

#include <utility>

#include "core/detection/detection_spheres.hpp"

namespace swiftlet {
namespace {

// [-] Edges of drawn cubes in voxel edges. Gaps between cubes keep neighbors, and points inside, visible.
constexpr float kOccupiedCube = 0.8F, kAroundCube = 0.4F;
// [m] Diameter of the points of clusters. Larger points hide their neighbors.
constexpr float kPointSize_m = 0.08F;

Overlay overlay_of(const char* name, Overlay::Kind kind, float size_m, std::vector<Overlay::Key> legend) {
  Overlay overlay;
  overlay.name = name;
  overlay.kind = kind;
  overlay.size_m = size_m;
  overlay.legend = std::move(legend);
  if (overlay.legend.size() == 1) overlay.colors = {overlay.legend.front().color};
  return overlay;
}

Eigen::Vector3f center_m(const VoxelMap& map, std::ptrdiff_t voxel) {
  return map.grid().center_m(map.grid().cell(voxel)).cast<float>();
}

// The colors are translucent, because the points of the background lie inside the cubes.
void append_occupied(const VoxelMap& map, std::vector<Overlay>& overlays) {
  const auto edge_m = static_cast<float>(map.grid().edge_m);
  Overlay tentative = overlay_of("voxels.tentative", Overlay::Kind::kCubes, kOccupiedCube * edge_m,
                                 {{"voxel: tentative occupied", {0.95F, 0.6F, 0.1F, 0.4F}}});
  Overlay confident = overlay_of("voxels.confident", Overlay::Kind::kCubes, kOccupiedCube * edge_m,
                                 {{"voxel: confident occupied", {0.45F, 0.48F, 0.55F, 0.3F}}});
  map.for_each_occupied([&](std::ptrdiff_t i) {
    (map.state(i) == VoxelState::kConfident ? confident : tentative).positions.push_back(center_m(map, i));
  });
  overlays.push_back(std::move(tentative));
  overlays.push_back(std::move(confident));
}

// The free and uncertain voxels in a horizontal disc around each detection. An object flies if it is surrounded by free
// voxels.
Overlay overlay_around(const VoxelMap& map, double search_distance_m, std::span<const Detection> detections) {
  const Eigen::Vector4f kFree = {0.15F, 0.75F, 0.4F, 0.45F}, kUncertain = {0.7F, 0.3F, 0.95F, 0.8F};
  const VoxelGrid& grid = map.grid();
  Overlay overlay =
      overlay_of("voxels.around", Overlay::Kind::kCubes, kAroundCube * static_cast<float>(grid.edge_m),
                 {{"around a detection: confident free", kFree}, {"around a detection: uncertain", kUncertain}});
  const int reach = static_cast<int>(search_distance_m / grid.edge_m);
  for (const Detection& d : detections) {
    const Cell middle = grid.cell_of(d.position_m);
    for (int y = -reach; y <= reach; ++y) {
      for (int x = -reach; x <= reach; ++x) {
        const Cell cell = middle + Cell(x, y, 0);
        if (x * x + y * y > reach * reach || !grid.contains(cell)) continue;
        const VoxelState state = map.state(grid.index(cell));
        if (state > VoxelState::kUncertain) continue;
        overlay.positions.push_back(center_m(map, grid.index(cell)));
        overlay.colors.push_back(state == VoxelState::kFree ? kFree : kUncertain);
      }
    }
  }
  return overlay;
}

Overlay overlay_of_clusters(const VofodStages& stages) {
  const Eigen::Vector4f kBlue = {0.2F, 0.4F, 0.95F, 1.0F}, kYellow = {0.95F, 0.85F, 0.1F, 1.0F},
                        kRed = {0.95F, 0.1F, 0.1F, 1.0F};
  Overlay overlay = overlay_of(
      "clusters", Overlay::Kind::kPoints, kPointSize_m,
      {{"cluster: background (A)", kBlue}, {"cluster: flying (B)", kRed}, {"cluster: unknown (C)", kYellow}});
  const auto paint = [&](ClusterClass of_class, const Eigen::Vector4f& color) {
    stages.append_cluster_points(of_class, overlay.positions);
    overlay.colors.resize(overlay.positions.size(), color);
  };
  paint(ClusterClass::kBackground, kBlue);
  paint(ClusterClass::kTooLarge, kBlue);
  paint(ClusterClass::kUnknown, kYellow);
  paint(ClusterClass::kFlying, kRed);
  return overlay;
}

}  // namespace

void append_vofod_overlays(const VofodStages& stages, double search_distance_m, std::span<const Detection> detections,
                           std::vector<Overlay>& overlays) {
  append_occupied(stages.map(), overlays);
  overlays.push_back(overlay_around(stages.map(), search_distance_m, detections));
  overlays.push_back(overlay_of_clusters(stages));
  Overlay spheres = detection_spheres();
  for (const Detection& d : detections) spheres.positions.push_back(d.position_m.cast<float>());
  overlays.push_back(std::move(spheres));
}

}  // namespace swiftlet
