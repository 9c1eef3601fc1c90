// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <vector>

#include "swiftlet/sim/world/labeled_scan.hpp"
#include "swiftlet/sim/world/scene.hpp"

namespace swiftlet::sim {

/// Latest scans of one observer, for detectors with delay.
class SeenScans {
 public:
  /// Times of one scan, and its number of returns on each vehicle.
  struct Scan {
    TimeNs stamp = 0, middle = 0;
    std::vector<int> points;  // indexed by VehicleId
  };

  void prepare(std::size_t num_vehicles) {
    scans_.resize(kScans);
    for (Scan& scan : scans_) scan.points.resize(num_vehicles);
  }
  void push(const LabeledScan& labeled) {
    Scan& seen = scans_[count_++ % kScans];
    seen.stamp = labeled.scan.stamp;
    seen.middle = labeled.scan.stamp + labeled.scan.duration / 2;
    std::fill(seen.points.begin(), seen.points.end(), 0);
    const ScanTruth& truth = labeled.truth;
    constexpr auto kVehicleClass = static_cast<std::uint16_t>(SurfaceClass::kVehicle);
    for (std::size_t k = 0; k < truth.instance.size(); ++k) {
      if (truth.surface_class[k] != kVehicleClass || !(labeled.scan.range_m[k] > 0.0F)) continue;
      const std::size_t vehicle = truth.instance[k] - 1U;
      if (vehicle < seen.points.size()) ++seen.points[vehicle];
    }
  }
  /// Null before the first scan.
  const Scan* newest() const { return count_ == 0 ? nullptr : &scans_[(count_ - 1) % kScans]; }
  /// The scan with that stamp; null when not stored.
  const Scan* find(TimeNs stamp) const {
    const std::size_t known = std::min<std::size_t>(count_, kScans);
    for (std::size_t k = 1; k <= known; ++k) {
      const Scan& scan = scans_[(count_ - k) % kScans];
      if (scan.stamp == stamp) return &scan;
    }
    return nullptr;
  }

 private:
  /// [-] Stored scans. Must cover the latency of a detector.
  static constexpr std::size_t kScans = 64;

  std::vector<Scan> scans_;  // ring buffer
  std::size_t count_ = 0;
};

}  // namespace swiftlet::sim
