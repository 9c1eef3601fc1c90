// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <tuple>
#include <type_traits>
#include <vector>

#include "swiftlet/core/message.hpp"
#include "swiftlet/core/sample_list.hpp"
#include "swiftlet/core/samples.hpp"
#include "swiftlet/core/scan.hpp"

namespace swiftlet {

/// Everything that one vehicle gets to know in one tick: what its sensors and its radio delivered since the last one.
/// Vectors are in order of their stamps and keep their capacity between ticks.
struct Observation {
  TimeNs t = 0;  ///< now
  VehicleId self = 0;
  std::vector<ImuSample> imu;
  std::vector<OdometrySample> odometry;
  std::vector<GnssSample> gnss;
  std::vector<AltimeterSample> altimeter;
  std::vector<CompassSample> compass;
  std::vector<PoseSample> pose;
  std::vector<NeighborSample> neighbors;
  SampleLists others;                              ///< of kinds that only their sensor and its users know
  std::vector<std::shared_ptr<const Scan>> scans;  ///< shared, because a slow module may hold on to a scan
  std::vector<Message> messages;
  bool wants_overlays = false;  ///< a picture is taken in this tick

  /// The lists that have a name above.
  static constexpr auto lists() {
    using O = Observation;
    return std::tuple(&O::imu, &O::odometry, &O::gnss, &O::altimeter, &O::compass, &O::pose, &O::neighbors);
  }
  /// Calls `each` with every one of them.
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

/// The list of one kind of sample, whether it has a name in Observation or not: sensors fill it, stages read it.
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
