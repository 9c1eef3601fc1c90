// SPDX-License-Identifier: BSD-3-Clause
#include <charconv>
#include <cmath>
#include <map>

#include "sim/batch/result_store.hpp"
#include "sim/run/run_directory.hpp"

namespace swiftlet::sim {
namespace {

/// RFC 4180: quoted where it must be.
std::string cell(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

/// Shortest text that reads back as the same number; nothing for what was not measured.
std::string cell(double value) {
  if (!std::isfinite(value)) return "";
  char text[32];
  const auto [end, error] = std::to_chars(text, text + sizeof text, value);
  return std::string(text, end);
}

std::string cell(const MetricRow& row) { return row.text.empty() ? cell(row.value) : cell(row.text); }

std::string column(const MetricRow& row) { return row.vehicle.empty() ? row.name : row.vehicle + "." + row.name; }

std::string episodes_csv(const BatchInfo& info, const std::vector<EpisodeRow>& rows) {
  std::vector<std::string> columns;  // in the order of their first appearance
  std::map<std::string, std::size_t> index;
  for (const EpisodeRow& row : rows) {
    for (const MetricRow& metric : row.metrics) {
      if (index.emplace(column(metric), columns.size()).second) columns.push_back(column(metric));
    }
  }
  std::string text = "episode,variant,point,seed";
  for (const std::string& name : info.parameters) text += "," + cell(name);
  text += ",status,state_hash,simulated_s,wall_s";
  for (const std::string& name : columns) text += "," + cell(name);
  text += ",message,command\n";
  std::vector<std::string> cells(columns.size());
  for (const EpisodeRow& row : rows) {
    text += std::to_string(row.id) + "," + cell(row.variant) + "," + std::to_string(row.point) + "," +
            std::to_string(row.seed);
    for (const std::string& value : row.parameters) text += "," + cell(value);
    text += "," + row.status + "," + row.state_hash + "," + cell(row.simulated_s) + "," + cell(row.wall_s);
    std::fill(cells.begin(), cells.end(), "");
    for (const MetricRow& metric : row.metrics) cells[index.at(column(metric))] = cell(metric);
    for (const std::string& value : cells) text += "," + value;
    text += "," + cell(row.message) + "," + cell(row.command) + "\n";
  }
  return text;
}

std::string metrics_csv(const std::vector<EpisodeRow>& rows) {
  std::string text = "episode,variant,point,seed,vehicle,metric,value,unit\n";
  for (const EpisodeRow& row : rows) {
    const std::string head = std::to_string(row.id) + "," + cell(row.variant) + "," + std::to_string(row.point) + "," +
                             std::to_string(row.seed) + ",";
    for (const MetricRow& metric : row.metrics) {
      text +=
          head + cell(metric.vehicle) + "," + cell(metric.name) + "," + cell(metric) + "," + cell(metric.unit) + "\n";
    }
  }
  return text;
}

}  // namespace

void export_csv(const ResultStore& store, const std::filesystem::path& directory) {
  const auto info = store.info();
  if (!info) return;
  const std::vector<EpisodeRow> rows = store.episodes();
  write_file(directory / "episodes.csv", episodes_csv(*info, rows));
  write_file(directory / "metrics.csv", metrics_csv(rows));
}

}  // namespace swiftlet::sim
