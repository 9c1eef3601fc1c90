// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>

namespace swiftlet {

/// FNV-1a hash: names of purposes and entities become stream numbers, so that adding a vehicle or a sensor changes no
/// other stream.
constexpr std::uint32_t stream_id(std::string_view name) {
  std::uint32_t hash = 2166136261U;
  for (const char c : name) hash = (hash ^ static_cast<std::uint8_t>(c)) * 16777619U;
  return hash;
}

/// Counter-based random numbers (Philox4x32-10, Salmon et al., SC 2011): every number is a pure function of
/// (seed, purpose, entity, tick, index). Holds no state; copies are equal; thread-safe.
class Random {
 public:
  Random() = default;
  /// @param purpose  use of the numbers, such as "lidar.range"
  /// @param entity   owner of the stream, such as "uav1/os1"
  Random(std::uint64_t seed, std::string_view purpose, std::string_view entity = {});

  /// 128 random bits.
  std::array<std::uint32_t, 4> bits(std::uint32_t tick, std::uint32_t index) const;
  /// Uniform in [0, 1), 53 bits.
  double uniform(std::uint32_t tick, std::uint32_t index) const;
  double uniform(double min, double max, std::uint32_t tick, std::uint32_t index) const {
    return min + (max - min) * uniform(tick, index);
  }
  /// Standard normal (Box-Muller; std::normal_distribution differs between libraries).
  double normal(std::uint32_t tick, std::uint32_t index) const;
  /// Three independent standard normals from one index (own counter domain: does not collide with normal()).
  std::array<double, 3> normal3(std::uint32_t tick, std::uint32_t index) const;

  /// out[i] as a pure function of (tick, first_index + i), independent of the span's split; single precision. About 2
  /// ns each.
  void fill_uniform(std::uint32_t tick, std::uint32_t first_index, std::span<float> out) const;
  void fill_normal(std::uint32_t tick, std::uint32_t first_index, std::span<float> out) const;

 private:
  std::uint64_t seed_ = 0;
  std::uint32_t purpose_ = 0;
  std::uint32_t entity_ = 0;
};

}  // namespace swiftlet
