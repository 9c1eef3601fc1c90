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
      "# What the results of a run mean\n\n"
      "This page is for those who read `summary.json`, the table of a batch, or a report. After it you know how each "
      "figure\n"
      "is computed. Metrics of the whole run have no vehicle, the others have its name. What could not be measured is\n"
      "`null`. Positions, distances and speeds are true ones in the world frame, where nothing else is said.\n"
      "`swiftlet list metrics` prints the same.\n\n"
      "## Outcomes\n"
      "| outcome | what it means |\n| --- | --- |\n";
  for (const OutcomeDefinition& word : outcome_definitions())
    text += fmt::format("| `{}` | {} |\n", word.name, word.definition);
  text +=
      "\nA run is as good as its worst vehicle; the outcomes stand here from best to worst. Episodes of a batch that "
      "did not\n"
      "end by themselves have words of their own ([batch.md](batch.md)).\n";
  for (const MetricType& type : metric_registry()) append_table(text, type.name, type.doc, type.definitions);
  const MetricDefinition radio[] = {kRadioMetrics.sent, kRadioMetrics.delivered, kRadioMetrics.bytes,
                                    kRadioMetrics.mean_delay};
  append_table(text, "radio", "what tables of batches tell of the radio; `summary.json` has more under `radio`", radio);
  return text;
}

}  // namespace swiftlet::sim
