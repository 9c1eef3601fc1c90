// SPDX-License-Identifier: BSD-3-Clause
#include "experiment.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "flight_log.hpp"
#include "swiftlet/sim/errors.hpp"
#include "swiftlet/sim/io/files.hpp"
#include "swiftlet/sim/io/text.hpp"
#include "swiftlet/sim/run/version.hpp"
#include "swiftlet/sim/scenario/suggest.hpp"

namespace swiftlet::tools {
namespace {

std::string field(double value) { return std::isnan(value) ? std::string() : fmt::format("{}", value); }

ResultRow number_row(const std::string& what, double ours, int digits, bool holds, const std::string& note,
                     std::string tolerance) {
  return {what, short_number(ours, digits), holds ? Verdict::kReproduced : Verdict::kDiffers, note,
          ours, std::move(tolerance)};
}

// Escapes bars, which end a cell in Markdown.
std::string cell(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '|') out += '\\';
    out += c;
  }
  return out.empty() ? "-" : out;
}

/// Version and number of runs per case, as text below the table.
std::string made_by(const Experiment& experiment) {
  std::string text = fmt::format("Swiftlet {} ({})", sim::version(), sim::git_revision());
  if (experiment.most_repetitions() > 0)
    text +=
        fmt::format(", {} run{} a case", experiment.most_repetitions(), experiment.most_repetitions() == 1 ? "" : "s");
  return text + (experiment.quick() ? "; fewer and shorter than the full version." : ".");
}

}  // namespace

std::string verdict_of(const ResultRow& row) {
  if (row.published == "-") return "no published figure";
  switch (row.verdict) {
    case Verdict::kReproduced:
      return "reproduced";
    case Verdict::kBetter:
      return "better";
    case Verdict::kDiffers:
      return "differs";
    case Verdict::kOtherConditions:
    case Verdict::kNotJudged:
      return "other conditions";
  }
  return "";
}

std::string tolerance_of(const ResultRow& row) {
  if (row.tolerance.empty() || row.published != "-") return row.tolerance;
  return row.tolerance + (row.verdict == Verdict::kDiffers ? ": missed" : ": kept");
}

CsvTable& CsvTable::row(std::span<const double> values) {
  std::vector<std::string> fields;
  for (const double value : values) fields.push_back(field(value));
  return add(fields);
}

CsvTable& CsvTable::row(const std::string& name, std::initializer_list<double> values) {
  std::vector<std::string> fields{sim::csv_cell(name)};
  for (const double value : values) fields.push_back(field(value));
  return add(fields);
}

CsvTable& CsvTable::add(const std::vector<std::string>& fields) {
  if (fields.size() != columns_.size())
    throw std::logic_error("a row of a CSV table has another length than its header");
  lines_.push_back(fmt::format("{}", fmt::join(fields, ",")));
  return *this;
}

std::string CsvTable::text() const {
  std::vector<std::string> names;
  for (const std::string& column : columns_) names.push_back(sim::csv_cell(column));
  std::string text = fmt::format("{}\n", fmt::join(names, ","));
  for (const std::string& line : lines_) text += line + "\n";
  return text;
}

Experiment::Experiment(ExperimentOptions options) : options_(std::move(options)) {}

Experiment::~Experiment() = default;

FlightLog* Experiment::flight_log() const {
  if (!flight_log_ && !options_.directory.empty()) {
    flight_log_ = std::make_unique<FlightLog>(options_.directory / "flights.jsonl", options_.resume);
  }
  return flight_log_.get();
}

int Experiment::repetitions(int full, int quick_version) {
  const int count = options_.repetitions ? *options_.repetitions : options_.quick ? quick_version : full;
  most_repetitions_ = std::max(most_repetitions_, count);
  return count;
}

void Experiment::progress(double done, const std::string& note) const {
  if (options_.progress) options_.progress(done, note);
}

const PublishedFigure& Experiment::published(const std::string& what) const {
  const PublishedFigure* figure = find_published(options_.name, what);
  if (figure == nullptr) throw std::logic_error("published.csv has nothing for " + options_.name + ": " + what);
  return *figure;
}

void Experiment::row(ResultRow row) {
  if (const PublishedFigure* figure = find_published(options_.name, row.what)) row.published = figure->text;
  rows_.push_back(std::move(row));
}

void Experiment::within(const std::string& what, double ours, double tolerance, int digits, const std::string& note) {
  const double wanted = published(what).value;
  row(number_row(what, ours, digits, std::abs(ours - wanted) <= tolerance * std::abs(wanted), note,
                 fmt::format("± {:.3g} %", 100.0 * tolerance)));
}

void Experiment::at_most(const std::string& what, double ours, double limit, int digits, const std::string& note) {
  row(number_row(what, ours, digits, ours <= limit, note, fmt::format("<= {:g}", limit)));
}

void Experiment::at_least(const std::string& what, double ours, double limit, int digits, const std::string& note) {
  row(number_row(what, ours, digits, ours >= limit, note, fmt::format(">= {:g}", limit)));
}

void Experiment::claim(const std::string& what, const std::string& ours, bool holds, const std::string& note) {
  row({what, ours, holds ? Verdict::kReproduced : Verdict::kDiffers, note, std::numeric_limits<double>::quiet_NaN(),
       "it holds"});
}

void Experiment::write(const std::string& file, const CsvTable& table) { write(file, table.text()); }

void Experiment::write(const std::string& file, const sim::plot::Figure& figure) { write(file, figure.svg()); }

void Experiment::write(const std::string& file, const std::string& text) {
  sim::write_file(options_.directory / file, text);
  files_.push_back(file);
}

const ExperimentType& experiment_type(const std::string& name) {
  std::vector<std::string> names;
  for (const ExperimentType& type : experiment_types()) {
    if (type.name == name) return type;
    names.emplace_back(type.name);
  }
  throw sim::InputError(
      fmt::format("reproduce {}: expected one of {}{}", name, fmt::join(names, ", "), sim::did_you_mean(name, names)));
}

std::string short_number(double value, int digits) {
  if (!std::isfinite(value)) return "-";
  const double size = std::abs(value);
  if (value != 0.0 && (size < 1e-3 || size >= 1e6)) return fmt::format("{:.{}e}", value, std::max(digits - 1, 0));
  const int whole = size < 1.0 ? (value == 0.0 ? 1 : static_cast<int>(std::floor(std::log10(size))) + 1)
                               : static_cast<int>(std::floor(std::log10(size))) + 1;
  return fmt::format("{:.{}f}", value, std::max(digits - whole, 0));
}

std::string to_markdown(const ExperimentType& type, const Experiment& experiment) {
  std::string text = fmt::format("# {}{}\n\n{}\n\n", type.name, experiment.quick() ? ", quick version" : "", type.doc);
  text += made_by(experiment) + "\n\n";
  text += "| what | published | tolerance | ours | verdict | note |\n| --- | --- | --- | --- | --- | --- |\n";
  for (const ResultRow& row : experiment.rows()) {
    text += fmt::format("| {} | {} | {} | {} | {} | {} |\n", cell(row.what), cell(row.published), tolerance_of(row),
                        cell(row.ours), verdict_of(row), row.note.empty() ? "" : cell(row.note));
  }
  for (const std::string& file : experiment.files()) {
    if (file.ends_with(".svg")) text += fmt::format("\n![{}]({})\n", file, file);
  }
  return text;
}

std::string to_json(const ExperimentType& type, const Experiment& experiment) {
  nlohmann::ordered_json json;
  json["experiment"] = type.name;
  json["doc"] = type.doc;
  json["version"] = sim::version();
  json["revision"] = sim::git_revision();
  json["quick"] = experiment.quick();
  json["repetitions"] = experiment.most_repetitions();
  json["rows"] = nlohmann::ordered_json::array();
  for (const ResultRow& row : experiment.rows()) {
    nlohmann::ordered_json one{{"what", row.what}, {"published", row.published}, {"tolerance", tolerance_of(row)},
                               {"ours", row.ours}, {"verdict", verdict_of(row)}, {"note", row.note}};
    if (std::isfinite(row.value)) one["value"] = row.value;
    json["rows"].push_back(std::move(one));
  }
  json["files"] = experiment.files();
  return json.dump(2) + "\n";
}

}  // namespace swiftlet::tools
