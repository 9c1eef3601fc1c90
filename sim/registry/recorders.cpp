// SPDX-License-Identifier: BSD-3-Clause
#include "sim/recorders/csv.hpp"
#include "sim/recorders/events.hpp"
#include "sim/recorders/map.hpp"
#include "sim/recorders/mcap.hpp"
#include "sim/recorders/pcd.hpp"
#include "sim/recorders/ply.hpp"
#include "sim/recorders/rosbag.hpp"
#include "sim/recorders/tum.hpp"
#include "swiftlet/core/registry.hpp"
#include "swiftlet/sim/recorder.hpp"

namespace swiftlet::sim {
namespace {

// What can be recorded: a new format is one line here.
const RecorderType kRecorderTypes[] = {
    {{"tum", "trajectories, truth and estimate, as TUM text files", make_module_config<TumConfig>}, make_tum_recorder},
    {{"csv", "tables of states and sensor samples", make_module_config<CsvConfig>}, make_csv_recorder},
    {{"events", "what happened, as JSON Lines", make_module_config<EventsConfig>}, make_events_recorder},
    {{"pcd", "scans with their truth as PCD files", make_module_config<PcdConfig>}, make_pcd_recorder},
    {{"ply", "scans with their truth as PLY files", make_module_config<PlyConfig>}, make_ply_recorder},
    {{"map", "the maps that vehicles keep, as PLY or PCD files", make_module_config<MapConfig>}, make_map_recorder},
    {{"mcap", "ROS 2 messages in one MCAP file", make_module_config<McapConfig>}, make_mcap_recorder},
    {{"rosbag", "ROS 1 messages in one bag", make_module_config<RosbagConfig>}, make_rosbag_recorder},
};

}  // namespace

std::span<const RecorderType> recorder_types() { return kRecorderTypes; }

std::span<const ModuleType> recorder_module_types() { return module_types_of<kRecorderTypes>(); }

std::unique_ptr<Recorder> make_recorder(const Module& config) {
  return row_named(kRecorderTypes, config.type, "recorder").make(*config.config);
}

}  // namespace swiftlet::sim
