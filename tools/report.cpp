// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "commands.hpp"
#include "swiftlet/sim/errors/errors.hpp"
#include "swiftlet/sim/report/batch_report.hpp"
#include "swiftlet/sim/report/run_report.hpp"

namespace swiftlet::tools {
namespace {

namespace fs = std::filesystem;

struct ReportOptions {
  std::string directory;
  bool quiet = false;
};

std::vector<fs::path> write_report(const fs::path& directory) {
  if (fs::is_regular_file(directory / "summary.json")) return sim::write_run_report(directory);
  if (fs::is_regular_file(directory / "results.sqlite") || fs::is_directory(directory / "shards"))
    return sim::write_batch_report(directory);
  throw sim::InputError(
      directory.string() +
      ": expected a run directory (with summary.json) or a batch directory (with results.sqlite), found none");
}

void report(const ReportOptions& options) {
  const auto written = write_report(options.directory);
  if (options.quiet) return;
  for (const fs::path& path : written) fmt::print("{}\n", path.string());
}

}  // namespace

void add_report(CLI::App& app) {
  auto options = std::make_shared<ReportOptions>();
  Subcommand command(app, "report", "Write a page about a run or a batch");
  command.option("directory", options->directory, "Run directory or batch directory",
                 {.value_name = "DIR", .required = true});
  command.flag("-q,--quiet", options->quiet, "Print errors only");
  command.action([options] { report(*options); });
}

}  // namespace swiftlet::tools
