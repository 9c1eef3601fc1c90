// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "swiftlet/core/counter.hpp"
#include "swiftlet/core/localization/local_cloud.hpp"
#include "swiftlet/core/localization/local_poses.hpp"
#include "swiftlet/core/map/occupancy_view.hpp"
#include "swiftlet/core/map/submap_poses.hpp"
#include "swiftlet/core/observation.hpp"

namespace swiftlet {

/// What a mapper knows in one tick: all values, nothing kept.
struct MapperInput {
  const Observation& observation;
  const StateEstimate& estimate;                                   ///< valid
  std::span<const std::shared_ptr<const LocalCloud>> clouds = {};  ///< new in this tick
  std::span<const Track> tracks = {};                              ///< who flies there and is no obstacle
  std::span<const RelativeEstimate> relatives = {};                ///< members of the team, who are none either
  std::span<const NeighborSample> neighbors = {};                  ///< whom guidance keeps from; none are obstacles
  const SubmapPoses* submaps = nullptr;                            ///< of an estimator that keeps a pose graph
  const LocalPoses* poses = nullptr;                               ///< where the vehicle was; null: as it is now
};

/// What is around? A scenario chooses by name who answers. A vehicle has one such map, which
/// everybody asks.
class Mapper {
 public:
  virtual ~Mapper() = default;
  virtual void step(const MapperInput& input, Outbox& outbox) = 0;
  /// The map as of the last step; stays the mapper's.
  virtual const OccupancyView& map() const = 0;
  /// Does its map hang on the submaps of a pose graph?
  virtual bool needs_submaps() const { return false; }
  /// What it has seen so far of the submaps of this flight, for a map that is saved.
  virtual void append_pieces(std::vector<MapPiece>&) const {}
  virtual void append_overlays(std::vector<Overlay>&) const {}
  virtual void append_counters(std::vector<Counter>&) const {}
};

}  // namespace swiftlet
