// SPDX-License-Identifier: BSD-3-Clause
#include "sim/replay/overlay_tables.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

namespace swiftlet::sim {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kSmall = 1200;  // [positions] larger overlays are written only with the maps
constexpr std::size_t kMost = 12000;  // [positions] larger overlays are thinned

// The page draws tracks and detections from the tables of that name.
bool is_drawn_otherwise(const std::string& name) { return name.starts_with("tracks") || name == "detections"; }

const char* kind_of(Overlay::Kind kind) {
  constexpr const char* kKinds[] = {"points", "lines", "polyline", "cubes", "spheres", "triangles"};
  return kKinds[static_cast<std::size_t>(kind)];
}

/// Number of positions per primitive.
std::size_t group_of(Overlay::Kind kind) {
  return kind == Overlay::Kind::kLines ? 2 : kind == Overlay::Kind::kTriangles ? 3 : 1;
}

Json json_of(const Eigen::Vector4f& color) {
  Json json;
  for (int c = 0; c < 4; ++c) json.push_back(std::lround(255.0F * std::clamp(color[c], 0.0F, 1.0F)));
  return json;
}

Overlay overlay_of(const MapVoxels& map, const Pose& T_world_local) {
  Overlay overlay;
  overlay.name = "map." + map.name;
  overlay.kind = Overlay::Kind::kCubes;
  overlay.size_m = 0.9F * static_cast<float>(map.edge_m);
  for (std::size_t i = 0; i < map.size(); ++i) {
    if (map.state[i] < map.occupied_from) continue;
    overlay.positions.push_back((T_world_local * map.centers_local_m[i].cast<double>()).cast<float>());
  }
  return overlay;
}

}  // namespace

void OverlayTables::write(const TickView& tick) {
  maps_due_ = map_period_ > 0 && tick.t >= next_maps_;
  if (maps_due_) next_maps_ = (tick.t / map_period_ + 1) * map_period_;
  for (auto& [key, kept] : kept_) kept.seen = false;
  for (std::size_t v = 0; v < tick.actions.size(); ++v) {
    if (tick.actions[v] == nullptr) continue;
    const auto vehicle = static_cast<VehicleId>(v);
    // Several overlays of one name get numbered names, which the page draws as one.
    std::map<std::string, int> parts;
    for (const Overlay& overlay : tick.actions[v]->overlays) {
      if (is_drawn_otherwise(overlay.name)) continue;
      Overlay part = overlay;
      if (const int number = parts[overlay.name]++; number > 0) part.name += "#" + std::to_string(number);
      take(part, vehicle, tick.t);
    }
    if (!maps_due_ || v >= tick.agents.size() || tick.agents[v] == nullptr) continue;
    std::vector<MapVoxels> maps;
    tick.agents[v]->append_maps(maps);
    for (const MapVoxels& map : maps) {
      // The detector's voxels are already overlays.
      if (map.name != "detector") take(overlay_of(map, tick.actions[v]->estimate.T_world_local), vehicle, tick.t);
    }
  }
  for (auto& [key, kept] : kept_) {
    if (kept.seen || kept.content.empty() || key.second.starts_with("map.")) continue;
    kept.content.clear();
    tables_.emplace_back(
        Json::object({{"table", "overlay"}, {"vehicle", key.first}, {"name", key.second}, {"t_s", to_seconds(tick.t)}})
            .dump(),
        std::vector<ReplayColumn>{{"x_m", 0.01}, {"y_m", 0.01}, {"z_m", 0.01}});
  }
}

void OverlayTables::take(const Overlay& overlay, VehicleId vehicle, TimeNs t) {
  Kept& kept = kept_[{vehicle, overlay.name}];
  kept.seen = true;
  const std::size_t count = overlay.positions.size();
  if (count > kSmall && !maps_due_) return;
  const std::size_t group = group_of(overlay.kind);
  const bool can_thin = overlay.kind != Overlay::Kind::kPolyline;
  const std::size_t every = can_thin ? (count + kMost - 1) / kMost : 1;

  // Most overlays have few colors: positions refer to colors by index.
  Json palette = Json::array();
  std::map<std::array<float, 4>, std::size_t> numbers;
  const auto number_of = [&](const Eigen::Vector4f& color) {
    const auto [at, is_new] = numbers.try_emplace({color[0], color[1], color[2], color[3]}, numbers.size());
    if (is_new) palette.push_back(json_of(color));
    return static_cast<double>(at->second);
  };
  std::vector<ReplayColumn> columns = {{"x_m", 0.01}, {"y_m", 0.01}, {"z_m", 0.01}};
  const bool many_colors = overlay.colors.size() == count && count > 1;
  if (many_colors) columns.push_back({"color", 1.0});
  if (!many_colors && !overlay.colors.empty()) number_of(overlay.colors.front());
  ReplayTable table("{}", columns);
  for (std::size_t i = 0; i < count; ++i) {
    if (i / group % std::max<std::size_t>(every, 1) != 0) continue;
    const Eigen::Vector3f& p = overlay.positions[i];
    if (many_colors) {
      table.add({p.x(), p.y(), p.z(), number_of(overlay.colors[i])});
    } else {
      table.add({p.x(), p.y(), p.z()});
    }
  }
  Json about = {{"kind", kind_of(overlay.kind)}, {"size", overlay.size_m}, {"palette", palette}, {"of", count}};
  for (const Overlay::Key& key : overlay.legend)
    about["legend"].push_back({{"meaning", key.meaning}, {"color", json_of(key.color)}});
  const std::string about_text = about.dump(-1, ' ', false, Json::error_handler_t::replace);

  ReplayBlock probe("{}");
  probe.add(table);
  std::string content = about_text + probe.bytes();
  if (content == kept.content) return;
  kept.content = std::move(content);
  Json full = {{"table", "overlay"}, {"vehicle", vehicle}, {"name", overlay.name}, {"t_s", to_seconds(t)}};
  full.update(about);
  table.set_about(full.dump(-1, ' ', false, Json::error_handler_t::replace));
  tables_.push_back(std::move(table));
}

void OverlayTables::move_to(ReplayBlock& block) {
  for (const ReplayTable& table : tables_) block.add(table);
  tables_.clear();
}

}  // namespace swiftlet::sim
