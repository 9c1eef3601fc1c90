// SPDX-License-Identifier: BSD-3-Clause
// Expands vehicles with `count` into several vehicles.
#include <array>
#include <cmath>
#include <optional>
#include <span>
#include <utility>

#include "swiftlet/sim/scenario/document.hpp"
#include "swiftlet/sim/scenario/scenario.hpp"
#include "swiftlet/sim/scenario/units.hpp"

namespace swiftlet::sim {
namespace {

using Kind = Node::Kind;

Node scalar(const std::string& text, const Place& place) {
  Node node;
  node.kind = Kind::kScalar;
  node.text = text;
  node.place = place;
  return node;
}

Node numbers(std::span<const double> values, const Place& place) {
  Node list;
  list.kind = Kind::kList;
  list.place = place;
  for (const double value : values) list.items.push_back(scalar(yaml_number(value), place));
  return list;
}

/// The number in the unit of `key`; empty for an invalid text, which the reader reports.
std::optional<double> number(const Node& node, std::string_view key) {
  const auto quantity = node.is_scalar() && !node.quoted ? parse_quantity(node.text) : std::nullopt;
  if (!quantity) return std::nullopt;
  if (quantity->unit.empty()) return quantity->value;
  const Unit* unit = unit_of_key(key);
  const Unit* given = unit == nullptr ? nullptr : find_unit(quantity->unit, *unit);
  if (given == nullptr) return std::nullopt;
  return convert(quantity->value, *given, *unit);
}

bool is_whole(double value, double least, double most) {
  return value == std::floor(value) && value >= least && value <= most;
}

/// Reads a list of numbers, or changes to elements of the default in `values`; false when it is neither.
bool read_values(const Node* given, std::string_view key, std::span<double> values) {
  if (given == nullptr) return true;
  Node list = numbers(values, given->place);
  merge(list, *given, std::string(key));
  if (!list.is_list() || list.items.size() != values.size()) return false;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const auto value = number(list.items[i], key);
    if (!value) return false;
    values[i] = *value;
  }
  return true;
}

/// The entry of a map, created with `value` if missing.
Node& entry_of(Node& map, const char* key, const Node& value) {
  if (Node* found = map.find(key)) return *found;
  map.entries.push_back({key, value.place, value});
  return map.entries.back().value;
}

/// Moves the start of member number `k`: along x, and after each full row along y.
void move_start(Node& vehicle, int k) {
  Node none;
  none.kind = Kind::kMap;
  none.place = vehicle.place;
  Node& start = entry_of(vehicle, "start", none);
  if (!start.is_map()) return;
  const StartConfig defaults;
  std::array<double, 3> position_m = {defaults.position_m.x(), defaults.position_m.y(), defaults.position_m.z()};
  std::array<double, 2> spacing_m = {defaults.spacing_m.x(), defaults.spacing_m.y()};
  const Node* given = start.find("columns");
  const double columns = given == nullptr ? defaults.columns : number(*given, "columns").value_or(-1.0);
  if (!is_whole(columns, 0.0, kMaxVehicles) || !read_values(start.find("position_m"), "position_m", position_m) ||
      !read_values(start.find("spacing_m"), "spacing_m", spacing_m)) {
    return;
  }
  const int width = columns > 0.0 ? static_cast<int>(columns) : k + 1;
  position_m[0] += k % width * spacing_m[0];
  position_m[1] += k / width * spacing_m[1];
  Node& position = entry_of(start, "position_m", scalar("", start.place));
  position = numbers(position_m, position.place);
}

/// Member number `k` of the copies of `vehicle`; `index` is its position in the team.
Node member(const Node& vehicle, int k, std::size_t index) {
  Node one = vehicle;
  Node& name = entry_of(one, "name", scalar("", vehicle.place));
  if (name.is_scalar()) {
    name.text = name.text.empty() ? "uav" + std::to_string(index + 1) : name.text + std::to_string(k + 1);
  }
  if (k > 0) move_start(one, k);
  return one;
}

}  // namespace

void expand_team(Node& document) {
  Node* list = document.find("vehicles");
  if (list == nullptr || !list->is_list()) return;
  std::vector<Node> team;
  std::size_t num_copied = 0;
  for (std::size_t i = 0; i < list->items.size(); ++i) {
    Node vehicle = std::move(list->items[i]);
    const Node* count = vehicle.find("count");
    if (count == nullptr) {
      team.push_back(std::move(vehicle));
      continue;
    }
    const std::string path = "vehicles[" + std::to_string(i) + "].count";
    const Place place = count->place;
    const auto value = number(*count, "count");
    if (!value || !is_whole(*value, 1.0, kMaxVehicles)) {
      fail(place, path,
           "expected a whole number in [1, " + std::to_string(kMaxVehicles) + "], found " + describe(*count));
    }
    std::erase_if(vehicle.entries, [](const Entry& e) { return e.key == "count"; });
    const int members = static_cast<int>(*value);
    num_copied += num_nodes(vehicle) * static_cast<std::size_t>(members);
    if (num_copied > kMaxNodes) {
      fail(place, path, "expected at most " + std::to_string(kMaxNodes) + " values in all vehicles, found more");
    }
    if (members == 1) {
      team.push_back(std::move(vehicle));
      continue;
    }
    for (int k = 0; k < members; ++k) team.push_back(member(vehicle, k, team.size()));
  }
  list->items = std::move(team);
  Node changes;
  changes.kind = Kind::kElements;
  changes.place = list->place;
  changes.entries = std::exchange(list->entries, {});
  merge(*list, changes, "vehicles");
}

}  // namespace swiftlet::sim
