// SPDX-License-Identifier: BSD-3-Clause
#include "sim/metrics/metric.hpp"
#include "sim/metrics/statistics.hpp"

namespace swiftlet::sim {
namespace {

/// Least value so far with its time and partner.
struct Minimum {
  double value = std::numeric_limits<double>::infinity();
  TimeNs t = 0;
  VehicleId partner = kNoVehicle;

  void add(double candidate, TimeNs now, VehicleId other = kNoVehicle) {
    if (candidate < value) *this = {candidate, now, other};
  }
  bool measured() const { return value < std::numeric_limits<double>::infinity(); }
};

/// Least distances of the surfaces of the circumscribed spheres (clearance) and of centres (separation). A vehicle that
/// starts on the ground counts for surfaces once it has been clear of them; after its crash it counts no more, but
/// others still keep their distance to it.
class ClearanceMetric final : public Metric {
 public:
  explicit ClearanceMetric(const MetricSetup& setup) : Metric(setup), vehicles_(num_vehicles()) {}

  void update(const TickView& tick, const MetricContext& context) override {
    for (std::size_t i = 0; i < num_vehicles(); ++i) add_clearance(i, tick, context.clearances[i]);
    for (std::size_t i = 0; i < num_vehicles(); ++i) {
      for (std::size_t j = i + 1; j < num_vehicles(); ++j) add_separation(i, j, tick);
    }
    for (std::size_t i = 0; i < num_vehicles(); ++i) vehicles_[i].crashed = tick.states[i].crashed;
  }

  void report(MetricTable& table) const override {
    table.add("min_separation_m", "", value_of(pair_), "m");
    table.add("min_separation_time_s", "", time_of(pair_), "s");
    table.add_text("min_separation_pair", "",
                   pair_.measured() ? name_of(pair_first_) + " " + name_of(pair_.partner) : "none");
    for (std::size_t i = 0; i < num_vehicles(); ++i) {
      const Vehicle& vehicle = vehicles_[i];
      table.add("min_clearance_surface_m", name_of(i), value_of(vehicle.surface), "m");
      table.add("min_clearance_surface_time_s", name_of(i), time_of(vehicle.surface), "s");
      table.add("min_clearance_vehicle_m", name_of(i), value_of(vehicle.other), "m");
      table.add("min_clearance_vehicle_time_s", name_of(i), time_of(vehicle.other), "s");
      table.add_text("min_clearance_vehicle_partner", name_of(i), partner_of(vehicle.other));
      table.add("min_separation_m", name_of(i), value_of(vehicle.separation), "m");
      table.add_text("min_separation_partner", name_of(i), partner_of(vehicle.separation));
    }
  }

 private:
  struct Vehicle {
    bool was_clear = false;
    bool crashed = false;  // before this tick
    Minimum surface, other, separation;
  };

  void add_clearance(std::size_t i, const TickView& tick, const Clearance& clearance) {
    Vehicle& vehicle = vehicles_[i];
    if (vehicle.crashed) return;
    vehicle.was_clear = vehicle.was_clear || clearance.surface_m > 0.0;
    if (vehicle.was_clear) vehicle.surface.add(std::min(clearance.surface_m, setup().config.clearance_max_m), tick.t);
    if (clearance.nearest_vehicle != kNoVehicle)
      vehicle.other.add(clearance.vehicle_m, tick.t, clearance.nearest_vehicle);
  }

  void add_separation(std::size_t i, std::size_t j, const TickView& tick) {
    if (vehicles_[i].crashed && vehicles_[j].crashed) return;
    const double distance_m = (tick.states[i].p_world_m - tick.states[j].p_world_m).norm();
    if (!vehicles_[i].crashed) vehicles_[i].separation.add(distance_m, tick.t, static_cast<VehicleId>(j));
    if (!vehicles_[j].crashed) vehicles_[j].separation.add(distance_m, tick.t, static_cast<VehicleId>(i));
    if (distance_m < pair_.value) {
      pair_.add(distance_m, tick.t, static_cast<VehicleId>(j));
      pair_first_ = i;
    }
  }

  static double value_of(const Minimum& minimum) { return minimum.measured() ? minimum.value : kNotMeasured; }
  static double time_of(const Minimum& minimum) { return minimum.measured() ? to_seconds(minimum.t) : kNotMeasured; }
  std::string partner_of(const Minimum& minimum) const {
    return minimum.partner == kNoVehicle ? "none" : name_of(minimum.partner);
  }

  std::vector<Vehicle> vehicles_;
  Minimum pair_;  // of all pairs
  std::size_t pair_first_ = 0;
};

}  // namespace

std::unique_ptr<Metric> make_clearance_metric(const MetricSetup& setup) {
  return std::make_unique<ClearanceMetric>(setup);
}

}  // namespace swiftlet::sim
