// SPDX-License-Identifier: BSD-3-Clause
#include "sim/run/state_hash.hpp"

#define XXH_INLINE_ALL
#include <xxhash.h>

#include <cstring>
#include <span>
#include <type_traits>

namespace swiftlet::sim {
namespace {

// Feeds values, never whole structs: padding bytes have no defined content. What fits into the buffer (anything but
// scans) is hashed at once, which gives the same value as bit by bit and costs half as much.
class Hasher {
 public:
  void add(double value) { bytes(&value, sizeof value); }
  void add(TimeNs value) { bytes(&value, sizeof value); }
  void add(std::int32_t value) { bytes(&value, sizeof value); }
  void add(const Vector3& v) { bytes(v.data(), 3 * sizeof(double)); }
  void add(const Matrix3& m) { bytes(m.data(), 9 * sizeof(double)); }
  void add(const Pose& pose) {
    add(Matrix3(pose.linear()));
    add(Vector3(pose.translation()));
  }
  void add(const std::vector<float>& values) { bytes(values.data(), values.size() * sizeof(float)); }
  void bytes(const void* data, std::size_t size) {
    if (size > kCapacity - size_) {
      flush();
      if (size > kCapacity) {
        XXH3_64bits_update(&state_, data, size);
        return;
      }
    }
    if (size > 0) std::memcpy(buffer_ + size_, data, size);
    size_ += size;
  }
  std::uint64_t digest() {
    if (!streaming_) return XXH3_64bits(buffer_, size_);
    flush();
    return XXH3_64bits_digest(&state_);
  }

 private:
  static constexpr std::size_t kCapacity = 2048;

  void flush() {
    if (!streaming_) XXH3_64bits_reset(&state_);
    streaming_ = true;
    XXH3_64bits_update(&state_, buffer_, size_);
    size_ = 0;
  }

  std::size_t size_ = 0;
  bool streaming_ = false;
  unsigned char buffer_[kCapacity];
  XXH3_state_t state_;
};

void add(Hasher& h, const ImuSample& s) {
  h.add(s.t);
  h.add(s.omega_body_radps);
  h.add(s.specific_force_body_mps2);
}

void add(Hasher& h, const OdometrySample& s) {
  h.add(s.t);
  h.add(s.T_local_body);
  h.add(s.v_local_body_mps);
}

void add(Hasher& h, const GnssSample& s) {
  h.add(s.t);
  h.add(s.p_world_m);
  h.add(s.v_world_mps);
  h.add(s.sigma_p_m);
  h.add(s.sigma_v_mps);
}

void add(Hasher& h, const AltimeterSample& s) {
  h.add(s.t);
  h.add(s.height_m);
}

void add(Hasher& h, const CompassSample& s) {
  h.add(s.t);
  h.add(s.yaw_rad);
}

void add(Hasher& h, const PoseSample& s) {
  h.add(s.t);
  h.add(s.T_world_body);
  h.add(s.v_world_mps);
  h.add(s.omega_body_radps);
}

void add(Hasher& h, const NeighborSample& s) {
  h.add(s.t);
  h.add(s.id);
  h.add(s.p_body_m);
  h.add(s.covariance_body);
}

void add(Hasher& h, const std::shared_ptr<const Scan>& scan) {
  h.add(scan->stamp);
  h.add(scan->duration);
  h.add(scan->range_m);
  h.add(scan->intensity);
  h.add(scan->reflectivity);
  for (const StampedPose& told : scan->external_poses) {
    h.add(told.t);
    h.add(told.T_world_body);
  }
}

void add(Hasher& h, const Message& m) {
  h.add(m.from);
  h.add(m.sent);
  h.add(m.received);
  h.bytes(m.topic.data(), m.topic.size());
  h.bytes(m.payload.data(), m.payload.size());
}

}  // namespace

std::uint64_t hash_of(const Observation& observation) {
  Hasher h;
  const auto add_all = [&h](const auto& samples) {
    for (const auto& sample : samples) add(h, sample);
  };
  add_all(observation.imu);
  add_all(observation.odometry);
  add_all(observation.gnss);
  add_all(observation.altimeter);
  add_all(observation.compass);
  add_all(observation.pose);
  add_all(observation.neighbors);
  add_all(observation.scans);
  add_all(observation.messages);
  return h.digest();
}

std::uint64_t hash_of(const VehicleState& state) {
  Hasher h;
  h.add(state.t);
  h.add(state.p_world_m);
  h.bytes(state.q_world_body.coeffs().data(), 4 * sizeof(double));
  h.add(state.v_world_mps);
  h.add(state.omega_body_radps);
  h.bytes(state.rotor_speed_radps.data(), sizeof state.rotor_speed_radps);
  h.bytes(state.rotor_angle_rad.data(), sizeof state.rotor_angle_rad);
  h.add(static_cast<std::int32_t>(state.crashed));
  return h.digest();
}

std::uint64_t combine(std::uint64_t hash, std::uint64_t value) {
  const std::uint64_t both[2] = {hash, value};
  return XXH3_64bits(both, sizeof both);
}

}  // namespace swiftlet::sim
