// SPDX-License-Identifier: BSD-3-Clause
#include <cstdio>
#include <memory>
#include <string>

#include "commands.hpp"
#include "swiftlet/sim/dataset/dataset_config.hpp"
#include "swiftlet/sim/errors.hpp"
#include "swiftlet/sim/scenario/reference.hpp"

namespace swiftlet::tools {

void add_reference(CLI::App& app) {
  Subcommand command(app, "reference", "Print the reference of every configuration key (docs/reference.md)");
  auto what = std::make_shared<std::string>("scenario");
  command.option("what", *what, "scenario or dataset");
  command.action([what] {
    if (*what != "scenario" && *what != "dataset") {
      throw sim::InputError("reference " + *what + ": expected scenario or dataset");
    }
    const std::string text = *what == "dataset" ? sim::dataset_reference() : sim::write_reference();
    std::fwrite(text.data(), 1, text.size(), stdout);
  });
}

}  // namespace swiftlet::tools
