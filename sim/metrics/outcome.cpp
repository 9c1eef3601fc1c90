// SPDX-License-Identifier: BSD-3-Clause
#include <array>

#include "sim/metrics/statistics.hpp"
#include "swiftlet/sim/metrics/capture_record.hpp"
#include "swiftlet/sim/metrics/metric.hpp"

namespace swiftlet::sim {
namespace {

// Reported metrics:
constexpr MetricDefinition kOutcome = {"outcome", "", "outcome of a vehicle; for the run: the worst of its vehicles"};
constexpr MetricDefinition kTimeToDone = {"time_to_done_s", "s",
                                          "time from the start of the run to the agent's first report that its mission "
                                          "is done; none for a vehicle that crashed"};
constexpr MetricDefinition kCrashTime = {"crash_time_s", "s",
                                         "time of the first contact that counts as a crash, exact within the tick"};
constexpr MetricDefinition kCrashPartner = {"crash_partner", "",
                                            "other party of the crash: a vehicle, a class of surfaces, or none"};
constexpr MetricDefinition kOutcomeDefinitions[] = {kOutcome, kTimeToDone, kCrashTime, kCrashPartner};

// From best to worst: the outcome of a run is the worst of its vehicles.
enum class Outcome { kDone, kTimeout, kFailed, kCrashed };
constexpr std::array<OutcomeDefinition, 4> kOutcomes = {{
    {"done", "the agent reported its mission as done, or all required captures were made, by true positions"},
    {"timeout", "the run ended before the agent reported its mission as done or failed"},
    {"failed", "the agent reported failure; its last mission event in events.jsonl gives the reason"},
    {"crashed", "the vehicle crashed; overrides the status of its mission, even after it was done"},
}};

const char* name_of_outcome(Outcome outcome) { return kOutcomes[static_cast<std::size_t>(outcome)].name; }

/// A crash overrides the mission's status, even after the mission is done. The agent of a crashed vehicle continues,
/// but its mission does not.
class OutcomeMetric final : public Metric {
 public:
  explicit OutcomeMetric(const MetricSetup& setup) : Metric(setup), vehicles_(num_vehicles()) {}

  void update(const TickView& tick, const MetricContext& context) override {
    for (std::size_t i = 0; i < num_vehicles(); ++i) {
      Vehicle& vehicle = vehicles_[i];
      if (tick.states[i].crashed) {
        if (std::isnan(vehicle.crash_s)) vehicle.crash_s = to_seconds(tick.t);
        continue;
      }
      vehicle.mission = tick.actions[i]->mission;
      if (vehicle.mission == MissionStatus::kDone && std::isnan(vehicle.done_s)) vehicle.done_s = to_seconds(tick.t);
    }
    if (const auto* captures = series_of<CaptureRecord>(context.series)) {
      for (std::size_t k = 0; k < captures->size(); ++k) {
        const auto interceptor = static_cast<std::size_t>(captures->about(k));
        const CaptureRecord& capture = captures->rows()[k];
        if (wanted(interceptor) == 0 || capture.number < wanted(interceptor)) continue;
        vehicles_[interceptor].caught_enough = vehicles_[capture.target].caught = true;
      }
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
    for (std::size_t i = 0; i < num_vehicles(); ++i) worst = std::max(worst, outcome_of(i));
    table.add_text(kOutcome, "", name_of_outcome(worst));
    for (std::size_t i = 0; i < num_vehicles(); ++i) {
      const Vehicle& vehicle = vehicles_[i];
      table.add_text(kOutcome, name_of(i), name_of_outcome(outcome_of(i)));
      table.add(kTimeToDone, name_of(i), std::isnan(vehicle.crash_s) ? vehicle.done_s : kNotMeasured);
      table.add(kCrashTime, name_of(i), vehicle.crash_s);
      table.add_text(kCrashPartner, name_of(i), vehicle.partner.empty() ? "none" : vehicle.partner);
    }
  }

 private:
  struct Vehicle {
    MissionStatus mission = MissionStatus::kRunning;
    double done_s = kNotMeasured;
    double crash_s = kNotMeasured;
    bool caught_enough = false;  // targets captured by its net
    bool caught = false;         // captured by a vehicle that has caught enough
    std::string partner;
  };

  /// Number of captures that completes the mission of vehicle i; 0: no interceptor.
  int wanted(std::size_t i) const { return i < setup().perception.size() ? setup().perception[i].captures : 0; }

  bool every_target_caught() const {
    bool any = false;
    for (std::size_t i = 0; i < num_vehicles(); ++i) {
      if (wanted(i) > 0) continue;
      if (!vehicles_[i].caught) return false;
      any = true;
    }
    return any;
  }

  Outcome outcome_of(std::size_t i) const {
    const Vehicle& vehicle = vehicles_[i];
    if (!std::isnan(vehicle.crash_s)) return Outcome::kCrashed;
    if (wanted(i) > 0 && (vehicle.caught_enough || every_target_caught())) return Outcome::kDone;
    if (vehicle.mission == MissionStatus::kFailed) return Outcome::kFailed;
    return vehicle.mission == MissionStatus::kRunning ? Outcome::kTimeout : Outcome::kDone;
  }

  std::vector<Vehicle> vehicles_;
};

}  // namespace

std::span<const OutcomeDefinition> outcome_definitions() { return kOutcomes; }

MetricType outcome_metric() {
  return {"outcome", "outcome and end time of each vehicle's mission", make_metric<OutcomeMetric>, kOutcomeDefinitions};
}

}  // namespace swiftlet::sim
