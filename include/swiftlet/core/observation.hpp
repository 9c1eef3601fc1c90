// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <optional>
#include <type_traits>
#include <vector>

#include "swiftlet/core/message.hpp"
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
  std::vector<std::shared_ptr<const Scan>> scans;  ///< shared, because a slow module may hold on to a scan
  std::vector<Message> messages;
  bool wants_overlays = false;  ///< a picture is taken in this tick

  /// Calls `each` with every list of samples. A new kind of sample has its list above and its name here, no more.
  static void each_samples(auto& o, auto&& each) {
    const auto all = [&](auto&... lists) { (each(lists), ...); };
    all(o.imu, o.odometry, o.gnss, o.altimeter, o.compass, o.pose, o.neighbors);
  }

  void clear() {
    each_samples(*this, [](auto& samples) { samples.clear(); });
    scans.clear();
    messages.clear();
    wants_overlays = false;
  }
};

/// The list of one kind of sample.
template <class Sample>
const std::vector<Sample>& samples_of(const Observation& observation) {
  const std::vector<Sample>* found = nullptr;
  Observation::each_samples(observation, [&found](const auto& samples) {
    if constexpr (std::is_same_v<decltype(samples), const std::vector<Sample>&>) found = &samples;
  });
  return *found;
}

}  // namespace swiftlet
