// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sim/physics/physics_world.hpp"
#include "swiftlet/sim/recorder.hpp"
#include "swiftlet/sim/scenario.hpp"
#include "swiftlet/sim/series.hpp"

namespace swiftlet::sim {

/// One result: a number, or a word when `text` is not empty.
struct MetricRow {
  std::string name;     ///< with its unit as suffix: "path_length_m"
  std::string vehicle;  ///< empty: of the whole run
  double value = 0.0;   ///< NaN: not measured (no estimate, no other vehicle ...)
  std::string unit;     ///< "m", "s", "m/s" ...; empty: a plain number or a word
  std::string text;
};

/// How well a vehicle's detector or tracker did on targets at some distance.
struct DistanceBin {
  std::string vehicle;  ///< the observer
  std::string stage;    ///< "detector", "tracker"
  double from_m = 0.0, to_m = 0.0;
  int targets = 0;                               ///< scans, counted for each target in them
  double recall = 0.0;                           ///< eq. (71)
  double recall_visible = 0.0;                   ///< of the targets that have returns in the scan
  double error_mean_m = 0.0, error_std_m = 0.0;  ///< eq. (68)
  double speed_error_mean_mps = 0.0;             ///< eq. (69)
  double direction_error_mean_rad = 0.0;         ///< eq. (70)
};

/// Results in the order in which they were added; the same names for every run of a scenario.
class MetricTable {
 public:
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

/// What of a vehicle's perception there is to measure.
struct Perception {
  bool detects = false, tracks = false;
};

/// What stays the same during a run.
struct MetricSetup {
  std::vector<std::string> vehicle_names;  ///< by VehicleId
  std::vector<Perception> perception;      ///< by VehicleId; empty: none
  MetricsConfig config;
};

/// What a tick tells beyond its TickView. Spans by VehicleId.
struct MetricContext {
  double dt_s = 0.0;  ///< since the last tick
  std::span<const Clearance> clearances;
  std::span<const char> flying;  ///< 1: off the ground and not crashed
};

/// Compares truth with what vehicles made of it, tick by tick; update() never allocates.
class Metric {
 public:
  explicit Metric(const MetricSetup& setup) : setup_(setup) {}
  virtual ~Metric() = default;
  virtual void update(const TickView& tick, const MetricContext& context) = 0;
  virtual void report(MetricTable& table) const = 0;
  /// Its tables; rows are those of this tick.
  std::span<const std::unique_ptr<Series>> series() const { return series_; }

 protected:
  /// A table of the kind `Row` for recorders; whoever calls update() empties it before. Call this in a constructor.
  template <class Row>
  SeriesOf<Row>& add_series() {
    auto table = std::make_unique<SeriesOf<Row>>();
    SeriesOf<Row>& added = *table;
    series_.push_back(std::move(table));
    return added;
  }
  std::size_t num_vehicles() const { return setup_.vehicle_names.size(); }
  const std::string& name_of(std::size_t vehicle) const { return setup_.vehicle_names[vehicle]; }
  const MetricSetup& setup() const { return setup_; }

 private:
  MetricSetup setup_;
  std::vector<std::unique_ptr<Series>> series_;
};

/// One row of sim/metrics/metrics.cpp.
struct MetricType {
  const char* name;
  const char* doc;
  std::unique_ptr<Metric> (*make)(const MetricSetup& setup);
};

std::span<const MetricType> metric_types();

// The metrics of this room; each in the file of its name.
std::unique_ptr<Metric> make_outcome_metric(const MetricSetup& setup);
std::unique_ptr<Metric> make_motion_metric(const MetricSetup& setup);
std::unique_ptr<Metric> make_estimate_error_metric(const MetricSetup& setup);
std::unique_ptr<Metric> make_tracking_error_metric(const MetricSetup& setup);
std::unique_ptr<Metric> make_clearance_metric(const MetricSetup& setup);
std::unique_ptr<Metric> make_detection_metric(const MetricSetup& setup);

}  // namespace swiftlet::sim
