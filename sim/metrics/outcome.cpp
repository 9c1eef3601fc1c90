// SPDX-License-Identifier: BSD-3-Clause
#include <array>

#include "sim/metrics/statistics.hpp"
#include "swiftlet/sim/metrics/metric.hpp"

namespace swiftlet::sim {
namespace {

// From best to worst: a run is as good as its worst vehicle.
enum class Outcome { kDone, kTimeout, kFailed, kCrashed };
constexpr std::array<const char*, 4> kOutcomeNames = {"done", "timeout", "failed", "crashed"};

const char* word_for(Outcome outcome) { return kOutcomeNames[static_cast<std::size_t>(outcome)]; }

/// A crash outweighs whatever the mission says of itself, also when it comes after the mission was done.
class OutcomeMetric final : public Metric {
 public:
  explicit OutcomeMetric(const MetricSetup& setup) : Metric(setup), vehicles_(num_vehicles()) {}

  void update(const TickView& tick, const MetricContext&) override {
    for (std::size_t i = 0; i < num_vehicles(); ++i) {
      Vehicle& vehicle = vehicles_[i];
      vehicle.mission = tick.actions[i]->mission;
      if (vehicle.mission == MissionStatus::kDone && std::isnan(vehicle.done_s)) vehicle.done_s = to_seconds(tick.t);
      if (tick.states[i].crashed && std::isnan(vehicle.crash_s)) vehicle.crash_s = to_seconds(tick.t);
    }
    for (const Event& event : tick.events) {
      if (event.kind != "crash" || event.vehicle == kNoVehicle) continue;
      Vehicle& vehicle = vehicles_[event.vehicle];
      if (!vehicle.partner.empty()) continue;
      vehicle.crash_s = to_seconds(event.t);  // exact, within the tick
      vehicle.partner = event.partner;
    }
  }

  void report(MetricTable& table) const override {
    Outcome worst = Outcome::kDone;
    for (const Vehicle& vehicle : vehicles_) worst = std::max(worst, outcome_of(vehicle));
    table.add_text("outcome", "", word_for(worst));
    for (std::size_t i = 0; i < num_vehicles(); ++i) {
      const Vehicle& vehicle = vehicles_[i];
      table.add_text("outcome", name_of(i), word_for(outcome_of(vehicle)));
      table.add("time_to_done_s", name_of(i), vehicle.done_s, "s");
      table.add("crash_time_s", name_of(i), vehicle.crash_s, "s");
      table.add_text("crash_partner", name_of(i), vehicle.partner.empty() ? "none" : vehicle.partner);
    }
  }

 private:
  struct Vehicle {
    MissionStatus mission = MissionStatus::kRunning;
    double done_s = kNotMeasured;
    double crash_s = kNotMeasured;
    std::string partner;
  };

  static Outcome outcome_of(const Vehicle& vehicle) {
    if (!std::isnan(vehicle.crash_s)) return Outcome::kCrashed;
    if (vehicle.mission == MissionStatus::kFailed) return Outcome::kFailed;
    return vehicle.mission == MissionStatus::kRunning ? Outcome::kTimeout : Outcome::kDone;
  }

  std::vector<Vehicle> vehicles_;
};

}  // namespace

std::unique_ptr<Metric> make_outcome_metric(const MetricSetup& setup) { return std::make_unique<OutcomeMetric>(setup); }

}  // namespace swiftlet::sim
