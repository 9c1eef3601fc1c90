// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bitset>
#include <cstddef>
#include <vector>

#include "swiftlet/core/mappers/mapper.hpp"

namespace swiftlet {

/// Vehicles whose returns are no obstacles: tracks, localized team members, and neighbors that guidance keeps its
/// distance from. The last sample of each neighbor is valid for half a second.
class VehiclesAround {
 public:
  /// @param radius_m  returns within this distance of a vehicle are its own; 0: all returns are obstacles
  explicit VehiclesAround(double radius_m) : radius_m_(radius_m) {}

  /// Call in every tick before contains().
  void update(const MapperInput& input);

  /// True if a point measured at that time belongs to a vehicle.
  bool contains(const Eigen::Vector3f& p_local_m, TimeNs t) const {
    return !vehicles_.empty() && marked_[cell_of(p_local_m.x(), p_local_m.y())] && is_one(p_local_m.cast<double>(), t);
  }

 private:
  struct Sample {
    VehicleId id = kNoVehicle;
    TimeNs t = 0;
    Vector3 p_local_m = Vector3::Zero();
    Matrix3 covariance_local_m2 = Matrix3::Zero();
  };
  struct Vehicle {
    TimeNs t = 0;
    Vector3 p_local_m = Vector3::Zero();
    Vector3 v_local_mps = Vector3::Zero();
    Matrix3 inverse_m2 = Matrix3::Zero();  ///< matrix of the ellipsoid that holds its points: q' inverse q < 1
  };
  // cells of a periodic grid, which quickly rejects points far from all vehicles
  static constexpr std::size_t kSide = 64;

  static std::size_t cell_of(double x_m, double y_m);
  void receive(const MapperInput& input);
  void add(const Vehicle& vehicle, TimeNs now, double reach_m);
  bool is_one(const Vector3& p_local_m, TimeNs t) const;

  double radius_m_;
  std::vector<Sample> samples_;  // the last one of each neighbor, in order of identity
  std::vector<Vehicle> vehicles_;
  std::bitset<kSide * kSide> marked_;
};

}  // namespace swiftlet
