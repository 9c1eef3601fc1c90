// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/report/run_report.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <string_view>

#include "sim/report/detection_section_internal.hpp"
#include "sim/report/html.hpp"
#include "sim/report/time_series.hpp"
#include "swiftlet/sim/errors/errors.hpp"
#include "swiftlet/sim/io/files.hpp"
#include "swiftlet/sim/io/shallow_json.hpp"
#include "swiftlet/sim/io/text.hpp"
#include "swiftlet/sim/plot/plot.hpp"

namespace swiftlet::sim {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

// [-] Largest number of vehicles drawn in one panel; further ones are left out.
constexpr std::size_t kMaxVehicles = 12;
// [-] Largest numbers of events and of pictures on the page; further ones are left out. Larger values make it longer.
constexpr std::size_t kMaxEvents = 200;
constexpr std::size_t kMaxPictures = 60;

Json read_json(const fs::path& file) {
  std::ifstream stream = open_to_read(file);
  const Json json = parse_shallow<Json>(stream);
  if (json.is_discarded() || !json.is_object())
    throw InputError(file.string() + ": expected the summary of a run, found something else");
  return json;
}

std::string text_of(const Json& value) {
  if (value.is_string()) return escape_markup(value.get<std::string>());
  if (value.is_number_integer() || value.is_number_unsigned()) return value.dump();
  if (value.is_number()) return html::number(value.get<double>());
  return value.is_null() ? "–" : escape_markup(value.dump());
}

std::string text_at(const Json& json, const char* key) { return json.contains(key) ? text_of(json[key]) : "–"; }

std::string heading(const Json& summary) {
  return "<h1>" + text_at(summary, "scenario") + ", seed " + text_at(summary, "seed") + ": " +
         text_at(summary, "outcome") + "</h1>\n<p class=\"note\">" + text_at(summary, "simulated_s") + " s flown in " +
         text_at(summary, "wall_s") + " s (" + text_at(summary, "real_time_factor") + " times real time) after " +
         text_at(summary, "setup_wall_s") + " s of set-up, state hash <code>" + text_at(summary, "state_hash") +
         "</code>, Swiftlet " + text_at(summary, "version") + " (" + text_at(summary, "git_revision") + "), " +
         text_at(summary, "threads") + " threads.</p>\n";
}

/// A row for each metric, a column for each vehicle.
std::string metrics_section(const Json& summary) {
  const Json metrics = summary.value("metrics", Json::object());
  html::Table of_run({"of the run", ""});
  const Json run = metrics.value("run", Json::object());
  for (const auto& [name, value] : run.items()) of_run.add({escape_markup(name), text_of(value)});
  const Json vehicles = metrics.value("vehicles", Json::object());
  std::vector<std::string> head = {"of each vehicle"};
  std::vector<std::string> names;
  for (const auto& [vehicle, own] : vehicles.items()) {
    head.push_back(escape_markup(vehicle));
    for (const auto& [name, value] : own.items()) {
      if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
    }
  }
  html::Table of_vehicles(head);
  for (const std::string& name : names) {
    std::vector<std::string> cells = {escape_markup(name)};
    for (const auto& [vehicle, own] : vehicles.items()) cells.push_back(own.contains(name) ? text_of(own[name]) : "–");
    of_vehicles.add(std::move(cells));
  }
  return html::section("Metrics", of_run.str() + (vehicles.empty() ? "" : of_vehicles.str()));
}

std::string figure(const plot::Figure& plot) { return "<figure>" + plot.svg() + "</figure>\n"; }

std::string paths_figure(const std::vector<VehicleSeries>& all) {
  plot::Figure plot;
  plot.set_panel_size(520.0, 460.0);
  plot::Panel& panel = plot.add_panel("seen from above");
  panel.x.label = "east [m]";
  panel.y.label = "north [m]";
  panel.equal_axes = true;
  for (std::size_t i = 0; i < std::min(all.size(), kMaxVehicles); ++i) {
    if (all[i].t_s.empty()) continue;
    plot::Style style;
    style.color = static_cast<int>(i);
    panel.line(all[i].name, all[i].x_m, all[i].y_m, style);
    style.marker = plot::Marker::kCircle;  // start of the path
    panel.scatter("", std::span(all[i].x_m).first(1), std::span(all[i].y_m).first(1), style);
  }
  return figure(plot);
}

std::string series_figure(const std::vector<VehicleSeries>& all, const std::string& label,
                          std::vector<double> VehicleSeries::*values) {
  plot::Figure plot;
  plot.set_panel_size(560.0, 260.0);
  plot::Panel& panel = plot.add_panel();
  panel.x.label = "time [s]";
  panel.y.label = label;
  bool any = false;
  for (std::size_t i = 0; i < std::min(all.size(), kMaxVehicles); ++i) {
    const std::vector<double>& y = all[i].*values;
    if (y.size() != all[i].t_s.size() || std::none_of(y.begin(), y.end(), [](double v) { return std::isfinite(v); }))
      continue;
    plot::Style style;
    style.color = static_cast<int>(i);
    style.width_px = 1.3;
    panel.line(all[i].name, all[i].t_s, y, style);
    any = true;
  }
  return any ? figure(plot) : "";
}

/// Start time of the recordings, subtracted from times on the page.
double start_time_s(const fs::path& directory) {
  constexpr std::string_view kKey = "start_time_s: ";
  if (!fs::exists(directory / "scenario.yaml")) return 0.0;
  std::ifstream scenario = open_to_read(directory / "scenario.yaml");
  for (std::string line; std::getline(scenario, line);) {
    if (line.starts_with(kKey)) return number_in<double>(std::string_view(line).substr(kKey.size())).value_or(0.0);
  }
  return 0.0;
}

std::string series_section(const fs::path& directory) {
  std::vector<VehicleSeries> all = read_time_series(directory);
  const double start_s = start_time_s(directory);
  for (VehicleSeries& series : all) {
    for (double& t_s : series.t_s) t_s -= start_s;
  }
  if (all.empty())
    return html::section("Flight",
                         "<p class=\"note\">No recorder wrote states: add <code>- {type: tum}</code> or <code>- {type: "
                         "csv}</code>.</p>\n");
  std::string text = paths_figure(all);
  text += series_figure(all, "height [m]", &VehicleSeries::z_m);
  text += series_figure(all, "speed [m/s]", &VehicleSeries::speed_mps);
  text += series_figure(all, "clearance [m]", &VehicleSeries::clearance_m);
  text += series_figure(all, "error of the estimate [m]", &VehicleSeries::estimate_error_m);
  text += series_figure(all, "error of the tracking [m]", &VehicleSeries::tracking_error_m);
  if (all.size() > kMaxVehicles)
    text += "<p class=\"note\">Only the first " + std::to_string(kMaxVehicles) + " vehicles are drawn.</p>\n";
  return html::section("Flight", text);
}

std::string events_section(const fs::path& directory) {
  if (!fs::exists(directory / "events.jsonl")) return "";
  std::ifstream stream = open_to_read(directory / "events.jsonl");
  const double start_s = start_time_s(directory);
  html::Table rows({"time [s]", "what", "vehicle", "with", "where [m]", ""}, {1, 2, 3, 4, 5});
  std::size_t count = 0;
  for (std::string line; std::getline(stream, line);) {
    Json event = parse_shallow<Json>(line);
    if (!event.is_object() || ++count > kMaxEvents) continue;
    if (event.contains("t_s") && event["t_s"].is_number()) event["t_s"] = event["t_s"].get<double>() - start_s;
    std::string where;
    for (const Json& x : event.value("position_m", Json::array())) where += (where.empty() ? "" : ", ") + text_of(x);
    rows.add({text_at(event, "t_s"), text_at(event, "kind"), text_at(event, "vehicle"), text_at(event, "partner"),
              where, text_at(event, "note")});
  }
  if (count == 0) return "";
  return html::section("Events: " + std::to_string(count), rows.str());
}

std::string pictures_section(const fs::path& directory) {
  std::set<std::string> pictures;
  for (const char* folder : {"snapshots", "render"}) {
    if (!fs::is_directory(directory / folder)) continue;
    for (const auto& entry : fs::recursive_directory_iterator(directory / folder)) {
      const std::string name = entry.path().filename().string();
      // Depths in millimeters (NAME.mm.png) are data, not pictures for display.
      if (name.ends_with(".png") && !name.ends_with(".mm.png"))
        pictures.insert(fs::relative(entry.path(), directory).string());
    }
  }
  if (pictures.empty()) return "";
  std::string text;
  std::size_t count = 0;
  for (const std::string& picture : pictures) {
    if (++count > kMaxPictures) break;
    text += "<figure><a href=\"" + escape_markup(picture) + "\"><img width=\"540\" loading=\"lazy\" src=\"" +
            escape_markup(picture) + "\" alt=\"\"></a><figcaption>" + escape_markup(fs::path(picture).stem().string()) +
            "</figcaption></figure>\n";
  }
  return html::section("Pictures", text);
}

/// Link to the replay page in this directory.
std::string replay_section(const fs::path& directory) {
  if (!fs::is_regular_file(directory / "replay.html")) {
    return html::section("Replay", "<p class=\"note\">" + html::code("swiftlet replay " + directory.string()) +
                                       " makes a page that plays the run in the browser.</p>\n");
  }
  return html::section("Replay",
                       "<p><a href=\"replay.html\">The run in three dimensions</a>, with signals over time.</p>\n" +
                           html::folded("Show it here", html::replay_frame("replay.html")));
}

std::string stages_section(const Json& summary) {
  const Json stages = summary.value("stage_wall_s", Json::object());
  if (stages.empty()) return "";
  const double simulated_s = summary.value("simulated_s", 0.0);
  html::Table rows({"stage", "wall time [s]", "share", "ms for each simulated second"});
  double sum_s = 0.0;
  for (const auto& [stage, wall_s] : stages.items()) sum_s += wall_s.get<double>();
  std::vector<double> heights;
  plot::Figure plot;
  plot.set_panel_size(460.0, 260.0);
  plot::Panel& panel = plot.add_panel();
  panel.y.label = "wall time [s]";
  for (const auto& [stage, wall_s] : stages.items()) {
    const double s = wall_s.get<double>();
    panel.x.categories.push_back(stage);
    heights.push_back(s);
    rows.add({escape_markup(stage), html::number(s), sum_s > 0.0 ? html::number(100.0 * s / sum_s) + " %" : "–",
              simulated_s > 0.0 ? html::number(1e3 * s / simulated_s) : "–"});
  }
  panel.bars("", heights);
  return html::section("Wall time of each stage", figure(plot) + rows.str());
}

std::string radio_section(const Json& summary) {
  if (!summary.contains("radio") || !summary["radio"].contains("topics") || summary["radio"]["topics"].empty())
    return "";
  html::Table rows({"topic", "from", "messages", "bytes", "rate [Hz]", "load [kB/s]"}, {0, 1});
  for (const Json& topic : summary["radio"]["topics"]) {
    rows.add({text_at(topic, "topic"), text_at(topic, "from"), text_at(topic, "messages"), text_at(topic, "bytes"),
              text_at(topic, "rate_hz"), text_at(topic, "load_kBps")});
  }
  return html::section("Radio", rows.str());
}

std::string scenario_section(const fs::path& directory) {
  if (!fs::exists(directory / "scenario.yaml")) return "";
  std::ifstream stream = open_to_read(directory / "scenario.yaml");
  std::ostringstream text;
  text << stream.rdbuf();
  return html::section("Scenario, with every default",
                       html::folded("scenario.yaml", "<pre>" + escape_markup(text.str()) + "</pre>"));
}

}  // namespace

std::vector<fs::path> write_run_report(const fs::path& directory) {
  const fs::path summary_file = directory / "summary.json";
  if (!fs::is_regular_file(summary_file))
    throw InputError(directory.string() + ": expected a run directory with summary.json, found none");
  const Json summary = read_json(summary_file);
  std::string body;
  try {
    body = heading(summary) + replay_section(directory) + metrics_section(summary) +
           detection_section(summary.value("detection_over_distance", Json::object())) + series_section(directory) +
           events_section(directory) + pictures_section(directory) + radio_section(summary) + stages_section(summary) +
           scenario_section(directory);
  } catch (const Json::exception&) {
    throw InputError(summary_file.string() + ": expected the summary of a run, found values of other types");
  }
  write_file(directory / "report.html", html::page(text_at(summary, "scenario"), body));
  return {directory / "report.html"};
}

}  // namespace swiftlet::sim
