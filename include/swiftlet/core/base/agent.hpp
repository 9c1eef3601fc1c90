// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/base/action.hpp"
#include "swiftlet/core/base/airframe.hpp"
#include "swiftlet/core/base/capture_volume.hpp"
#include "swiftlet/core/base/counter.hpp"
#include "swiftlet/core/base/map_voxels.hpp"
#include "swiftlet/core/base/neighbor_view.hpp"
#include "swiftlet/core/base/observation.hpp"
#include "swiftlet/core/base/prior_map.hpp"

namespace swiftlet {

/// Prior knowledge of the vehicle's start pose.
enum class StartKnown { kPose, kPosition, kNothing };

/// Data that a vehicle's software receives before the start.
struct AgentSetup {
  VehicleId self = 0;
  int num_vehicles = 1;
  std::vector<std::string> vehicle_names;  ///< indexed by VehicleId
  Airframe airframe;                       ///< nominal parameters; the simulated vehicle may differ
  StartKnown start_known = StartKnown::kPose;
  /// Start pose as far as known: the pose in the world, the position with heading 0, or the origin. The local frame
  /// begins there.
  Pose T_local_body_start = Pose::Identity();
  double tick_s = 0.004;
  std::vector<NeighborView> neighbor_views;   ///< fields of view of the vehicle's mutual-localization sensors
  std::shared_ptr<const PriorMap> prior_map;  ///< null: no prior map
};

/// Large memory demand of one setting; small ones are not listed.
struct MemoryNeed {
  std::string key;  ///< key of the setting, below the agent's own
  double bytes = 0.0;
};

/// Sensor type that an agent requires.
struct SensorNeed {
  std::string type;         ///< type name as in scenarios
  std::string required_by;  ///< setting that requires the sensor, below the agent's own
  std::string name = {};    ///< name of the required sensor; empty: any of the type
};

/// Requirements of an agent on the simulated world, beside the sensors that its vehicle carries.
struct AgentNeeds {
  bool true_pose = false;            ///< ground truth: an ideal `pose` sensor is added if the vehicle carries none
  bool true_neighbors = false;       ///< ground truth: an ideal `neighbors` sensor is added if the vehicle carries none
  std::vector<SensorNeed> sensors;   ///< sensors that the vehicle must carry
  PriorConfig prior;                 ///< sources of the prior map
  double prior_voxel_m = 0.25;       ///< voxel edge that the prior map must be dense enough for
  bool detects = false;              ///< score the detections
  bool tracks = false;               ///< score the tracks
  std::optional<CaptureVolume> net;  ///< net whose captures are recorded
  int captures = 0;                  ///< number of captures by the net that ends the mission; 0: none
  std::vector<MemoryNeed> memory;    ///< large memory demands
};

/// Software of one vehicle. Its inputs are its setup and its observations; it has no clock, no files and no random
/// numbers.
class Agent {
 public:
  virtual ~Agent() = default;
  /// One tick. The result belongs to the agent and is valid until the next call.
  virtual const Action& step(const Observation& observation) = 0;
  /// Counters of events that exceeded the settings so far, with keys relative to the agent's own.
  virtual void append_counters(std::vector<Counter>& /*counters*/) const {}
  /// Copies of the maps that the stages keep, as of now, each named after its stage.
  virtual void append_maps(std::vector<MapVoxels>& /*maps*/) const {}
};

}  // namespace swiftlet
