// SPDX-License-Identifier: BSD-3-Clause
#include "core/shared_tracks/observer_bodies.hpp"

#include <algorithm>

namespace swiftlet {
namespace {

/// [-] Squared Mahalanobis distance (six degrees of freedom) above which a track is an observer no longer. Larger
/// values hide targets that pass near an observer.
constexpr double kNotBody_sq = 40.0;
/// [m] Radius around an observer in which a second track belongs to the same body. Larger values hide targets that pass
/// near an observer.
constexpr double kBody_m = 0.8;

}  // namespace

void ObserverBodies::forget_before(TimeNs oldest) {
  std::erase_if(bodies_, [&](const Body& body) { return body.last < oldest; });
}

std::vector<ObserverBodies::Body>::iterator ObserverBodies::body_of(const ObservedTrack& o) {
  return std::find_if(bodies_.begin(), bodies_.end(),
                      [&](const Body& body) { return body.observer == o.observer && body.identity == o.identity; });
}

void ObserverBodies::mark(VehicleId vehicle, const MotionEstimate& place, TimeNs t,
                          std::span<const ObservedTrack> tracks) {
  const ObservedTrack* nearest = nullptr;
  double least = 0.0;
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    const ObservedTrack& o = tracks[i];
    if (o.observer == vehicle) continue;  // observers do not track themselves
    const double squared = disagreement(o.estimate, place).squared_sigmas;
    if (auto body = body_of(o); body != bodies_.end() && body->vehicle == vehicle) {
      if (squared > kNotBody_sq)
        bodies_.erase(body);
      else
        body->last = t;
    }
    if (squared <= gate_sq_ && (nearest == nullptr || squared < least)) {
      nearest = &o;
      least = squared;
    }
    const bool is_last_of_observer = i + 1 == tracks.size() || tracks[i + 1].observer != o.observer;
    if (!is_last_of_observer || nearest == nullptr) continue;
    mark_body(*nearest, vehicle, t);
    // A second track at the same position belongs to the same body.
    for (const ObservedTrack& duplicate : tracks) {
      const bool is_near = (duplicate.estimate.p_m() - place.p_m()).norm() < kBody_m;
      if (duplicate.observer == o.observer && is_near) mark_body(duplicate, vehicle, t);
    }
    nearest = nullptr;
  }
}

void ObserverBodies::mark_body(const ObservedTrack& o, VehicleId vehicle, TimeNs t) {
  if (auto body = body_of(o); body != bodies_.end())
    *body = {o.observer, o.identity, vehicle, t};
  else
    bodies_.push_back({o.observer, o.identity, vehicle, t});
}

}  // namespace swiftlet
