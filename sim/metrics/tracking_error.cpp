// SPDX-License-Identifier: BSD-3-Clause
#include "sim/metrics/statistics.hpp"
#include "swiftlet/sim/metrics/metric.hpp"

namespace swiftlet::sim {
namespace {

/// Position against the reference after the reference governor, while flying with a valid estimate. `tracking_error`:
/// the truth (what counts; meaningless when the vehicle's frame is a local one); `control_error`: the estimate, which
/// shows the controller's own share.
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
      table.add("tracking_error_rms_m", name_of(i), vehicles_[i].truth.rms(), "m");
      table.add("tracking_error_max_m", name_of(i), vehicles_[i].truth.max(), "m");
      table.add("control_error_rms_m", name_of(i), vehicles_[i].estimate.rms(), "m");
      table.add("control_error_max_m", name_of(i), vehicles_[i].estimate.max(), "m");
    }
  }

 private:
  struct Vehicle {
    ErrorStatistics truth, estimate;
  };

  std::vector<Vehicle> vehicles_;
};

}  // namespace

std::unique_ptr<Metric> make_tracking_error_metric(const MetricSetup& setup) {
  return std::make_unique<TrackingErrorMetric>(setup);
}

}  // namespace swiftlet::sim
