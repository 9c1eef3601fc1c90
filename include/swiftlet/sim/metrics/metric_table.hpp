// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace swiftlet::sim {

/// Definition of a result: its line in docs/metrics.md.
struct MetricDefinition {
  const char* name;        ///< with its unit as suffix: "path_length_m"
  const char* unit;        ///< "m", "s", "m/s" ...; empty: a plain number or a word
  const char* definition;  ///< measured quantity, time and reference
};

/// One result: a number, or a word when `text` is not empty.
struct MetricRow {
  std::string name;     ///< with its unit as suffix: "path_length_m"
  std::string vehicle;  ///< empty: the whole run
  double value = 0.0;   ///< NaN: not measured (no estimate, no other vehicle ...)
  std::string unit;     ///< "m", "s", "m/s" ...; empty: a plain number or a word
  std::string text;
};

/// Scores of a vehicle's detector or tracker for targets in one distance interval.
struct DistanceBin {
  std::string vehicle;  ///< the observer
  std::string stage;    ///< "detector", "tracker"
  double from_m = 0.0, to_m = 0.0;
  int targets = 0;                               ///< scans, counted for each target in them
  double recall = 0.0;                           ///< eq. (71)
  double recall_visible = 0.0;                   ///< recall over the targets with returns in the scan
  double error_mean_m = 0.0, error_std_m = 0.0;  ///< eq. (68)
  double speed_error_mean_mps = 0.0;             ///< eq. (69)
  double direction_error_mean_rad = 0.0;         ///< eq. (70)
};

/// Results in the order of insertion; the names are equal for every run of a scenario.
class MetricTable {
 public:
  void add(const MetricDefinition& what, std::string vehicle, double value) {
    add(what.name, std::move(vehicle), value, what.unit);
  }
  void add_text(const MetricDefinition& what, std::string vehicle, std::string text) {
    add_text(std::string(what.name), std::move(vehicle), std::move(text));
  }
  void add(std::string name, std::string vehicle, double value, std::string unit) {
    rows_.push_back({std::move(name), std::move(vehicle), value, std::move(unit), {}});
  }
  void add_text(std::string name, std::string vehicle, std::string text) {
    rows_.push_back({std::move(name), std::move(vehicle), 0.0, {}, std::move(text)});
  }
  void add(DistanceBin bin) { bins_.push_back(std::move(bin)); }
  const std::vector<MetricRow>& rows() const { return rows_; }
  const std::vector<DistanceBin>& bins() const { return bins_; }
  const MetricRow* find(std::string_view name, std::string_view vehicle = {}) const;

 private:
  std::vector<MetricRow> rows_;
  std::vector<DistanceBin> bins_;
};

}  // namespace swiftlet::sim
