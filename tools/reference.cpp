// SPDX-License-Identifier: BSD-3-Clause
#include <cstdio>

#include "commands.hpp"
#include "sim/scenario/reference.hpp"

namespace swiftlet::tools {

void add_reference(CLI::App& app) {
  Subcommand command(app, "reference", "Print the reference of every configuration key (docs/reference.md)");
  command.action([] {
    const std::string text = sim::write_reference();
    std::fwrite(text.data(), 1, text.size(), stdout);
  });
}

}  // namespace swiftlet::tools
