// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "swiftlet/core/capture_volume.hpp"
#include "swiftlet/sim/metrics/metric_table.hpp"
#include "swiftlet/sim/metrics/metrics_config.hpp"
#include "swiftlet/sim/view/tick_view.hpp"
#include "swiftlet/sim/world/neighborhood.hpp"

namespace swiftlet::sim {

/// What of a vehicle's perception there is to measure.
struct Perception {
  bool detects = false, tracks = false;
  std::optional<CaptureVolume> net;  ///< with which it catches others
  int captures = 0;                  ///< number that ends the mission; 0: none
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
  std::span<const Series* const>
      series;  ///< all tables; those of metrics after this one in the registry are up to date
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
  std::span<const MetricDefinition> definitions;  ///< that it may report; empty: not told
};

/// For rows of the table.
template <class M>
std::unique_ptr<Metric> make_metric(const MetricSetup& setup) {
  return std::make_unique<M>(setup);
}

/// What every simulation that is made later measures; a program may add its own.
std::vector<MetricType>& metric_registry();

/// A word for how a run or a vehicle ended, and what it means.
struct OutcomeWord {
  const char* name;
  const char* definition;
};

/// From best to worst: a run is as good as its worst vehicle.
std::span<const OutcomeWord> outcome_words();

/// What tables of batches tell of the radio.
struct RadioMetrics {
  MetricDefinition sent = {"radio_sent", "", "messages that vehicles handed to their radios"};
  MetricDefinition delivered = {"radio_delivered", "",
                                "receptions: a message that three vehicles receive counts three times"};
  MetricDefinition bytes = {"radio_bytes", "B", "of the messages sent, headers included"};
  MetricDefinition mean_delay = {"radio_mean_delay_s", "s", "mean time from sending to reception"};
};
inline constexpr RadioMetrics kRadioMetrics;

}  // namespace swiftlet::sim
