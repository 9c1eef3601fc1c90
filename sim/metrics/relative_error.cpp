// SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/Cholesky>
#include <numbers>

#include "sim/metrics/statistics.hpp"
#include "swiftlet/core/base/time.hpp"
#include "swiftlet/sim/metrics/metric.hpp"
#include "swiftlet/sim/metrics/relative_score.hpp"

namespace swiftlet::sim {
namespace {

// Reported metrics:
constexpr MetricDefinition kRelativeMae = {"relative_position_mae_m", "m",
                                           "mean of |estimated - true position of the other vehicle|, both relative to "
                                           "the own body, over the ticks with an estimate"};
constexpr MetricDefinition kRelativeRmse = {"relative_position_rmse_m", "m", "root mean square of the position errors"};
constexpr MetricDefinition kRelativeMax = {"relative_position_max_m", "m", "greatest of these errors"};
constexpr MetricDefinition kRelativeYawRmse = {
    "relative_yaw_rmse_rad", "rad", "root mean square error of the other vehicle's heading relative to the own one"};
constexpr MetricDefinition kRelativeNees = {"relative_nees", "",
                                            "mean normalized error squared of the position; 3 for correct covariances"};
constexpr MetricDefinition kRelativeKnown = {"relative_known_s", "s", "time with an estimate"};
constexpr MetricDefinition kRelativeErrorDefinitions[] = {kRelativeMae,     kRelativeRmse, kRelativeMax,
                                                          kRelativeYawRmse, kRelativeNees, kRelativeKnown};

/// Error of the observer's estimate of another vehicle's pose, relative to the observer's pose: errors of the
/// observer's localization do not count.
class RelativeErrorMetric final : public Metric {
 public:
  explicit RelativeErrorMetric(const MetricSetup& setup)
      : Metric(setup), scores_(add_series<RelativeScore>()), vehicles_(num_vehicles()) {}

  void update(const TickView& tick, const MetricContext& context) override {
    for (std::size_t i = 0; i < num_vehicles(); ++i) {
      for (const RelativeEstimate& relative : tick.actions[i]->relatives) {
        const auto other = static_cast<std::size_t>(relative.other);
        if (tick.states[i].crashed || tick.states[other].crashed) continue;
        const RelativeScore score = score_of(tick, i, relative);
        Vehicle& vehicle = vehicles_[i];
        vehicle.position.add(score.error_world_m.norm());
        vehicle.absolute_sum_m += score.error_world_m.norm();
        vehicle.yaw.add(score.yaw_error_rad);
        vehicle.nees_sum += score.nees;
        ++vehicle.count;
        vehicle.known_s += context.dt_s;
        scores_.push(static_cast<VehicleId>(i), score);
      }
    }
  }

  void report(MetricTable& table) const override {
    for (std::size_t i = 0; i < num_vehicles(); ++i) {
      const Vehicle& vehicle = vehicles_[i];
      if (vehicle.count == 0) continue;
      const auto count = static_cast<double>(vehicle.count);
      table.add(kRelativeMae, name_of(i), vehicle.absolute_sum_m / count);
      table.add(kRelativeRmse, name_of(i), vehicle.position.rms());
      table.add(kRelativeMax, name_of(i), vehicle.position.max());
      table.add(kRelativeYawRmse, name_of(i), vehicle.yaw.rms());
      table.add(kRelativeNees, name_of(i), vehicle.nees_sum / count);
      table.add(kRelativeKnown, name_of(i), vehicle.known_s);
    }
  }

 private:
  struct Vehicle {
    ErrorStatistics position, yaw;
    double absolute_sum_m = 0.0, nees_sum = 0.0, known_s = 0.0;
    std::uint64_t count = 0;
  };

  static RelativeScore score_of(const TickView& tick, std::size_t i, const RelativeEstimate& relative) {
    const VehicleState &self = tick.states[i], &other = tick.states[static_cast<std::size_t>(relative.other)];
    const Pose T_world_body = tick.actions[i]->estimate.T_world_body();
    const Vector3 true_body_m = self.q_world_body.conjugate() * (other.p_world_m - self.p_world_m);
    const Vector3 error_body_m = T_world_body.inverse() * relative.position_m - true_body_m;
    const auto yaw_between = [](const Matrix3& R_self, double yaw_other_rad) { return yaw_other_rad - yaw_of(R_self); };
    RelativeScore score;
    score.t = tick.t;
    score.other = relative.other;
    score.distance_m = true_body_m.norm();
    score.error_world_m = self.q_world_body * error_body_m;
    score.yaw_error_rad = std::remainder(
        yaw_between(T_world_body.linear(), relative.yaw_rad) -
            yaw_between(self.q_world_body.toRotationMatrix(), yaw_of(other.q_world_body.toRotationMatrix())),
        2.0 * std::numbers::pi);
    const Matrix3 C = relative.covariance.topLeftCorner<3, 3>();
    const Vector3 error_axes_m = T_world_body.linear() * error_body_m;  // in the axes of its covariance
    score.nees = error_axes_m.dot(C.ldlt().solve(error_axes_m));
    score.sigma_m = std::sqrt(C.trace());
    score.sigma_yaw_rad = std::sqrt(relative.covariance(6, 6));
    score.unseen_s = to_seconds(relative.t - relative.seen);
    return score;
  }

  SeriesOf<RelativeScore>& scores_;
  std::vector<Vehicle> vehicles_;
};

}  // namespace

MetricType relative_error_metric() {
  return {"relative_error", "relative localization against the true relative pose", make_metric<RelativeErrorMetric>,
          kRelativeErrorDefinitions};
}

}  // namespace swiftlet::sim
