// SPDX-License-Identifier: BSD-3-Clause
#include "optional/rooms.hpp"
#include "swiftlet/program.hpp"

int main(int argc, char** argv) {
  swiftlet::tools::plug_in_optional_rooms();
  return swiftlet::main(argc, argv);
}
