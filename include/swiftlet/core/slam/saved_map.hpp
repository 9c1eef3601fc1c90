// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "swiftlet/core/map/submap_poses.hpp"
#include "swiftlet/core/map_voxels.hpp"
#include "swiftlet/core/slam/pose_graph.hpp"

namespace swiftlet {

/// What a flight keeps for later ones: its pose graph and the clouds that hang on it. Poses are in the world, as far as
/// that flight knew it.
struct SavedMap {
  struct Node {
    TimeNs t = 0;  ///< of that flight
    int pose = 0;  ///< in the graph
  };
  struct Submap {
    int pose = 0;  ///< in the graph
    std::vector<Eigen::Vector3f> points_submap_m;
  };
  double voxel_m = 0.2;  ///< a submap has one point in a cube of this edge
  PoseGraph graph;
  std::vector<Node> nodes;
  std::vector<Submap> submaps;
  std::vector<MapPiece> pieces;  ///< occupied and free cells, where a mapper has cast the rays of the scans

  const Pose& T_world_submap(const Submap& submap) const { return graph.pose(submap.pose); }
};

/// What does not fit together in a map, in a few words; empty when all is well.
std::string fault_of(const SavedMap& map);

/// The pieces of its submaps. One without any has a piece of its points, with nothing free.
std::vector<MapPiece> pieces_of(const SavedMap& map);
/// The map with what a mapper has seen of the submaps of this flight. Unchanged when it does not know them.
std::shared_ptr<const SavedMap> with_pieces(std::shared_ptr<const SavedMap> map, const SubmapPoses& poses,
                                            std::span<const MapPiece> own);

/// All points of its submaps.
std::vector<Eigen::Vector3f> points_world_m(const SavedMap& map);

/// Its cells in another frame, all of them occupied.
void append_voxels(const SavedMap& map, const Pose& T_local_world, MapVoxels& copy);

/// Who keeps such a map: an estimator, and the agent that it flies.
class KeepsMap {
 public:
  virtual ~KeepsMap() = default;
  /// As of now; null when it keeps none.
  virtual std::shared_ptr<const SavedMap> saved_map() const = 0;
};

}  // namespace swiftlet
