// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/run/summary.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "swiftlet/sim/io/text.hpp"
#include "swiftlet/sim/run/version.hpp"

namespace swiftlet::sim {
namespace {

using Json = nlohmann::ordered_json;

// Text or number of a metric. Values that were not measured (NaN) are null, since JSON has no NaN.
Json value_of(const MetricRow& row) {
  if (!row.text.empty()) return row.text;
  return std::isfinite(row.value) ? Json(row.value) : Json(nullptr);
}

Json metrics_json(const MetricTable& table) {
  Json run = Json::object();
  Json vehicles = Json::object();
  for (const MetricRow& row : table.rows()) {
    (row.vehicle.empty() ? run : vehicles[row.vehicle])[row.name] = value_of(row);
  }
  return {{"run", run}, {"vehicles", vehicles}};
}

// Recall and errors of detectors and trackers over the distance of the target: bins by observer and stage.
Json detection_json(const MetricTable& table) {
  const auto number = [](double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); };
  Json out = Json::object();
  for (const DistanceBin& bin : table.bins()) {
    out[bin.vehicle][bin.stage].push_back({{"from_m", bin.from_m},
                                           {"to_m", bin.to_m},
                                           {"targets", bin.targets},
                                           {"recall", number(bin.recall)},
                                           {"recall_visible", number(bin.recall_visible)},
                                           {"error_mean_m", number(bin.error_mean_m)},
                                           {"error_std_m", number(bin.error_std_m)},
                                           {"speed_error_mean_mps", number(bin.speed_error_mean_mps)},
                                           {"direction_error_mean_rad", number(bin.direction_error_mean_rad)}});
  }
  return out;
}

Json radio_json(const RunSummary& summary) {
  const RadioStatistics& s = summary.radio;
  Json topics = Json::array();
  for (const auto& topic : summary.radio_topics) {
    const double seconds = summary.simulated_s > 0.0 ? summary.simulated_s : 1.0;
    topics.push_back({{"topic", topic.topic},
                      {"from", topic.from},
                      {"messages", topic.messages},
                      {"bytes", topic.bytes},
                      {"rate_hz", static_cast<double>(topic.messages) / seconds},
                      {"load_kBps", 1e-3 * static_cast<double>(topic.bytes) / seconds}});
  }
  return {{"sent", s.sent},
          {"delivered", s.delivered},
          {"lost", s.lost},
          {"blocked", s.blocked},
          {"out_of_range", s.out_of_range},
          {"dropped", s.dropped},
          {"bytes_sent", s.bytes_sent},
          {"mean_delay_s", s.mean_delay_s},
          {"max_delay_s", s.max_delay_s},
          {"topics", topics}};
}

// Counters that are not zero.
Json counters_json(const std::vector<Counter>& counters) {
  Json out = Json::array();
  for (const Counter& counter : counters) {
    if (counter.count == 0) continue;
    Json entry = {{"what", counter.what}, {"count", counter.count}, {"setting", counter.setting}};
    if (counter.of > 0) entry["of"] = counter.of;
    out.push_back(std::move(entry));
  }
  return out;
}

std::string number_text(const MetricRow& row) {
  if (!row.text.empty()) return row.text;
  if (!std::isfinite(row.value)) return "-";
  const bool tiny = std::abs(row.value) < 1e-3 && row.value != 0.0;
  return tiny ? fmt::format("{:.1e}", row.value) : fmt::format("{:.3f}", row.value);
}

// Metrics of the vehicles as text: a row per metric, a column per vehicle.
std::string vehicle_table(const MetricTable& table) {
  constexpr std::size_t kMaxColumns = 6;  // [-] maximum number of vehicles; more are in summary.json only
  constexpr int kColumnWidth = 13;        // [characters]
  constexpr std::size_t kNameWidth = 32;  // [characters] of the column with the names of the metrics
  std::vector<std::string> names, vehicles;
  std::map<std::pair<std::string, std::string>, std::string> cells;
  const auto remember = [](std::vector<std::string>& list, const std::string& name) {
    if (std::find(list.begin(), list.end(), name) == list.end()) list.push_back(name);
  };
  for (const MetricRow& row : table.rows()) {
    if (row.vehicle.empty()) continue;
    remember(names, row.name);
    remember(vehicles, row.vehicle);
    cells[{row.name, row.vehicle}] = number_text(row);
  }
  if (vehicles.empty()) return {};
  const std::size_t shown = std::min(vehicles.size(), kMaxColumns);
  const auto padded = [](const std::string& text, int width) {
    return std::string(std::max<int>(1, width - static_cast<int>(text.size())), ' ') + text;
  };
  std::string out = "  " + std::string(kNameWidth, ' ');
  for (std::size_t i = 0; i < shown; ++i) out += padded(vehicles[i], kColumnWidth);
  if (shown < vehicles.size()) out += "  ... " + std::to_string(vehicles.size() - shown) + " more in summary.json";
  out += "\n";
  for (const std::string& name : names) {
    out += "  " + name + std::string(name.size() < kNameWidth ? kNameWidth - name.size() : 1, ' ');
    for (std::size_t i = 0; i < shown; ++i) out += padded(cells[{name, vehicles[i]}], kColumnWidth);
    out += "\n";
  }
  return out;
}

// Counters with the same text and setting, summed over vehicles. The setting keeps the index of the vehicle if only one
// vehicle has a nonzero count.
std::vector<Counter> summed_over_vehicles(const std::vector<Counter>& counters) {
  struct Sum {
    Counter all;            // sum over vehicles
    Counter last;           // nonzero counter of the last vehicle
    int num_reporting = 0;  // number of vehicles with a nonzero counter
  };
  std::vector<Sum> sums;
  for (const Counter& counter : counters) {
    std::string key = counter.setting;
    if (key.starts_with("vehicles[")) key.replace(9, key.find(']') - 9, "*");
    auto sum = std::find_if(sums.begin(), sums.end(),
                            [&](const Sum& s) { return s.all.setting == key && s.all.what == counter.what; });
    if (sum == sums.end()) sum = sums.insert(sum, Sum{{counter.what, 0, 0, key}, {}, 0});
    sum->all.count += counter.count;
    sum->all.of += counter.of;
    if (counter.count == 0) continue;
    ++sum->num_reporting;
    sum->last = counter;
  }
  std::vector<Counter> out;
  for (const Sum& sum : sums) {
    if (sum.num_reporting > 0) out.push_back(sum.num_reporting == 1 ? sum.last : sum.all);
  }
  return out;
}

}  // namespace

std::string to_json(const RunSummary& s) {
  Json stages = Json::object();
  for (const auto& [stage, wall_s] : s.stage_wall_s) stages[stage] = wall_s;
  const Json json = {{"scenario", s.scenario},
                     {"seed", s.seed},
                     {"outcome", s.outcome},
                     {"state_hash", hex64(s.state_hash)},
                     {"version", version()},
                     {"git_revision", git_revision()},
                     {"threads", s.threads},
                     {"simulated_s", s.simulated_s},
                     {"wall_s", s.wall_s},
                     {"setup_wall_s", s.setup_wall_s},
                     {"real_time_factor", s.real_time_factor()},
                     {"stage_wall_s", stages},
                     {"metrics", metrics_json(s.metrics)},
                     {"detection_over_distance", detection_json(s.metrics)},
                     {"radio", radio_json(s)},
                     {"counters", counters_json(s.counters)}};
  return json.dump(2) + "\n";
}

std::string to_text(const std::vector<Counter>& counters) {
  std::string out;
  for (const Counter& counter : summed_over_vehicles(counters)) {
    out += "  " + counter.setting + ": " + std::to_string(counter.count);
    if (counter.of > 0) out += " of " + std::to_string(counter.of);
    out += " " + counter.what + "\n";
  }
  return out;
}

std::string to_text(const RunSummary& s) {
  std::string out = fmt::format(
      "{}, seed {}: {}\n  {:.1f} s flown in {:.1f} s ({:.1f} x real time) after {:.1f} s of set-up, state hash {}\n"
      "  wall time:",
      s.scenario, s.seed, s.outcome, s.simulated_s, s.wall_s, s.real_time_factor(), s.setup_wall_s,
      hex64(s.state_hash));
  for (const auto& [stage, wall_s] : s.stage_wall_s) out += fmt::format(" {} {:.1f} s", stage, wall_s);
  out += "\n";
  for (const MetricRow& row : s.metrics.rows()) {
    if (row.vehicle.empty() && row.name != "outcome") out += "  " + row.name + ": " + number_text(row) + "\n";
  }
  out += vehicle_table(s.metrics);
  return out + to_text(s.counters);
}

}  // namespace swiftlet::sim
