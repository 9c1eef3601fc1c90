// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <vector>

#include "swiftlet/core/base/frames.hpp"

namespace swiftlet::sim {

/// Association of an observer's tracks with vehicles over time.
class TrackIdentities {
 public:
  void prepare(std::size_t num_vehicles) {
    tracks_.reserve(256);
    id_of_target_.assign(num_vehicles, 0);
  }
  /// Begins a set of simultaneous tracks.
  void begin() {
    for (Known& track : tracks_) track.is_alive = false;
  }
  /// @param vehicle  vehicle assigned to the track; kNoVehicle: none
  void add(std::uint32_t id, VehicleId vehicle) {
    auto known = std::find_if(tracks_.begin(), tracks_.end(), [id](const Known& t) { return t.id == id; });
    if (known == tracks_.end()) known = tracks_.insert(known, {id, kNoVehicle, true});
    known->is_alive = true;
    if (vehicle == kNoVehicle) return;
    cross_associations_ += known->target != kNoVehicle && known->target != vehicle;
    known->target = vehicle;
    std::uint32_t& last = id_of_target_[vehicle];
    switches_ += last != 0 && last != id;
    last = id;
  }
  /// Ends the set: tracks that are not in it no longer exist.
  void end() {
    for (const Known& track : tracks_) num_ended_false_ += !track.is_alive && track.target == kNoVehicle;
    std::erase_if(tracks_, [](const Known& track) { return !track.is_alive; });
  }
  int switches() const { return switches_; }
  int cross_associations() const { return cross_associations_; }
  /// Number of tracks never assigned to a vehicle.
  int num_false() const {
    int count = num_ended_false_;
    for (const Known& track : tracks_) count += track.target == kNoVehicle;
    return count;
  }

 private:
  struct Known {
    std::uint32_t id = 0;
    VehicleId target = kNoVehicle;  // vehicle assigned last
    bool is_alive = false;
  };

  std::vector<Known> tracks_;
  std::vector<std::uint32_t> id_of_target_;  // last track of each vehicle, by VehicleId; 0: none
  int num_ended_false_ = 0, switches_ = 0, cross_associations_ = 0;
};

}  // namespace swiftlet::sim
