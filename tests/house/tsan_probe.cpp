// SPDX-License-Identifier: BSD-3-Clause
// Checks that the thread sanitizer handles parallel regions (cmake/tsan/openmp.cpp): `tsan_probe clean` passes data
// from region to region and must pass without a report; in `tsan_probe race` iterations of one region share a number.
#include <cstdio>
#include <string>
#include <vector>

int main(int argc, char** argv) {
  const bool race = argc > 1 && std::string(argv[1]) == "race";
  std::vector<int> values(64, 0);
  int sum = 0, shared = 0;
  for (int round = 0; round < 50; ++round) {
    values.assign(64, round);
#pragma omp parallel for schedule(dynamic, 1) num_threads(4)
    for (int i = 0; i < 64; ++i) values[i] += i;
#pragma omp parallel for schedule(static) num_threads(4)
    for (int i = 0; i < 64; ++i) {
      values[i] *= 2;
      if (race) shared += values[i];
    }
    for (const int value : values) sum += value;
  }
  std::printf("%d %d\n", sum, shared);
  return 0;
}
