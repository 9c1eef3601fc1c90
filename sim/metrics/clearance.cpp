// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <compare>
#include <limits>

#include "sim/metrics/statistics.hpp"
#include "swiftlet/sim/metrics/metric.hpp"

namespace swiftlet::sim {
namespace {

// Reported metrics:
constexpr MetricDefinition kSeparation = {"min_separation_m", "m",
                                          "least distance between the centers of two vehicles in any tick; for a "
                                          "vehicle: to any other one, until it crashes"};
constexpr MetricDefinition kSeparationTime = {"min_separation_time_s", "s",
                                              "time at which the least separation of the run is first reached"};
constexpr MetricDefinition kSeparationPair = {"min_separation_pair", "",
                                              "the two vehicles of the least separation of the run, or none"};
constexpr MetricDefinition kSurface = {"min_clearance_surface_m", "m",
                                       "least distance from the circumscribed sphere of the vehicle to a surface of "
                                       "the world, from its first positive value on; at most 20 m"};
constexpr MetricDefinition kSurfaceTime = {"min_clearance_surface_time_s", "s",
                                           "time at which that distance is first reached"};
constexpr MetricDefinition kOther = {
    "min_clearance_vehicle_m", "m",
    "least distance between the circumscribed spheres of the vehicle and another one; negative: they overlap"};
constexpr MetricDefinition kOtherTime = {"min_clearance_vehicle_time_s", "s",
                                         "time at which that distance is first reached"};
constexpr MetricDefinition kOtherPartner = {"min_clearance_vehicle_partner", "",
                                            "the other vehicle at that time, or none"};
constexpr MetricDefinition kSeparationPartner = {"min_separation_partner", "",
                                                 "the other vehicle of the least separation, or none"};
constexpr MetricDefinition kClearanceDefinitions[] = {kSeparation, kSeparationTime, kSeparationPair,
                                                      kSurface,    kSurfaceTime,    kOther,
                                                      kOtherTime,  kOtherPartner,   kSeparationPartner};

/// Minimum so far with its time and partner.
struct Minimum {
  double value = std::numeric_limits<double>::infinity();
  TimeNs t = 0;
  VehicleId partner = kNoVehicle;

  void add(double candidate, TimeNs now, VehicleId other = kNoVehicle) {
    if (candidate < value) *this = {candidate, now, other};
  }
  bool measured() const { return value < std::numeric_limits<double>::infinity(); }
};

/// Minima of the distances to circumscribed spheres (clearance) and between centers (separation). The clearance of a
/// vehicle that starts on the ground counts once it has taken off. After a crash it no longer counts, but other
/// vehicles still keep their distance to the wreck.
class ClearanceMetric final : public Metric {
 public:
  explicit ClearanceMetric(const MetricSetup& setup)
      : Metric(setup), vehicles_(num_vehicles()), neighborhood_(std::vector<double>(num_vehicles(), 0.0)) {}

  void update(const TickView& tick, const MetricContext& context) override {
    for (std::size_t i = 0; i < num_vehicles(); ++i) add_clearance(i, tick, context.clearances[i]);
    neighborhood_.update(tick.states);
    add_separations(tick);
    for (std::size_t i = 0; i < num_vehicles(); ++i) vehicles_[i].crashed = tick.states[i].crashed;
  }

  void report(MetricTable& table) const override {
    table.add(kSeparation, "", pair_.measured() ? pair_.distance_m : kNotMeasured);
    table.add(kSeparationTime, "", pair_.measured() ? to_seconds(t_pair_) : kNotMeasured);
    table.add_text(kSeparationPair, "", pair_.measured() ? name_of(pair_.a) + " " + name_of(pair_.b) : "none");
    for (std::size_t i = 0; i < num_vehicles(); ++i) {
      const Vehicle& vehicle = vehicles_[i];
      table.add(kSurface, name_of(i), value_of(vehicle.surface));
      table.add(kSurfaceTime, name_of(i), time_of(vehicle.surface));
      table.add(kOther, name_of(i), value_of(vehicle.other));
      table.add(kOtherTime, name_of(i), time_of(vehicle.other));
      table.add_text(kOtherPartner, name_of(i), partner_of(vehicle.other));
      table.add(kSeparation, name_of(i), value_of(vehicle.separation));
      table.add_text(kSeparationPartner, name_of(i), partner_of(vehicle.separation));
    }
  }

 private:
  struct Vehicle {
    bool was_clear = false;
    bool crashed = false;  // before this tick
    Minimum surface, other, separation;
  };

  /// Sorted by distance, then by number.
  struct Pair {
    double distance_m = std::numeric_limits<double>::infinity();
    VehicleId a = kNoVehicle, b = kNoVehicle;

    Pair ascending() const { return {distance_m, std::min(a, b), std::max(a, b)}; }
    bool measured() const { return b != kNoVehicle; }
    auto operator<=>(const Pair&) const = default;
  };

  void add_clearance(std::size_t i, const TickView& tick, const Clearance& clearance) {
    Vehicle& vehicle = vehicles_[i];
    if (vehicle.crashed) return;
    vehicle.was_clear = vehicle.was_clear || clearance.surface_m > 0.0;
    if (vehicle.was_clear) vehicle.surface.add(std::min(clearance.surface_m, MetricsConfig::kClearanceMax_m), tick.t);
    if (clearance.nearest_vehicle != kNoVehicle)
      vehicle.other.add(clearance.vehicle_m, tick.t, clearance.nearest_vehicle);
  }

  /// The least distance of a team is that of some vehicle to its nearest neighbor.
  void add_separations(const TickView& tick) {
    Pair least;
    for (VehicleId i = 0; i < static_cast<VehicleId>(num_vehicles()); ++i) {
      if (vehicles_[i].crashed) continue;
      const Pair nearest = nearest_to(i, tick);
      vehicles_[i].separation.add(nearest.distance_m, tick.t, nearest.b);
      if (nearest.b != kNoVehicle) least = std::min(least, nearest.ascending());
    }
    if (least.distance_m < pair_.distance_m) {
      pair_ = least;
      t_pair_ = tick.t;
    }
  }

  Pair nearest_to(VehicleId i, const TickView& tick) const {
    Pair nearest;
    for (const VehicleId j : neighborhood_.candidates(i)) {
      const double distance_m = (tick.states[i].p_world_m - tick.states[j].p_world_m).norm();
      if (distance_m < nearest.distance_m) nearest = {distance_m, i, j};
    }
    return nearest;
  }

  static double value_of(const Minimum& minimum) { return minimum.measured() ? minimum.value : kNotMeasured; }
  static double time_of(const Minimum& minimum) { return minimum.measured() ? to_seconds(minimum.t) : kNotMeasured; }
  std::string partner_of(const Minimum& minimum) const {
    return minimum.partner == kNoVehicle ? "none" : name_of(minimum.partner);
  }

  std::vector<Vehicle> vehicles_;
  Neighborhood neighborhood_;
  Pair pair_;  // least distance so far
  TimeNs t_pair_ = 0;
};

}  // namespace

MetricType clearance_metric() {
  return {"clearance", "least distances to surfaces and to other vehicles", make_metric<ClearanceMetric>,
          kClearanceDefinitions};
}

}  // namespace swiftlet::sim
