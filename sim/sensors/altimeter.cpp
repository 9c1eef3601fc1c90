// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/sensors/altimeter.hpp"

#include "sim/sensors/noise.hpp"
#include "swiftlet/core/base/elementary.hpp"

namespace swiftlet::sim {

void AltimeterConfig::visit(ConfigVisitor& v) {
  visit_common(v);
  v.field("rate_hz", rate_hz, "[Hz] samples per second", Range::between(1e-3, 1e5));
  v.field("position_m", position_m, "[m] mounting position, body frame");
  v.choice("beam", beam, {"vertical", "body"}, "[-] direction of the beam: the world's vertical, or the body's");
  v.field("range_min_m", range_min_m, "[m] smallest measured range", Range::non_negative());
  v.field("range_max_m", range_max_m, "[m] largest measured range", Range::positive());
  v.field("sigma_m", sigma_m, "[m] standard deviation of the range", Range::non_negative());
  v.field("sigma_relative", sigma_relative, "[-] standard deviation proportional to the range, added in quadrature",
          Range::non_negative());
  v.check(range_max_m > range_min_m, "range_max_m", "more than range_min_m");
}

namespace {

class AltimeterSensor final : public Sensor {
 public:
  AltimeterSensor(const AltimeterConfig& config, SensorSetup setup)
      : Sensor(std::move(setup)), config_(config), schedule_(config.rate_hz), noise_(stream("altimeter.range")) {}

  void measure(TimeNs now, const StateHistory& truth, Observation& out) override {
    if (!setup_.world) return;
    TimeNs due = 0;
    std::uint32_t index = 0;
    while (schedule_.next(now, due, index)) {
      const VehicleState state = truth.at(setup_.vehicle, due);
      const Vector3 lever_world = state.q_world_body * config_.position_m;
      const Vector3 beam_world =
          config_.beam == AltimeterConfig::Beam::kBody ? state.q_world_body * -Vector3::UnitZ() : -Vector3::UnitZ();
      const double true_range_m =
          setup_.world->trace(state.p_world_m + lever_world, beam_world, config_.range_max_m).range_m;
      if (true_range_m <= 0.0 || true_range_m < config_.range_min_m) continue;

      const double sigma_m = elementary::hypot(config_.sigma_m, config_.sigma_relative * true_range_m);
      const double range_m = true_range_m + sigma_m * noise_.normal(index, 0);
      if (range_m < config_.range_min_m || range_m > config_.range_max_m) continue;
      const double cos_tilt = -beam_world.z();
      out.altimeter.push_back({due, range_m * cos_tilt - lever_world.z(), sigma_m * std::abs(cos_tilt)});
    }
  }

 private:
  AltimeterConfig config_;
  Schedule schedule_;
  Random noise_;
};

}  // namespace

std::unique_ptr<Sensor> make_altimeter_sensor(const ModuleConfig& config, SensorSetup setup) {
  return std::make_unique<AltimeterSensor>(dynamic_cast<const AltimeterConfig&>(config), std::move(setup));
}

}  // namespace swiftlet::sim
