// SPDX-License-Identifier: BSD-3-Clause
#include <cstdio>
#include <memory>
#include <string>

#include "commands.hpp"
#include "plugin_options.hpp"
#include "swiftlet/sim/dataset/dataset_config.hpp"
#include "swiftlet/sim/errors/errors.hpp"
#include "swiftlet/sim/metrics/metrics.hpp"
#include "swiftlet/sim/scenario/reference.hpp"

namespace swiftlet::tools {

void add_reference(CLI::App& app) {
  Subcommand command(
      app, "reference",
      "Print, as Markdown, the reference of all keys of a scenario (docs/reference.md) or a dataset, or of all metrics "
      "(docs/metrics.md)");
  auto what = std::make_shared<std::string>("scenario");
  command.option("what", *what, "What to describe: scenario, dataset or metrics");
  auto plugins = std::make_shared<PluginOptions>();
  plugins->add_to(command);
  command.action([what, plugins] {
    plugins->load();
    if (*what != "scenario" && *what != "dataset" && *what != "metrics") {
      throw sim::InputError("reference " + *what + ": expected scenario, dataset or metrics");
    }
    const std::string text = *what == "dataset"   ? sim::dataset_reference()
                             : *what == "metrics" ? sim::metrics_reference()
                                                  : sim::write_reference();
    std::fwrite(text.data(), 1, text.size(), stdout);
  });
}

}  // namespace swiftlet::tools
