// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

namespace swiftlet {

/// Settings of Embree for each instruction set that it supports on this processor. Embree rejects all others.
inline std::vector<std::string> embree_settings() {
  std::vector<std::string> settings = {"isa=sse2", "isa=sse4.2"};
  if (__builtin_cpu_supports("avx")) settings.emplace_back("isa=avx");
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) settings.emplace_back("isa=avx2");
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512cd") &&
      __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512vl")) {
    settings.emplace_back("isa=avx512,frequency_level=simd256");
    settings.emplace_back("isa=avx512,frequency_level=simd512");
  }
  return settings;
}

}  // namespace swiftlet
