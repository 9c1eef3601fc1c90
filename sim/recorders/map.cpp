// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/recorders/map.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "sim/recorders/selection.hpp"
#include "swiftlet/sim/io/byte_buffer.hpp"
#include "swiftlet/sim/io/output_file.hpp"
#include "swiftlet/sim/octomap/octomap_file.hpp"

namespace swiftlet::sim {
namespace {

/// Header of a map file.
struct MapLabel {
  std::string vehicle;
  TimeNs t = 0;
  Pose T_world_local = Pose::Identity();  // as estimated by the vehicle
};

std::vector<std::string> comments(const MapVoxels& map, const MapLabel& label) {
  std::string states;
  for (std::size_t i = 0; i < map.states.size(); ++i) states += fmt::format(" {} {}", i, map.states[i]);
  const Vector3 p = label.T_world_local.translation();
  const Eigen::Quaterniond q(label.T_world_local.linear());
  return {fmt::format("map {} of {}", map.name, label.vehicle),
          "frame " + label.vehicle + "/local",
          fmt::format("stamp_ns {}", label.t),
          fmt::format("edge_m {}", map.edge_m),
          "states" + states,
          fmt::format("world_from_local x_m {} y_m {} z_m {} qx {} qy {} qz {} qw {}", p.x(), p.y(), p.z(), q.x(),
                      q.y(), q.z(), q.w())};
}

std::string ply_header(std::size_t count, const std::vector<std::string>& comments) {
  std::string header = "ply\nformat binary_little_endian 1.0\n";
  for (const std::string& comment : comments) header += "comment " + comment + "\n";
  return header + fmt::format("element vertex {}\n", count) +
         "property float x\nproperty float y\nproperty float z\nproperty uchar state\nproperty float value\n"
         "end_header\n";
}

std::string pcd_header(std::size_t count, const std::vector<std::string>& comments) {
  std::string header = "# .PCD v0.7 - Point Cloud Data file format\n";
  for (const std::string& comment : comments) header += "# " + comment + "\n";
  return header + "VERSION 0.7\nFIELDS x y z state value\nSIZE 4 4 4 1 4\nTYPE F F F U F\nCOUNT 1 1 1 1 1\n" +
         fmt::format("WIDTH {0}\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {0}\nDATA binary\n", count);
}

class MapRecorder : public Recorder {
 public:
  explicit MapRecorder(MapConfig config) : config_(std::move(config)) {
    std::sort(config_.times_s.begin(), config_.times_s.end());
  }

  void begin(const RunInfo& info) override {
    directory_ = info.directory;
    names_ = info.vehicle_names;
    start_time_ = info.start_time;
    selected_ = select_vehicles(config_.vehicles, names_);
  }

  void write_start(const TickView&) override {}  // ignored: agents create their maps in the first tick
  void write(const TickView& tick) override {
    last_ = tick;
    for (; next_ < config_.times_s.size() && tick.t >= from_seconds(config_.times_s[next_]); ++next_) {
      write_maps(fmt::format("{:010.3f}s", config_.times_s[next_]));
    }
  }

  std::vector<std::filesystem::path> finish() override {
    if (config_.at_end) write_maps("end");
    return std::move(paths_);
  }

 private:
  void write_maps(const std::string& when) {
    for (std::size_t i = 0; i < last_.agents.size(); ++i) {
      if (!selected_[i] || last_.agents[i] == nullptr) continue;
      maps_.clear();
      last_.agents[i]->append_maps(maps_);
      const StateEstimate& estimate = last_.actions[i]->estimate;
      for (const MapVoxels& map : maps_) {
        if (!selects(config_.maps, map.name)) continue;
        write_map(map, {names_[i], start_time_ + last_.t, estimate.T_world_local},
                  std::filesystem::path(config_.folder) / (names_[i] + "_" + map.name + "_" + when));
      }
    }
  }

  void write_map(const MapVoxels& map, const MapLabel& label, std::filesystem::path path) {
    path += std::string(".") + config_.format_name();
    OutputFile file(directory_ / path, 0);
    if (config_.format == MapConfig::Format::kOt || config_.format == MapConfig::Format::kBt) {
      const auto format = config_.format == MapConfig::Format::kOt ? OctomapFormat::kOt : OctomapFormat::kBt;
      file.append(octomap_content(selected(map), format, comments(map, label)));
    } else {
      append_points(selected(map), comments(map, label), file);
    }
    file.finish();
    paths_.push_back(std::move(path));
  }

  const MapVoxels& selected(const MapVoxels& map) {
    if (config_.voxels == MapConfig::Voxels::kAll) return map;
    occupied_ = {};
    occupied_.edge_m = map.edge_m;
    occupied_.occupied_from = map.occupied_from;
    occupied_.log_odds = map.log_odds;
    for (std::size_t i = 0; i < map.size(); ++i) {
      if (map.state[i] >= map.occupied_from) {
        occupied_.add(map.centers_local_m[i].cast<double>(), map.state[i], map.value[i]);
      }
    }
    return occupied_;
  }

  void append_points(const MapVoxels& map, const std::vector<std::string>& lines, OutputFile& file) {
    body_.clear();
    for (std::size_t i = 0; i < map.size(); ++i) {
      for (const float coordinate : map.centers_local_m[i]) body_.put(coordinate);
      body_.put(map.state[i]);
      body_.put(map.value[i]);
    }
    file.append((config_.format == MapConfig::Format::kPly ? ply_header : pcd_header)(map.size(), lines));
    file.append(body_.bytes());
  }

  MapConfig config_;
  std::filesystem::path directory_;
  std::vector<std::string> names_;
  std::vector<bool> selected_;
  TimeNs start_time_ = 0;
  TickView last_;         // its agents and actions remain valid
  std::size_t next_ = 0;  // index of the next instant
  std::vector<MapVoxels> maps_;
  MapVoxels occupied_;  // occupied cells of one map
  ByteBuffer body_;
  std::vector<std::filesystem::path> paths_;
};

}  // namespace

void MapConfig::visit(ConfigVisitor& v) {
  v.field("vehicles", vehicles, "[-] names of the vehicles whose maps are written; empty: all");
  v.field("maps", maps, "[-] names of the stages whose maps are written (detector, mapping); empty: all");
  v.field("times_s", times_s, "[s] times of recording", Range::non_negative());
  v.field("at_end", at_end, "[-] whether maps are recorded at the end of the run too");
  v.choice("voxels", voxels, {"all", "occupied"}, "[-] every observed voxel, or only occupied ones");
  v.choice("format", format, kFormats,
           "[-] file format: points with x, y, z, state and value (ply, pcd), or octrees of OctoMap (ot with log-odds, "
           "bt with states only)");
  v.field("folder", folder, "[-] folder in the run directory; two recorders of the same format need two");
}

std::unique_ptr<Recorder> make_map_recorder(const ModuleConfig& config) {
  return std::make_unique<MapRecorder>(dynamic_cast<const MapConfig&>(config));
}

}  // namespace swiftlet::sim
