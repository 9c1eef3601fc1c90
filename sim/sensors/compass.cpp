// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/sensors/compass.hpp"

#include "sim/sensors/noise.hpp"
#include "swiftlet/core/base/elementary.hpp"

namespace swiftlet::sim {

void CompassConfig::visit(ConfigVisitor& v) {
  visit_common(v);
  v.field("rate_hz", rate_hz, "[Hz] samples per second", Range::between(1e-3, 1e5));
  v.field("sigma_deg", sigma_deg, "[deg] standard deviation of the white noise", Range::non_negative());
  v.field("bias_sigma_deg", bias_sigma_deg, "[deg] standard deviation of the constant error", Range::non_negative());
  v.field("disturbance_sigma_deg", disturbance_sigma_deg, "[deg] standard deviation of slow disturbances",
          Range::non_negative());
}

namespace {

// [s] Correlation time of slow disturbances. Larger values keep a disturbance longer.
constexpr double kDisturbanceTime_s = 30.0;

class CompassSensor final : public Sensor {
 public:
  CompassSensor(const CompassConfig& config, SensorSetup setup)
      : Sensor(std::move(setup)),
        schedule_(config.rate_hz),
        white_(stream("compass.white")),
        disturbance_noise_(stream("compass.disturbance")),
        sigma_rad_(config.sigma_deg * kRadPerDeg),
        bias_rad_(config.bias_sigma_deg * kRadPerDeg * stream("compass.bias").normal(0, 0)),
        disturbance_(GaussMarkov::stationary(Vector3::UnitX() * config.disturbance_sigma_deg * kRadPerDeg,
                                             kDisturbanceTime_s, normal3(stream("compass.disturbance.start"), 0))),
        total_sigma_rad_(kRadPerDeg *
                         elementary::hypot(config.sigma_deg, config.bias_sigma_deg, config.disturbance_sigma_deg)) {}

  void measure(TimeNs now, const StateHistory& truth, Observation& out) override {
    TimeNs due = 0;
    std::uint32_t index = 0;
    while (schedule_.next(now, due, index)) {
      if (index > 0) disturbance_.advance(to_seconds(schedule_.period()), normal3(disturbance_noise_, index));
      const double true_yaw_rad = yaw_of(truth.at(setup_.vehicle, due).q_world_body.toRotationMatrix());
      const double error_rad = bias_rad_ + disturbance_.value().x() + sigma_rad_ * white_.normal(index, 0);
      out.compass.push_back({due, wrap_angle(true_yaw_rad + error_rad), total_sigma_rad_});
    }
  }

 private:
  Schedule schedule_;
  Random white_, disturbance_noise_;
  double sigma_rad_, bias_rad_;
  GaussMarkov disturbance_;
  double total_sigma_rad_;
};

}  // namespace

std::unique_ptr<Sensor> make_compass_sensor(const ModuleConfig& config, SensorSetup setup) {
  return std::make_unique<CompassSensor>(dynamic_cast<const CompassConfig&>(config), std::move(setup));
}

}  // namespace swiftlet::sim
