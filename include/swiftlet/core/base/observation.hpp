// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <tuple>
#include <type_traits>
#include <vector>

#include "swiftlet/core/base/message.hpp"
#include "swiftlet/core/base/sample_list.hpp"
#include "swiftlet/core/base/samples.hpp"
#include "swiftlet/core/base/scan.hpp"

namespace swiftlet {

/// Inputs of one vehicle in one tick: data of its sensors and its radio since the last tick. Vectors are in order of
/// their stamps and keep their capacity between ticks.
struct Observation {
  TimeNs t = 0;  ///< current time
  VehicleId self = 0;
  std::vector<ImuSample> imu;
  std::vector<OdometrySample> odometry;
  std::vector<GnssSample> gnss;
  std::vector<AltimeterSample> altimeter;
  std::vector<CompassSample> compass;
  std::vector<PoseSample> pose;
  std::vector<NeighborSample> neighbors;
  SampleLists others;                              ///< sample types of plug-in sensors
  std::vector<std::shared_ptr<const Scan>> scans;  ///< shared, because a slow module may keep a scan
  std::vector<Message> messages;
  bool wants_overlays = false;  ///< a snapshot is taken in this tick

  /// The lists of samples that are members of Observation.
  static constexpr auto lists() {
    using O = Observation;
    return std::tuple(&O::imu, &O::odometry, &O::gnss, &O::altimeter, &O::compass, &O::pose, &O::neighbors);
  }
  /// Calls `each` with every one of the lists.
  static void each_samples(auto& o, auto&& each) {
    std::apply([&](auto... list) { (each(o.*list), ...); }, lists());
  }

  void clear() {
    each_samples(*this, [](auto& samples) { samples.clear(); });
    others.clear();
    scans.clear();
    messages.clear();
    wants_overlays = false;
  }
};

/// List of one sample type, whether it is a member of Observation or not: sensors fill it, stages read it.
template <class Sample>
auto& samples_of(auto& observation) {
  using List = std::vector<Sample> Observation::*;
  constexpr auto is_named = [](auto... list) { return (std::is_same_v<decltype(list), List> || ...); };
  if constexpr (std::apply(is_named, Observation::lists())) {
    return observation.*std::get<List>(Observation::lists());
  } else {
    return observation.others.template of<Sample>();
  }
}

}  // namespace swiftlet
