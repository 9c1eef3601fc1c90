// SPDX-License-Identifier: BSD-3-Clause
// The program swiftlet with one additional guidance: my_swiftlet run SCENARIO.yaml
#include "spiral.hpp"
#include "swiftlet/program.hpp"

int main(int argc, char** argv) {
  swiftlet::guidance_registry().add(spiral());
  return swiftlet::main(argc, argv);
}
