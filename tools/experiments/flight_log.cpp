// SPDX-License-Identifier: BSD-3-Clause
#include "flight_log.hpp"

#include <fmt/format.h>

#include <limits>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "swiftlet/sim/run/version.hpp"

namespace swiftlet::tools {
namespace {

using Json = nlohmann::ordered_json;

// JSON has no NaN; null stands for it.
double number_of(const Json& value) {
  return value.is_null() ? std::numeric_limits<double>::quiet_NaN() : value.get<double>();
}

Json line_of(const std::string& key, const FinishedFlight& flight) {
  const sim::RunSummary& summary = flight.summary;
  Json metrics = Json::array();
  for (const sim::MetricRow& row : summary.metrics.rows()) {
    if (row.text.empty()) metrics.push_back({row.name, row.vehicle, row.value, row.unit});
  }
  return {{"key", key},
          {"scenario", summary.scenario},
          {"seed", summary.seed},
          {"outcome", summary.outcome},
          {"state_hash", fmt::format("{:016x}", summary.state_hash)},
          {"simulated_s", summary.simulated_s},
          {"metrics", std::move(metrics)},
          {"notes", flight.notes}};
}

FinishedFlight flight_of(const Json& line) {
  FinishedFlight flight;
  flight.summary.scenario = line.at("scenario").get<std::string>();
  flight.summary.seed = line.at("seed").get<std::uint64_t>();
  flight.summary.outcome = line.at("outcome").get<std::string>();
  flight.summary.state_hash = std::stoull(line.at("state_hash").get<std::string>(), nullptr, 16);
  flight.summary.simulated_s = line.at("simulated_s").get<double>();
  for (const Json& row : line.at("metrics")) {
    flight.summary.metrics.add(row.at(0).get<std::string>(), row.at(1).get<std::string>(), number_of(row.at(2)),
                               row.at(3).get<std::string>());
  }
  for (const Json& note : line.at("notes")) flight.notes.push_back(number_of(note));
  return flight;
}

}  // namespace

FlightLog::FlightLog(const std::filesystem::path& file, bool resume) : path_(file) {
  const bool whole_lines = !resume || read();
  out_.open(path_, resume ? std::ios::app : std::ios::trunc);
  if (!whole_lines) out_ << std::endl;
  if (!out_) throw std::runtime_error(path_.string() + ": cannot be written");
}

/// @return  whether the last line is complete
bool FlightLog::read() {
  std::ifstream in(path_);
  bool whole = true;
  for (std::string text; std::getline(in, text);) {
    whole = !in.eof();
    try {
      const Json line = Json::parse(text);
      flights_.emplace(line.at("key").get<std::string>(), flight_of(line));
    } catch (const std::exception&) {
      continue;  // incomplete or invalid: fly again
    }
  }
  return whole;
}

// FNV-1a.
std::string FlightLog::key_of(const sim::Scenario& scenario) {
  std::uint64_t hash = 0xcbf29ce484222325;
  for (const char c : sim::write_scenario(scenario) + sim::git_revision()) {
    hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3;
  }
  return fmt::format("{:016x}", hash);
}

const FinishedFlight* FlightLog::find(const std::string& key) const {
  const auto found = flights_.find(key);
  return found == flights_.end() ? nullptr : &found->second;
}

void FlightLog::add(const std::string& key, const FinishedFlight& flight) {
  const std::string line = line_of(key, flight).dump() + '\n';
  const std::lock_guard lock(writing_);
  out_ << line << std::flush;
  if (!out_) throw std::runtime_error(path_.string() + ": cannot be written");
}

}  // namespace swiftlet::tools
