// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/math/random.hpp"

#include <Random123/philox.h>

#include <Eigen/Core>
#include <cmath>
#include <numbers>

#include "swiftlet/core/math/elementary_lanes.hpp"

namespace swiftlet {
namespace {

using Philox = r123::Philox4x32;

// The last counter word separates the kinds of draws, so that normal() and normal3() of one index are independent.
enum class Domain : std::uint32_t { kBits = 0, kNormal3 = 1, kFillUniform = 2, kFillNormal = 3 };

Philox::ctr_type draw(std::uint64_t seed, std::uint32_t purpose, std::uint32_t entity, Domain domain,
                      std::uint32_t tick, std::uint32_t index) {
  const Philox::ctr_type counter = {
      {index, tick, entity, purpose ^ (static_cast<std::uint32_t>(domain) * 0x9E3779B9U)}};
  const Philox::key_type key = {{static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32)}};
  return Philox{}(counter, key);
}

// Uniform in (0, 1]: safe for a logarithm.
double open_unit(std::uint32_t high, std::uint32_t low) {
  const std::uint64_t bits = (static_cast<std::uint64_t>(high) << 21) ^ (low >> 11);
  return (static_cast<double>(bits) + 1.0) * 0x1.0p-53;
}

float unit_float(std::uint32_t bits) { return static_cast<float>(bits >> 8) * 0x1.0p-24F; }

}  // namespace

Random::Random(std::uint64_t seed, std::string_view purpose, std::string_view entity)
    : seed_(seed), purpose_(stream_id(purpose)), entity_(stream_id(entity)) {}

std::array<std::uint32_t, 4> Random::bits(std::uint32_t tick, std::uint32_t index) const {
  const auto r = draw(seed_, purpose_, entity_, Domain::kBits, tick, index);
  return {r[0], r[1], r[2], r[3]};
}

double Random::uniform(std::uint32_t tick, std::uint32_t index) const {
  const auto r = bits(tick, index);
  const std::uint64_t word = (static_cast<std::uint64_t>(r[0]) << 21) ^ (r[1] >> 11);
  return static_cast<double>(word) * 0x1.0p-53;
}

double Random::normal(std::uint32_t tick, std::uint32_t index) const {
  const auto r = bits(tick, index);
  const double radius = std::sqrt(-2.0 * log_of_unit(Lanes2d::Constant(open_unit(r[0], r[1])))[0]);
  return radius * sincos_of_turns(Lanes2d::Constant(open_unit(r[2], r[3]))).cos[0];
}

std::array<double, 3> Random::normal3(std::uint32_t tick, std::uint32_t index) const {
  // Two Box-Muller pairs of 32-bit uniforms give four normals; three are used.
  const auto r = draw(seed_, purpose_, entity_, Domain::kNormal3, tick, index);
  const auto unit = [](std::uint32_t word) { return (static_cast<double>(word) + 1.0) * 0x1.0p-32; };
  const Lanes2d radius = (-2.0 * log_of_unit({unit(r[0]), unit(r[2])})).sqrt();
  const SinCos2d angle = sincos_of_turns({unit(r[1]), unit(r[3])});
  return {radius[0] * angle.cos[0], radius[0] * angle.sin[0], radius[1] * angle.cos[1]};
}

void Random::fill_uniform(std::uint32_t tick, std::uint32_t first_index, std::span<float> out) const {
  // Number i is word i % 4 of block i / 4.
  for (std::size_t k = 0; k < out.size();) {
    const std::uint32_t index = first_index + static_cast<std::uint32_t>(k);
    const auto r = draw(seed_, purpose_, entity_, Domain::kFillUniform, tick, index / 4);
    for (std::uint32_t word = index % 4; word < 4 && k < out.size(); ++word, ++k) out[k] = unit_float(r[word]);
  }
}

void Random::fill_normal(std::uint32_t tick, std::uint32_t first_index, std::span<float> out) const {
  // Number i is word i % 4 of block i / 4: two Box-Muller pairs per block. Four blocks at a time, so that logarithm,
  // sine and cosine run in SIMD lanes. Eigen's give equal results in every lane and on every machine; its square root
  // does not.
  constexpr std::uint32_t kBlocks = 4;
  using Lanes = Eigen::Array<float, 2 * kBlocks, 1>;
  for (std::size_t k = 0; k < out.size();) {
    const std::uint32_t index = first_index + static_cast<std::uint32_t>(k);
    Lanes u, v;
    for (std::uint32_t b = 0; b < kBlocks; ++b) {
      const auto r = draw(seed_, purpose_, entity_, Domain::kFillNormal, tick, index / 4 + b);
      for (std::uint32_t pair = 0; pair < 2; ++pair) {
        u[2 * b + pair] = (static_cast<float>(r[2 * pair] >> 8) + 1.0F) * 0x1.0p-24F;
        v[2 * b + pair] = unit_float(r[2 * pair + 1]);
      }
    }
    Lanes radius = -2.0F * u.log();
    take_roots(std::span(radius.data(), std::size_t{2} * kBlocks));
    const Lanes angle = (2.0F * std::numbers::pi_v<float>)*v;
    const Lanes x = radius * angle.cos();
    const Lanes y = radius * angle.sin();
    for (std::uint32_t word = index % 4; word < 4 * kBlocks && k < out.size(); ++word, ++k) {
      out[k] = word % 2 == 0 ? x[word / 2] : y[word / 2];
    }
  }
}

}  // namespace swiftlet
