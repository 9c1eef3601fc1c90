// SPDX-License-Identifier: BSD-3-Clause
#include <numbers>

#include "sim/metrics/statistics.hpp"
#include "swiftlet/sim/metrics/metric.hpp"

namespace swiftlet::sim {
namespace {

// Reported metrics:
constexpr MetricDefinition kPositionRmse = {
    "estimate_position_rmse_m", "m",
    "root mean square of |estimated - true position|, world frame, over all ticks with "
    "a valid estimate before a crash"};
constexpr MetricDefinition kPositionMax = {"estimate_position_max_m", "m",
                                           "largest |estimated - true position| over the same ticks"};
constexpr MetricDefinition kAteRmse = {
    "ate_position_rmse_m", "m",
    "absolute trajectory error: root mean square after the best alignment in position and "
    "yaw (Zhang and Scaramuzza 2018, sec. III)"};
constexpr MetricDefinition kYawRmse = {"estimate_yaw_rmse_rad", "rad",
                                       "root mean square of estimated minus true heading, wrapped to half a turn"};
constexpr MetricDefinition kYawMax = {"estimate_yaw_max_rad", "rad", "greatest error of the heading"};
constexpr MetricDefinition kVelocityRmse = {"estimate_velocity_rmse_mps", "m/s",
                                            "root mean square of |estimated - true velocity|, world frame"};
constexpr MetricDefinition kEstimateErrorDefinitions[] = {kPositionRmse, kPositionMax, kAteRmse,
                                                          kYawRmse,      kYawMax,      kVelocityRmse};

/// Absolute trajectory error after the optimal alignment in position and yaw, the four unobservable directions of
/// visual-inertial odometry (Zhang and Scaramuzza, IROS 2018, sec. III). Minimizes sum |p_i - R_z(psi) q_i - t|^2 in
/// closed form from running sums, without storing trajectories. p: truth, q: estimate, both relative to their first
/// positions.
class AlignedError {
 public:
  void add(const Vector3& p_true, const Vector3& p_estimated) {
    if (count_ == 0) {
      p_first_ = p_true;
      q_first_ = p_estimated;
    }
    const Vector3 p = p_true - p_first_;
    const Vector3 q = p_estimated - q_first_;
    ++count_;
    sum_p_ += p;
    sum_q_ += q;
    sum_pp_ += p.squaredNorm();
    sum_qq_ += q.squaredNorm();
    sum_pq_ += p * q.transpose();
  }

  double rmse() const {
    if (count_ == 0) return kNotMeasured;
    const double n = static_cast<double>(count_);
    // Centered second moments; the rotation maximizes trace(R^T C).
    const Matrix3 C = sum_pq_ / n - (sum_p_ / n) * (sum_q_ / n).transpose();
    const double pp = sum_pp_ / n - (sum_p_ / n).squaredNorm();
    const double qq = sum_qq_ / n - (sum_q_ / n).squaredNorm();
    const double best = std::hypot(C(0, 0) + C(1, 1), C(1, 0) - C(0, 1)) + C(2, 2);
    return std::sqrt(std::max(0.0, pp + qq - 2.0 * best));
  }

 private:
  std::uint64_t count_ = 0;
  Vector3 p_first_ = Vector3::Zero(), q_first_ = Vector3::Zero();
  Vector3 sum_p_ = Vector3::Zero(), sum_q_ = Vector3::Zero();
  double sum_pp_ = 0.0, sum_qq_ = 0.0;
  Matrix3 sum_pq_ = Matrix3::Zero();
};

/// Errors of estimates in every tick with a valid estimate before a crash. An estimate in a local frame has a large
/// absolute error; `ate_position_rmse_m` is the error after alignment.
class EstimateErrorMetric final : public Metric {
 public:
  explicit EstimateErrorMetric(const MetricSetup& setup) : Metric(setup), vehicles_(num_vehicles()) {}

  void update(const TickView& tick, const MetricContext&) override {
    for (std::size_t i = 0; i < num_vehicles(); ++i) {
      const StateEstimate& estimate = tick.actions[i]->estimate;
      const VehicleState& state = tick.states[i];
      if (!estimate.valid || state.crashed) continue;
      const Matrix3 R_world_body = state.q_world_body.toRotationMatrix();
      const double yaw_error = yaw_of(estimate.T_world_body().linear()) - yaw_of(R_world_body);
      vehicles_[i].position.add((estimate.T_world_body().translation() - state.p_world_m).norm());
      vehicles_[i].yaw.add(std::remainder(yaw_error, 2.0 * std::numbers::pi));
      vehicles_[i].velocity.add((estimate.v_world_mps() - state.v_world_mps).norm());
      vehicles_[i].aligned.add(state.p_world_m, estimate.T_world_body().translation());
    }
  }

  void report(MetricTable& table) const override {
    for (std::size_t i = 0; i < num_vehicles(); ++i) {
      const Vehicle& vehicle = vehicles_[i];
      table.add(kPositionRmse, name_of(i), vehicle.position.rms());
      table.add(kPositionMax, name_of(i), vehicle.position.max());
      table.add(kAteRmse, name_of(i), vehicle.aligned.rmse());
      table.add(kYawRmse, name_of(i), vehicle.yaw.rms());
      table.add(kYawMax, name_of(i), vehicle.yaw.max());
      table.add(kVelocityRmse, name_of(i), vehicle.velocity.rms());
    }
  }

 private:
  struct Vehicle {
    ErrorStatistics position, yaw, velocity;
    AlignedError aligned;
  };

  std::vector<Vehicle> vehicles_;
};

}  // namespace

MetricType estimate_error_metric() {
  return {"estimate_error", "estimated against true pose", make_metric<EstimateErrorMetric>, kEstimateErrorDefinitions};
}

}  // namespace swiftlet::sim
