// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/metrics/metrics.hpp"

#include <stdexcept>
#include <string>

#include "swiftlet/core/base/ensure.hpp"

namespace swiftlet::sim {

// One metric per file of that name: a new metric needs a line here and one in metric_registry().
MetricType outcome_metric();
MetricType motion_metric();
MetricType estimate_error_metric();
MetricType tracking_error_metric();
MetricType clearance_metric();
MetricType detection_metric();
MetricType relative_error_metric();
MetricType capture_metric();
MetricType joined_maps_metric();

namespace {

// A vehicle at rest, nearer to a surface than its own radius, stands on it.
constexpr double kRestSpeed_mps = 0.1;

bool is_flying(const VehicleState& state, const Clearance& clearance) {
  return !state.crashed && (clearance.surface_m > 0.0 || state.v_world_mps.norm() > kRestSpeed_mps);
}

}  // namespace

void MetricsConfig::visit(ConfigVisitor& v) {
  v.field("true_positive_m", true_positive_m,
          "[m] largest distance of a detection or track from the vehicle that it is assigned to", Range::positive());
  v.field("detection_range_m", detection_range_m, "[m] distance up to which vehicles count for recall",
          Range::positive());
  v.field("detection_bin_m", detection_bin_m, "[m] width of the distance bins of recall and errors",
          Range::between(0.001, 1e6));
  v.field("stop_on_crash", stop_on_crash, "[-] whether the run ends at the first crash");
  v.field("stop_when_done", stop_when_done, "[-] whether the run ends when every mission is done, failed or crashed");
}

std::vector<MetricType>& metric_registry() {
  static std::vector<MetricType> types = {
      outcome_metric(),   motion_metric(),         estimate_error_metric(), tracking_error_metric(), clearance_metric(),
      detection_metric(), relative_error_metric(), capture_metric(),        joined_maps_metric(),
  };
  return types;
}

std::vector<TableType> series_types() {
  const Metrics metrics({}, {});
  std::vector<TableType> types;
  for (const Series* table : metrics.series()) types.push_back({table->name(), table->columns()});
  return types;
}

std::optional<std::vector<std::string>> metric_names() {
  std::vector<std::string> names = {kRadioMetrics.sent.name, kRadioMetrics.delivered.name, kRadioMetrics.bytes.name,
                                    kRadioMetrics.mean_delay.name};
  for (const MetricType& type : metric_registry()) {
    if (type.definitions.empty()) return std::nullopt;
    for (const MetricDefinition& metric : type.definitions) names.emplace_back(metric.name);
  }
  return names;
}

const MetricRow* MetricTable::find(std::string_view name, std::string_view vehicle) const {
  for (const MetricRow& row : rows_) {
    if (row.name == name && row.vehicle == vehicle) return &row;
  }
  return nullptr;
}

Metrics::Metrics(const MetricsConfig& config, std::vector<std::string> vehicle_names,
                 std::vector<Perception> perception)
    : flying_(vehicle_names.size(), 0) {
  perception.resize(vehicle_names.size());
  const MetricSetup setup{std::move(vehicle_names), std::move(perception), config};
  for (const MetricType& type : metric_registry()) {
    auto metric = type.make(setup);
    if (metric == nullptr)
      throw std::runtime_error("the maker of the metric '" + std::string(type.name) + "' returned nothing");
    metrics_.push_back(std::move(metric));
    for (const auto& table : metrics_.back()->series()) series_.push_back(table.get());
  }
}

void Metrics::update(const TickView& tick, std::span<const Clearance> clearances) {
  const std::size_t count = flying_.size();
  ENSURE(tick.states.size() == count && clearances.size() == count && tick.actions.size() == count, count,
         tick.states.size(), clearances.size(), tick.actions.size());
  ENSURE(tick.t > t_last_, to_seconds(tick.t), to_seconds(t_last_));
  for (std::size_t i = 0; i < count; ++i) flying_[i] = is_flying(tick.states[i], clearances[i]);
  const MetricContext context{to_seconds(tick.t - t_last_), clearances, flying_, series_};
  // In reverse order: the outcome, first in every report, depends on captures.
  for (auto metric = metrics_.rbegin(); metric != metrics_.rend(); ++metric) {
    for (const auto& table : (*metric)->series()) table->clear();
    (*metric)->update(tick, context);
  }
  t_last_ = tick.t;
}

MetricTable Metrics::report() const {
  MetricTable table;
  for (const auto& metric : metrics_) metric->report(table);
  return table;
}

std::string Metrics::outcome() const { return report().find("outcome")->text; }

}  // namespace swiftlet::sim
