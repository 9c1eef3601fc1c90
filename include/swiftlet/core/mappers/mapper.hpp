// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "swiftlet/core/base/counter.hpp"
#include "swiftlet/core/base/observation.hpp"
#include "swiftlet/core/localization/local_cloud.hpp"
#include "swiftlet/core/localization/local_poses.hpp"
#include "swiftlet/core/map/occupancy_view.hpp"
#include "swiftlet/core/map/submap_poses.hpp"

namespace swiftlet {

/// Inputs of a mapper in one tick; references are valid for this call only.
struct MapperInput {
  const Observation& observation;
  const StateEstimate& estimate;                                   ///< valid
  std::span<const std::shared_ptr<const LocalCloud>> clouds = {};  ///< finished in this tick
  std::span<const Track> tracks = {};                              ///< tracked flying objects, excluded from the map
  std::span<const RelativeEstimate> relatives = {};                ///< teammates, excluded from the map
  std::span<const NeighborSample> neighbors = {};  ///< neighbors that guidance avoids, excluded from the map
  const SubmapPoses* submaps = nullptr;            ///< null: the estimator keeps no pose graph
  const LocalPoses* poses = nullptr;               ///< recent poses of the vehicle; null: the present one is used
};

/// Interface of mappers. A scenario selects the implementation by name. A vehicle has one such map, shared by all its
/// stages.
class Mapper {
 public:
  virtual ~Mapper() = default;
  virtual void step(const MapperInput& input, Outbox& outbox) = 0;
  /// Map as of the last step; owned by the mapper.
  virtual const OccupancyView& map() const = 0;
  /// True when the map is attached to the submaps of a pose graph.
  virtual bool needs_submaps() const { return false; }
  /// Appends the cells of this flight's submaps, for a saved map.
  virtual void append_pieces(std::vector<MapPiece>&) const {}
  virtual void append_overlays(std::vector<Overlay>&) const {}
  virtual void append_counters(std::vector<Counter>&) const {}
};

}  // namespace swiftlet
