// SPDX-License-Identifier: BSD-3-Clause
#include "sim/run/finite_values.hpp"

#include "swiftlet/core/base/ensure.hpp"
#include "swiftlet/core/base/finite.hpp"

namespace swiftlet::sim {

void ensure_finite(const Observation& observation) {
  Observation::each_samples(observation, []<class Sample>(const std::vector<Sample>& samples) {
    const char* const sensor = Sample::kName;
    for (const Sample& sample : samples) ENSURE(is_finite(sample), sensor, to_seconds(sample.t));
  });
  for (const auto& samples : observation.others) {
    const char* const sensor = samples->name();
    for (std::size_t i = 0; i < samples->size(); ++i)
      ENSURE(samples->finite(i), sensor, to_seconds(samples->time_of(i)));
  }
  for (const auto& scan : observation.scans) ENSURE(is_finite(*scan), scan->sensor, to_seconds(scan->stamp));
}

void ensure_finite(const Action& action) {
  for (const double command : action.rotor_command) ENSURE(is_finite(command), command);
  const StateEstimate& estimate = action.estimate;
  ENSURE(!estimate.valid || is_finite(estimate), estimate.T_local_body.translation(), estimate.v_local_mps,
         estimate.omega_body_radps);
  const Reference& reference = action.reference;
  ENSURE(is_finite(reference), reference.position_m, reference.velocity_mps, reference.acceleration_mps2,
         reference.yaw_rad, reference.yaw_rate_radps);
  for (const Detection& detection : action.detections) {
    ENSURE(is_finite(detection), detection.position_m, detection.extent_m, detection.confidence);
  }
  for (const Track& track : action.tracks) ENSURE(is_finite(track), track.id, track.position_m, track.velocity_mps);
  for (const RelativeEstimate& r : action.relatives) ENSURE(is_finite(r), r.other, r.position_m, r.velocity_mps);
}

}  // namespace swiftlet::sim
