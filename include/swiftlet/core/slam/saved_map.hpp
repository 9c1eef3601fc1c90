// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "swiftlet/core/base/map_voxels.hpp"
#include "swiftlet/core/map/submap_poses.hpp"
#include "swiftlet/core/slam/pose_graph.hpp"

namespace swiftlet {

/// Map saved for later flights: pose graph and attached clouds. Poses are in the world, as estimated by that flight.
struct SavedMap {
  struct Node {
    TimeNs t = 0;  ///< time of that flight
    int pose = 0;  ///< index in the graph
  };
  struct Submap {
    int pose = 0;  ///< index in the graph
    std::vector<Eigen::Vector3f> points_submap_m;
  };
  double voxel_m = 0.2;  ///< edge of the cubes that contain one point of a submap each
  PoseGraph graph;
  std::vector<Node> nodes;
  std::vector<Submap> submaps;
  std::vector<MapPiece> pieces;  ///< occupied and free cells, for submaps with cast rays

  const Pose& T_world_submap(const Submap& submap) const { return graph.pose(submap.pose); }
};

/// Short description of an inconsistency of the map; empty when it is valid.
std::string fault_of(const SavedMap& map);

/// Pieces of the submaps. A submap without pieces gets one from its points, without free cells.
std::vector<MapPiece> pieces_of(const SavedMap& map);
/// The map with a mapper's pieces of this flight's submaps. Unchanged when the map does not contain these.
std::shared_ptr<const SavedMap> with_pieces(std::shared_ptr<const SavedMap> map, const SubmapPoses& poses,
                                            std::span<const MapPiece> own);

/// Points of all submaps.
std::vector<Eigen::Vector3f> points_world_m(const SavedMap& map);

/// Cells of the map in another frame, all of them occupied.
void append_voxels(const SavedMap& map, const Pose& T_local_world, MapVoxels& copy);

/// Interface of estimators, and their agents, that keep such a map.
class SavedMapProvider {
 public:
  virtual ~SavedMapProvider() = default;
  /// Present map; null: none.
  virtual std::shared_ptr<const SavedMap> saved_map() const = 0;
};

}  // namespace swiftlet
