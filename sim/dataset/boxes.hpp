// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <vector>

#include "swiftlet/sim/raycast/ray_scene.hpp"
#include "swiftlet/sim/world/labeled_scan.hpp"
#include "swiftlet/sim/world/vehicle_shape.hpp"

namespace swiftlet::sim {

/// Pose of another vehicle at the time when the beams of one sweep pass it.
struct VehicleBox {
  VehicleId vehicle = kNoVehicle;
  /// Mean time of its points; without points, the time when beams pass its position
  TimeNs t = 0;
  Pose T_lidar_box = Pose::Identity();  ///< center of the box, axes of the vehicle's body; lidar frame at t
  Pose T_world_box = Pose::Identity();
  Vector3 v_world_mps = Vector3::Zero();
  Vector3 size_m = Vector3::Zero();  ///< along the body axes, including propeller discs
  double range_m = 0.0;              ///< from the sensor to the center
  int num_points = 0;                ///< number of returns from the vehicle
  /// Share of the vehicle's silhouette (without propellers) inside the sensor's field of view and range and not
  /// occluded by the world or any vehicle, including the sensor's own.
  double visible_fraction = 0.0;
};

/// Computes the boxes of all vehicles except the sensor's carrier. One per sensor.
class BoxMaker {
 public:
  BoxMaker(std::shared_ptr<const StaticScene> world, const std::vector<std::shared_ptr<const VehicleShape>>& shapes,
           VehicleId carrier);
  ~BoxMaker();

  /// @param truth  history that reaches back to the start of the sweep
  std::vector<VehicleBox> boxes(const LabeledScan& scan, const StateHistory& truth);

 private:
  struct Body;
  struct FieldOfView;
  double visible_fraction(const VehicleBox& box, const Pose& T_world_lidar, double range_max_m,
                          const StateHistory& truth) const;
  bool is_hidden(const Vector3& from_world_m, const Vector3& to_world_m, VehicleId target, TimeNs t,
                 const StateHistory& truth) const;

  std::shared_ptr<const StaticScene> world_;
  std::vector<std::unique_ptr<Body>> bodies_;  // indexed by VehicleId; the carrier's without sensor housings
  VehicleId carrier_;
  std::unique_ptr<FieldOfView> view_;  // computed from the first scan
};

}  // namespace swiftlet::sim
