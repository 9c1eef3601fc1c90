// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <memory>
#include <string>
#include <type_traits>
#include <vector>

#include "sim/recorders/ros_encoder.hpp"
#include "sim/recorders/ros_points.hpp"
#include "sim/recorders/ros_types.hpp"
#include "sim/recorders/selection.hpp"
#include "swiftlet/sim/recorders/ros_config.hpp"
#include "swiftlet/sim/recording/recorder.hpp"

namespace swiftlet::sim {

/// Destination of the messages.
class RosSink {
 public:
  virtual ~RosSink() = default;
  /// Returns a number for a topic, used in write(). `latched`: late subscribers get the last message.
  virtual int add_channel(const std::string& topic, const RosType& type, bool latched) = 0;
  virtual void write(int channel, std::uint32_t sequence, TimeNs t, std::span<const std::byte> message) = 0;
};

/// Converts ticks into ROS messages. Frames: world, VEHICLE/body, VEHICLE/local (odometry), VEHICLE/SENSOR.
class RosTopics {
 public:
  RosTopics(const RosConfig& config, const RunInfo& info, RosDialect dialect, RosSink& sink);
  void write(const TickView& tick);

 private:
  struct Channel {
    int id;
    std::uint32_t sequence = 0;
  };
  struct StaticTransform {
    std::string parent, child;
    Pose T_parent_child;
  };

  bool wants(const char* topic) const;
  Channel& channel(const std::string& topic, const RosType& type, bool latched = false);
  /// As above, with a type that is created only for a new channel.
  template <class TypeOf>
  requires std::is_invocable_v<TypeOf> Channel& channel(const std::string& topic, const TypeOf& type_of,
                                                        bool latched = false);
  void send(Channel& channel, TimeNs t);
  void write_solids(TimeNs t);
  void write_clock(TimeNs t);
  void write_tf(const TickView& tick);
  void write_truth(const TickView& tick, VehicleId vehicle);
  void write_estimate(const TickView& tick, VehicleId vehicle);
  void write_samples(const TickView& tick, VehicleId vehicle);
  void write_messages(const TickView& tick, VehicleId vehicle);
  void write_events(const TickView& tick);
  void write_series(const TickView& tick);
  void write_markers(const TickView& tick, VehicleId vehicle);
  void write_scans(const TickView& tick, VehicleId vehicle);
  void announce_sensor(const std::string& parent, const std::string& child, const Pose& T_body_lidar, TimeNs t);

  RosConfig config_;
  RosSink& sink_;
  RosEncoder message_;
  RateGate gate_;
  std::vector<bool> selected_;         // indexed by VehicleId
  std::vector<std::string> names_;     // ROS names, indexed by VehicleId
  std::vector<TimeNs> last_estimate_;  // indexed by VehicleId
  std::map<std::string, Channel> channels_;
  std::vector<const Series*> series_;
  std::map<std::string, int> num_scans_;  // indexed by topic
  std::vector<StaticTransform> static_transforms_;
  const Scene* scene_;
  std::vector<std::shared_ptr<const VehicleShape>> vehicle_shapes_;
  bool solids_written_ = false;
};

}  // namespace swiftlet::sim
