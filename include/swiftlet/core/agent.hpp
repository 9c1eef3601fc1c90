// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/action.hpp"
#include "swiftlet/core/airframe.hpp"
#include "swiftlet/core/capture_volume.hpp"
#include "swiftlet/core/counter.hpp"
#include "swiftlet/core/map_voxels.hpp"
#include "swiftlet/core/neighbor_view.hpp"
#include "swiftlet/core/observation.hpp"
#include "swiftlet/core/prior_map.hpp"

namespace swiftlet {

/// What a vehicle knows of the pose in which it was put down.
enum class StartKnown { kPose, kPosition, kNothing };

/// What a vehicle's software is told before the start.
struct AgentSetup {
  VehicleId self = 0;
  int num_vehicles = 1;
  std::vector<std::string> vehicle_names;  ///< by VehicleId
  Airframe airframe;                       ///< as identified; the truth may differ
  StartKnown start_known = StartKnown::kPose;
  /// Where it was put down, as far as it was told: its pose in the world, its place with heading 0, or the origin.
  /// There its local frame begins.
  Pose T_local_body_start = Pose::Identity();
  double tick_s = 0.004;
  std::vector<NeighborView> neighbor_views;   ///< of its mutual-localization sensors
  std::shared_ptr<const PriorMap> prior_map;  ///< null: nothing is known
};

/// Memory that a setting asks for; small needs are not told.
struct MemoryNeed {
  std::string key;  ///< of the setting, below the agent's own
  double bytes = 0.0;
};

/// A kind of sensor without which an agent cannot work.
struct SensorNeed {
  std::string type;       ///< as scenarios name it
  std::string why;        ///< the setting that asks for it, below the agent's own
  std::string name = {};  ///< of the one that is meant; empty: any of the type
};

/// What an agent needs of whoever puts it into a world, beside the sensors that its vehicle carries.
struct AgentNeeds {
  bool true_pose = false;            ///< truth by name: an ideal `pose` sensor where the vehicle carries none
  bool true_neighbors = false;       ///< truth by name: an ideal `neighbors` sensor where the vehicle carries none
  std::vector<SensorNeed> sensors;   ///< that its vehicle must carry
  PriorConfig prior;                 ///< the map that it wants to be told
  double prior_voxel_m = 0.25;       ///< for which that map must be dense enough
  bool detects = false;              ///< its detections are to be scored
  bool tracks = false;               ///< its tracks are to be scored
  std::optional<CaptureVolume> net;  ///< whom it catches is to be noted
  int captures = 0;                  ///< number by the net that ends the mission; 0: none
  std::vector<MemoryNeed> memory;    ///< what is large
};

/// One vehicle's software. Knows nothing but its setup and its observations; has no clock, no files, no random numbers.
class Agent {
 public:
  virtual ~Agent() = default;
  /// One tick. The result belongs to the agent and is valid until the next call.
  virtual const Action& step(const Observation& observation) = 0;
  /// What did not fit its settings so far, with keys from the agent's own.
  virtual void append_counters(std::vector<Counter>& /*counters*/) const {}
  /// Copies of the maps that it keeps, as of now, each named by its stage.
  virtual void append_maps(std::vector<MapVoxels>& /*maps*/) const {}
};

}  // namespace swiftlet
