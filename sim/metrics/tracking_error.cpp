// SPDX-License-Identifier: BSD-3-Clause
#include "sim/metrics/statistics.hpp"
#include "swiftlet/sim/metrics/metric.hpp"

namespace swiftlet::sim {
namespace {

// Reported metrics:
constexpr MetricDefinition kTrackingRms = {"tracking_error_rms_m", "m",
                                           "root mean square of |true position - reference| after the reference "
                                           "governor, in flight with a valid estimate; world frame"};
constexpr MetricDefinition kTrackingMax = {"tracking_error_max_m", "m",
                                           "largest |true position - reference| over the same ticks"};
constexpr MetricDefinition kControlRms = {
    "control_error_rms_m", "m",
    "root mean square of |estimated position - reference|: the contribution of the controller"};
constexpr MetricDefinition kControlMax = {"control_error_max_m", "m",
                                          "largest |estimated position - reference| over the same ticks"};
constexpr MetricDefinition kTrackingErrorDefinitions[] = {kTrackingRms, kTrackingMax, kControlRms, kControlMax};

/// Position error against the reference after the reference governor, in flight with a valid estimate.
/// `tracking_error`: error of the truth (meaningless when the vehicle's frame is a local one); `control_error`: error
/// of the estimate, which is the controller's own contribution.
class TrackingErrorMetric final : public Metric {
 public:
  explicit TrackingErrorMetric(const MetricSetup& setup) : Metric(setup), vehicles_(num_vehicles()) {}

  void update(const TickView& tick, const MetricContext& context) override {
    for (std::size_t i = 0; i < num_vehicles(); ++i) {
      const Action& action = *tick.actions[i];
      if (!context.flying[i] || !action.estimate.valid) continue;
      const Vector3& reference = action.reference.position_m;
      vehicles_[i].truth.add((tick.states[i].p_world_m - reference).norm());
      vehicles_[i].estimate.add((action.estimate.T_world_body().translation() - reference).norm());
    }
  }

  void report(MetricTable& table) const override {
    for (std::size_t i = 0; i < num_vehicles(); ++i) {
      table.add(kTrackingRms, name_of(i), vehicles_[i].truth.rms());
      table.add(kTrackingMax, name_of(i), vehicles_[i].truth.max());
      table.add(kControlRms, name_of(i), vehicles_[i].estimate.rms());
      table.add(kControlMax, name_of(i), vehicles_[i].estimate.max());
    }
  }

 private:
  struct Vehicle {
    ErrorStatistics truth, estimate;
  };

  std::vector<Vehicle> vehicles_;
};

}  // namespace

MetricType tracking_error_metric() {
  return {"tracking_error", "true and estimated position against the reference", make_metric<TrackingErrorMetric>,
          kTrackingErrorDefinitions};
}

}  // namespace swiftlet::sim
