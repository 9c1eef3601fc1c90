// SPDX-License-Identifier: BSD-3-Clause
// A custom sensor: a barometer with height drift. Its samples have the altimeter's type, so estimators can use it.
#include <cmath>
#include <cstdio>

#include "swiftlet/core/agent/stack.hpp"
#include "swiftlet/core/math/random.hpp"
#include "swiftlet/sim/registry/sensors.hpp"
#include "swiftlet/sim/registry/worlds.hpp"
#include "swiftlet/sim/run/simulation.hpp"

namespace {

using namespace swiftlet;

struct BarometerConfig : sim::SensorConfigOf<BarometerConfig> {
  double rate_hz = 20.0;
  double sigma_m = 0.1;
  double drift_m = 0.5;
  double drift_time_s = 60.0;

  void visit(ConfigVisitor& v) override {
    visit_common(v);
    v.field("rate_hz", rate_hz, "[Hz] samples per second", Range::between(0.1, 1000.0));
    v.field("sigma_m", sigma_m, "[m] standard deviation of the white noise", Range::non_negative());
    v.field("drift_m", drift_m, "[m] standard deviation of the drift", Range::non_negative());
    v.field("drift_time_s", drift_time_s, "[s] correlation time of the drift", Range::positive());
  }
};

/// Measures the truth at its own instants. Random numbers are functions of seed, purpose, sensor and index, so results
/// do not depend on other sensors of the team.
class Barometer : public sim::Sensor {
 public:
  Barometer(const BarometerConfig& config, sim::SensorSetup setup)
      : Sensor(std::move(setup)),
        config_(config),
        schedule_(config.rate_hz),
        noise_(stream("barometer.noise")),
        walk_(stream("barometer.drift")),
        memory_(elementary::exp(-1.0 / (config.rate_hz * config.drift_time_s))) {}

  void measure(TimeNs now, const sim::StateHistory& truth, Observation& out) override {
    TimeNs due = 0;
    std::uint32_t index = 0;
    while (schedule_.next(now, due, index)) {
      // Stationary first-order Gauss-Markov process.
      const double fresh = index == 0 ? 1.0 : std::sqrt(1.0 - memory_ * memory_);
      drift_m_ = memory_ * drift_m_ + fresh * config_.drift_m * walk_.normal(index, 0);
      const double height_m = truth.at(setup_.vehicle, due).p_world_m.z();
      out.altimeter.push_back({due, height_m + drift_m_ + config_.sigma_m * noise_.normal(index, 0), config_.sigma_m});
    }
  }

 private:
  BarometerConfig config_;
  sim::Schedule schedule_;
  Random noise_, walk_;
  double memory_;
  double drift_m_ = 0.0;
};

std::unique_ptr<sim::Sensor> make_barometer(const ModuleConfig& config, sim::SensorSetup setup) {
  return std::make_unique<Barometer>(dynamic_cast<const BarometerConfig&>(config), std::move(setup));
}

}  // namespace

int main() {
  sim::sensor_registry().add(
      {{"barometer", "height by air pressure, which drifts", make_module_config<BarometerConfig>}, make_barometer});

  sim::Scenario scenario;
  scenario.duration_s = 60.0;
  scenario.world = Module(sim::world_module_types(), "empty");
  scenario.vehicles[0].sensors.emplace_back(sim::sensor_module_types(), "barometer");

  sim::Simulation simulation(scenario);
  int count = 0;
  double sum_m2 = 0.0;
  while (!simulation.finished()) {
    simulation.tick();
    const double true_height_m = simulation.view().states[0].p_world_m.z();
    for (const AltimeterSample& sample : simulation.view().observations[0].altimeter) {
      sum_m2 += std::pow(sample.height_m - true_height_m, 2);
      ++count;
    }
  }
  const double rms_m = std::sqrt(sum_m2 / count);
  std::printf("barometer: %d samples, %.2f m RMS\n", count, rms_m);
  return count > 1000 && rms_m > 0.1 && rms_m < 1.5 ? 0 : 1;
}
