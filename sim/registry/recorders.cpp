// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/registry/recorders.hpp"

#include "swiftlet/core/base/registry.hpp"
#include "swiftlet/sim/recorders/csv.hpp"
#include "swiftlet/sim/recorders/events.hpp"
#include "swiftlet/sim/recorders/map.hpp"
#include "swiftlet/sim/recorders/mcap.hpp"
#include "swiftlet/sim/recorders/pcd.hpp"
#include "swiftlet/sim/recorders/ply.hpp"
#include "swiftlet/sim/recorders/rosbag.hpp"
#include "swiftlet/sim/recorders/tum.hpp"
#include "swiftlet/sim/recording/recorder.hpp"
#include "swiftlet/sim/registry/sensors.hpp"
#include "swiftlet/sim/replay/replay.hpp"
#include "swiftlet/sim/slam_map/slam_map_recorder.hpp"

namespace swiftlet::sim {
namespace {

// All recorders: a new format needs one line here.
const RecorderType kRecorderTypes[] = {
    {{"tum", "trajectories, truth and estimate, as TUM text files", make_module_config<TumConfig>}, make_tum_recorder},
    {{"csv", "tables of states and sensor samples", make_module_config<CsvConfig>}, make_csv_recorder},
    {{"events", "events, as JSON Lines", make_module_config<EventsConfig>}, make_events_recorder},
    {{"pcd", "scans with their truth as PCD files", make_module_config<PcdConfig>}, make_pcd_recorder},
    {{"ply", "scans with their truth as PLY files", make_module_config<PlyConfig>}, make_ply_recorder},
    {{"map", "maps of the vehicles, as PLY or PCD files", make_module_config<MapConfig>}, make_map_recorder},
    {{"slam_map", "maps of SLAM with their pose graphs, for later flights", make_module_config<SlamMapConfig>},
     make_slam_map_recorder},
    {{"mcap", "ROS 2 messages in one MCAP file", make_module_config<McapConfig>}, make_mcap_recorder},
    {{"rosbag", "ROS 1 messages in one bag", make_module_config<RosbagConfig>}, make_rosbag_recorder},
    {{"replay", "replay of the run as one page for a browser", make_module_config<ReplayConfig>}, make_replay_recorder},
};

}  // namespace

Registry<RecorderType>& recorder_registry() {
  sensor_registry();  // registers the sensors, whose sample tables recorders query
  static Registry<RecorderType> table("recorder", kRecorderTypes);
  return table;
}

std::unique_ptr<Recorder> make_recorder(const Module& config) { return recorder_registry().make(config); }

}  // namespace swiftlet::sim
