// SPDX-License-Identifier: BSD-3-Clause
#include "sim/batch/episode.hpp"

#include <chrono>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "swiftlet/core/base/time.hpp"
#include "swiftlet/sim/metrics/metric.hpp"
#include "swiftlet/sim/run/summary.hpp"
#include "swiftlet/sim/scenario/yaml_writer.hpp"

namespace swiftlet::sim {
namespace {

using Json = nlohmann::json;
using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

// JSON has no NaN and no infinity; unmeasured values are null.
Json number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }
double number(const Json& value) {
  return value.is_null() ? std::numeric_limits<double>::quiet_NaN() : value.get<double>();
}

void add_radio(std::vector<MetricRow>& rows, const RadioStatistics& radio) {
  const auto add = [&](const MetricDefinition& what, double value) {
    rows.push_back({what.name, "", value, what.unit, ""});
  };
  add(kRadioMetrics.sent, static_cast<double>(radio.sent));
  add(kRadioMetrics.delivered, static_cast<double>(radio.delivered));
  add(kRadioMetrics.bytes, static_cast<double>(radio.bytes_sent));
  add(kRadioMetrics.mean_delay, radio.delivered > 0 ? radio.mean_delay_s : std::numeric_limits<double>::quiet_NaN());
}

}  // namespace

std::string to_bytes(const EpisodeResult& result) {
  Json metrics = Json::array();
  for (const MetricRow& row : result.metrics) {
    metrics.push_back({row.name, row.vehicle, number(row.value), row.unit, row.text});
  }
  const Json json = {{"outcome", result.outcome},           {"state_hash", result.state_hash},
                     {"simulated_s", result.simulated_s},   {"metrics", std::move(metrics)},
                     {"setup_wall_s", result.setup_wall_s}, {"flight_wall_s", result.flight_wall_s},
                     {"built_world", result.built_world}};
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

EpisodeResult episode_result_from_bytes(const std::string& bytes) {
  const Json json = Json::parse(bytes);
  EpisodeResult result;
  result.outcome = json.at("outcome");
  result.state_hash = json.at("state_hash");
  result.simulated_s = json.at("simulated_s");
  for (const Json& row : json.at("metrics")) {
    result.metrics.push_back({row[0], row[1], number(row[2]), row[3], row[4]});
  }
  result.setup_wall_s = json.at("setup_wall_s");
  result.flight_wall_s = json.at("flight_wall_s");
  result.built_world = json.at("built_world");
  return result;
}

std::pair<World, bool> WorldCache::get(const Scenario& scenario) {
  Module config = scenario.world;
  const std::string key = config.type + " " + std::to_string(scenario.seed_of_world()) + "\n" +
                          write_config([&](ConfigVisitor& v) { config.config->visit(v); });
  for (auto it = worlds_.begin(); it != worlds_.end(); ++it) {
    if (it->first != key) continue;
    worlds_.splice(worlds_.begin(), worlds_, it);
    return {worlds_.front().second, false};
  }
  // Before building, so that an evicted and a new world are never in memory together
  while (worlds_.size() >= capacity_) worlds_.pop_back();
  worlds_.emplace_front(key, build_world(scenario.world, scenario.seed_of_world()));
  return {worlds_.front().second, true};
}

// Episodes of one point and variant differ only in their seed.
Scenario EpisodeRunner::scenario_of(const Episode& episode) {
  if (episode.point != point_) scenarios_.clear();
  point_ = episode.point;
  const auto known = scenarios_.find(episode.variant);
  Scenario scenario = known != scenarios_.end() ? known->second : plan_.scenario_of(episode);
  if (known == scenarios_.end()) {
    scenario.recorders.clear();
    scenario.snapshots.clear();
    scenarios_.emplace(episode.variant, scenario);
  }
  scenario.seed = episode.seed;
  return scenario;
}

EpisodeResult EpisodeRunner::fly(std::uint64_t id) {
  const auto start = Clock::now();
  const Scenario scenario = scenario_of(plan_.episode(id));
  auto [world, built] = worlds_.get(scenario);
  Simulation simulation(scenario, plan_.config().threads, std::move(world));
  const auto ready = Clock::now();
  EpisodeResult result;
  result.setup_wall_s = seconds_since(start);
  while (!simulation.finished()) simulation.tick();
  simulation.finish();

  const RunSummary summary = simulation.summary();
  result.outcome = summary.outcome;
  result.state_hash = summary.state_hash;
  result.simulated_s = summary.simulated_s;
  result.metrics = summary.metrics.rows();
  add_radio(result.metrics, summary.radio);
  result.flight_wall_s = seconds_since(ready);
  result.built_world = built;
  return result;
}

}  // namespace swiftlet::sim
