// SPDX-License-Identifier: BSD-3-Clause
#include <map>

#include "swiftlet/sim/batch/result_store.hpp"
#include "swiftlet/sim/io/files.hpp"
#include "swiftlet/sim/io/text.hpp"

namespace swiftlet::sim {
namespace {

std::string cell(const MetricRow& row) { return row.text.empty() ? csv_cell(row.value) : csv_cell(row.text); }

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
  for (const std::string& name : info.parameters) text += "," + csv_cell(name);
  text += ",status,state_hash,simulated_s,wall_s";
  for (const std::string& name : columns) text += "," + csv_cell(name);
  text += ",message,command\n";
  std::vector<std::string> cells(columns.size());
  for (const EpisodeRow& row : rows) {
    text += std::to_string(row.id) + "," + csv_cell(row.variant) + "," + std::to_string(row.point) + "," +
            std::to_string(row.seed);
    for (const std::string& value : row.parameters) text += "," + csv_cell(value);
    text += "," + row.status + "," + row.state_hash + "," + csv_cell(row.simulated_s) + "," + csv_cell(row.wall_s);
    std::fill(cells.begin(), cells.end(), "");
    for (const MetricRow& metric : row.metrics) cells[index.at(column(metric))] = cell(metric);
    for (const std::string& value : cells) text += "," + value;
    text += "," + csv_cell(row.message) + "," + csv_cell(row.command) + "\n";
  }
  return text;
}

std::string metrics_csv(const std::vector<EpisodeRow>& rows) {
  std::string text = "episode,variant,point,seed,vehicle,metric,value,unit\n";
  for (const EpisodeRow& row : rows) {
    const std::string head = std::to_string(row.id) + "," + csv_cell(row.variant) + "," + std::to_string(row.point) +
                             "," + std::to_string(row.seed) + ",";
    for (const MetricRow& metric : row.metrics) {
      text += head + csv_cell(metric.vehicle) + "," + csv_cell(metric.name) + "," + cell(metric) + "," +
              csv_cell(metric.unit) + "\n";
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
