// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <limits>
#include <optional>
#include <vector>

#include "sim/metrics/statistics.hpp"
#include "swiftlet/core/base/capture_volume.hpp"
#include "swiftlet/sim/metrics/capture_record.hpp"
#include "swiftlet/sim/metrics/metric.hpp"

namespace swiftlet::sim {
namespace {

// Reported metrics:
constexpr MetricDefinition kCaptures = {"captures", "",
                                        "number of times that another vehicle flew into the net; a vehicle counts "
                                        "again once it has been farther than the net's rearm_m"};
constexpr MetricDefinition kTimeToFirstCapture = {"time_to_first_capture_s", "s", "time of the first capture"};
constexpr MetricDefinition kCapturesPerMin = {"captures_per_min", "1/min", "captures / time until the own crash"};
constexpr MetricDefinition kCaptureMiss = {"capture_miss_mean_m", "m",
                                           "mean distance from the center of the net to the meeting point of a target"};
constexpr MetricDefinition kMinNetDistance = {
    "least_net_distance_m", "m", "least distance from the center of the net to another vehicle in any tick"};
constexpr MetricDefinition kCaptureDefinitions[] = {kCaptures, kTimeToFirstCapture, kCapturesPerMin, kCaptureMiss,
                                                    kMinNetDistance};

/// Captures from true positions. Between ticks, target and net are interpolated linearly, so that the count does not
/// depend on the tick length. A target counts again once it has been farther from the net than `rearm_m`.
class CaptureMetric final : public Metric {
 public:
  explicit CaptureMetric(const MetricSetup& setup)
      : Metric(setup), captures_(add_series<CaptureRecord>()), vehicles_(num_vehicles()) {
    for (std::size_t i = 0; i < num_vehicles() && i < setup.perception.size(); ++i) {
      vehicles_[i].net = setup.perception[i].net;
      if (vehicles_[i].net) vehicles_[i].targets.resize(num_vehicles());
    }
  }

  void update(const TickView& tick, const MetricContext& context) override {
    for (std::size_t i = 0; i < num_vehicles(); ++i) {
      if (vehicles_[i].net && !tick.states[i].crashed) cast(i, tick, context.dt_s);
    }
  }

  void report(MetricTable& table) const override {
    for (std::size_t i = 0; i < num_vehicles(); ++i) {
      const Vehicle& vehicle = vehicles_[i];
      if (!vehicle.net) continue;
      const auto count = static_cast<double>(vehicle.count);
      table.add(kCaptures, name_of(i), count);
      table.add(kTimeToFirstCapture, name_of(i), vehicle.first_s);
      table.add(kCapturesPerMin, name_of(i), vehicle.flown_s > 0.0 ? 60.0 * count / vehicle.flown_s : kNotMeasured);
      table.add(kCaptureMiss, name_of(i), vehicle.count > 0 ? vehicle.miss_sum_m / count : kNotMeasured);
      table.add(kMinNetDistance, name_of(i), vehicle.flown_s > 0.0 ? vehicle.least_m : kNotMeasured);
    }
  }

 private:
  struct Target {
    bool known = false, armed = true;
    Vector3 p_net_m = Vector3::Zero();  // in the last tick, relative to the center of the net
  };
  struct Vehicle {
    std::optional<CaptureVolume> net;
    std::vector<Target> targets;  // indexed by VehicleId
    int count = 0;
    double first_s = kNotMeasured, flown_s = 0.0, miss_sum_m = 0.0;
    double least_m = std::numeric_limits<double>::infinity();
  };

  void cast(std::size_t i, const TickView& tick, double dt_s) {
    Vehicle& vehicle = vehicles_[i];
    vehicle.flown_s += dt_s;
    const VehicleState& self = tick.states[i];
    const Vector3 net_m = vehicle.net->center(self.p_world_m, yaw_of(self.q_world_body.toRotationMatrix()));
    for (std::size_t j = 0; j < num_vehicles(); ++j) {
      Target& target = vehicle.targets[j];
      if (j == i || tick.states[j].crashed) continue;
      const Vector3 p_net_m = tick.states[j].p_world_m - net_m;
      const Vector3 before_m = target.known ? target.p_net_m : p_net_m;
      const bool has_previous = target.known;
      target.known = true;
      target.p_net_m = p_net_m;
      vehicle.least_m = std::min(vehicle.least_m, p_net_m.norm());
      if (p_net_m.norm() > vehicle.net->rearm_m) target.armed = true;
      if (!has_previous || !target.armed) continue;
      const std::optional<double> miss_m = vehicle.net->met_m(before_m, p_net_m);
      if (!miss_m) continue;
      target.armed = false;
      ++vehicle.count;
      vehicle.miss_sum_m += *miss_m;
      if (std::isnan(vehicle.first_s)) vehicle.first_s = to_seconds(tick.t);
      captures_.push(static_cast<VehicleId>(i),
                     {tick.t, static_cast<VehicleId>(j), vehicle.count, *miss_m,
                      (p_net_m - before_m).norm() / std::max(dt_s, 1e-9), tick.states[j].p_world_m});
    }
  }

  SeriesOf<CaptureRecord>& captures_;
  std::vector<Vehicle> vehicles_;
};

}  // namespace

MetricType capture_metric() {
  return {"capture", "captures of vehicles by the nets of others", make_metric<CaptureMetric>, kCaptureDefinitions};
}

}  // namespace swiftlet::sim
