// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "swiftlet/core/base/capture_volume.hpp"
#include "swiftlet/sim/metrics/metric_table.hpp"
#include "swiftlet/sim/metrics/metrics_config.hpp"
#include "swiftlet/sim/recording/tick_view.hpp"
#include "swiftlet/sim/world/neighborhood.hpp"

namespace swiftlet::sim {

/// Perception and capture abilities of a vehicle, which determine the metrics that apply.
struct Perception {
  bool detects = false, tracks = false;
  std::optional<CaptureVolume> net;  ///< net for captures of other vehicles
  int captures = 0;                  ///< number of captures that completes the mission; 0: none
};

/// Data that is constant during a run.
struct MetricSetup {
  std::vector<std::string> vehicle_names;  ///< indexed by VehicleId
  std::vector<Perception> perception;      ///< indexed by VehicleId; empty: none
  MetricsConfig config;
};

/// Data of a tick beyond its TickView. Spans are indexed by VehicleId.
struct MetricContext {
  double dt_s = 0.0;  ///< since the last tick
  std::span<const Clearance> clearances;
  std::span<const char> flying;  ///< 1: off the ground and not crashed
  /// All tables; those of later rows of the registry are already updated in this tick
  std::span<const Series* const> series;
};

/// Compares the truth with the vehicles' estimates, tick by tick; update() never allocates.
class Metric {
 public:
  explicit Metric(const MetricSetup& setup) : setup_(setup) {}
  virtual ~Metric() = default;
  virtual void update(const TickView& tick, const MetricContext& context) = 0;
  virtual void report(MetricTable& table) const = 0;
  /// Tables of this metric, with the rows of the current tick.
  std::span<const std::unique_ptr<Series>> series() const { return series_; }

 protected:
  /// Creates a table with rows of type `Row` for recorders. The caller of update() clears it before. Call this in a
  /// constructor.
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

/// Implementation of related metrics, with their definitions for the reference; the list is in sim/metrics/metrics.cpp.
struct MetricType {
  const char* name;
  const char* doc;
  std::unique_ptr<Metric> (*make)(const MetricSetup& setup);
  std::span<const MetricDefinition> definitions;  ///< metrics that it may report; empty: unknown in advance
};

/// Factory for rows of the table.
template <class M>
std::unique_ptr<Metric> make_metric(const MetricSetup& setup) {
  return std::make_unique<M>(setup);
}

/// Metrics of all simulations created later; a program may add its own.
std::vector<MetricType>& metric_registry();

/// An outcome of a run or a vehicle, and its meaning.
struct OutcomeDefinition {
  const char* name;
  const char* definition;
};

/// From best to worst: the outcome of a run is the worst of its vehicles.
std::span<const OutcomeDefinition> outcome_definitions();

/// Radio metrics in tables of batches.
struct RadioMetrics {
  MetricDefinition sent = {"radio_sent", "", "messages posted by the vehicles"};
  MetricDefinition delivered = {"radio_delivered", "",
                                "receptions: a message that three vehicles receive counts three times"};
  MetricDefinition bytes = {"radio_bytes", "B", "size of the sent messages, headers included"};
  MetricDefinition mean_delay = {"radio_mean_delay_s", "s", "mean time from sending to reception"};
};
inline constexpr RadioMetrics kRadioMetrics;

}  // namespace swiftlet::sim
