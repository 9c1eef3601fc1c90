// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <span>
#include <string_view>

#include "swiftlet/sim/metrics/metric.hpp"
#include "swiftlet/sim/metrics/metrics.hpp"

namespace swiftlet::sim {

namespace {

// Escapes '|', which would begin a new table cell.
std::string cell(std::string_view text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '|') escaped += '\\';
    escaped += c;
  }
  return escaped;
}

void append_table(std::string& text, const char* name, const char* doc, std::span<const MetricDefinition> definitions) {
  text += fmt::format("\n## `{}`: {}\n| metric | unit | definition |\n| --- | --- | --- |\n", name, doc);
  for (const MetricDefinition& metric : definitions)
    text += fmt::format("| `{}` | {} | {} |\n", metric.name, metric.unit, cell(metric.definition));
}

}  // namespace

std::string metrics_reference() {
  std::string text =
      "<!-- Written by `swiftlet reference metrics`. -->\n"
      "# Metrics of a run\n\n"
      "For readers of `summary.json`, the table of a batch, or a report: the definition of each "
      "figure.\n"
      "Metrics of the whole run have no vehicle, the others have its name. Unmeasured values are\n"
      "`null`. Positions, distances and speeds are true ones in the world frame, unless stated otherwise.\n"
      "`swiftlet list metrics` prints the same definitions.\n\n"
      "## Outcomes\n"
      "| outcome | definition |\n| --- | --- |\n";
  for (const OutcomeDefinition& word : outcome_definitions())
    text += fmt::format("| `{}` | {} |\n", word.name, word.definition);
  text +=
      "\nThe outcome of a run is the worst one of its vehicles; the table is ordered from best to worst. Episodes that "
      "did not\n"
      "end by themselves have statuses of their own ([batch.md](batch.md)).\n";
  for (const MetricType& type : metric_registry()) append_table(text, type.name, type.doc, type.definitions);
  const MetricDefinition radio[] = {kRadioMetrics.sent, kRadioMetrics.delivered, kRadioMetrics.bytes,
                                    kRadioMetrics.mean_delay};
  append_table(text, "radio", "columns of the radio in tables of batches; `summary.json` has more under `radio`",
               radio);
  return text;
}

}  // namespace swiftlet::sim
