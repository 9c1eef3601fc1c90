// SPDX-License-Identifier: BSD-3-Clause
#include "sim/report/detection_section_internal.hpp"

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>
#include <vector>

#include "sim/report/html.hpp"
#include "swiftlet/sim/io/text.hpp"
#include "swiftlet/sim/plot/plot.hpp"

namespace swiftlet::sim {
namespace {

using Json = nlohmann::ordered_json;

// [-] Largest number of observers drawn in one panel; further ones are left out.
constexpr std::size_t kMaxObservers = 12;

/// NaN for missing values.
double value_at(const Json& bin, const char* key) {
  return !bin.contains(key) || bin[key].is_null() ? std::numeric_limits<double>::quiet_NaN() : bin[key].get<double>();
}

/// The stages present in any vehicle, in the order of data flow.
std::vector<std::string> stages_of(const Json& over_distance) {
  std::vector<std::string> stages;
  for (const auto& [vehicle, by_stage] : over_distance.items()) {
    for (const auto& [stage, bins] : by_stage.items()) {
      if (std::find(stages.begin(), stages.end(), stage) == stages.end()) stages.push_back(stage);
    }
  }
  std::sort(stages.begin(), stages.end());
  return stages;
}

/// A line for each vehicle, with a marker in the middle of each bin.
void draw(plot::Panel& panel, const Json& over_distance, const std::string& stage, const char* key) {
  panel.x.label = "distance of the target [m]";
  panel.x.min = panel.y.min = 0.0;
  int color = 0;
  for (const auto& [vehicle, by_stage] : over_distance.items()) {
    if (static_cast<std::size_t>(color) == kMaxObservers) return;
    plot::Style style;
    style.color = color++;
    if (!by_stage.contains(stage)) continue;
    std::vector<double> distance_m, values;
    for (const Json& bin : by_stage[stage]) {
      distance_m.push_back(0.5 * (value_at(bin, "from_m") + value_at(bin, "to_m")));
      values.push_back(value_at(bin, key));
    }
    style.marker = plot::Marker::kCircle;
    panel.line(vehicle, distance_m, values, style);
    panel.scatter("", distance_m, values, style);
  }
}

std::string numbers(const Json& over_distance, const std::string& stage) {
  html::Table rows({"vehicle", "distance [m]", "targets", "recall", "recall of visible", "error [m]",
                    "its deviation [m]", "error of the speed [m/s]", "error of the heading [rad]"});
  for (const auto& [vehicle, by_stage] : over_distance.items()) {
    if (!by_stage.contains(stage)) continue;
    for (const Json& bin : by_stage[stage]) {
      const auto cell = [&](const char* key) { return html::number(value_at(bin, key)); };
      rows.add({escape_markup(vehicle), cell("from_m") + " to " + cell("to_m"), cell("targets"), cell("recall"),
                cell("recall_visible"), cell("error_mean_m"), cell("error_std_m"), cell("speed_error_mean_mps"),
                cell("direction_error_mean_rad")});
    }
  }
  return html::folded("The numbers", rows.str());
}

}  // namespace

std::string detection_section(const Json& over_distance) {
  std::string text;
  for (const std::string& stage : stages_of(over_distance)) {
    plot::Figure figure({}, 2);
    figure.set_panel_size(420.0, 260.0);
    plot::Panel& recall = figure.add_panel("recall of the " + stage);
    recall.y.label = "share of the targets in range";
    recall.y.max = 1.0;
    draw(recall, over_distance, stage, "recall");
    plot::Panel& error = figure.add_panel("error of the " + stage);
    error.y.label = "mean error of the position [m]";
    draw(error, over_distance, stage, "error_mean_m");
    text += "<figure>" + figure.svg() + "</figure>\n" + numbers(over_distance, stage);
  }
  return text.empty() ? "" : html::section("Detection over distance", text);
}

}  // namespace swiftlet::sim
