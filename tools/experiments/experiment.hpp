// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "published.hpp"
#include "swiftlet/sim/plot/plot.hpp"

/// Reproduced experiments of the literature: one file each in this folder, one row each in registry.cpp.
namespace swiftlet::tools {

enum class Verdict {
  kReproduced,       ///< within the tolerance
  kBetter,           ///< beyond what was published, under the same conditions or harder ones
  kDiffers,          ///< outside the tolerance; the row's note gives the cause
  kOtherConditions,  ///< conditions differ, so the figures are not comparable
  kNotJudged,        ///< no published figure, or no significant difference
};

/// One line of the table published | ours | verdict.
struct ResultRow {
  std::string what;  ///< with its unit: "mean position error at 10 m [m]"
  std::string ours;
  Verdict verdict = Verdict::kNotJudged;
  std::string note;
  double value = 0.0;           ///< ours as a number, for programs; NaN: none
  std::string tolerance = {};   ///< within which it counts as reproduced, or a limit of our own: "± 10 %", ">= 0.95"
  std::string published = "-";  ///< as printed; the experiment fills it in from published.csv
};
/// Text of the verdict column; "no published figure" for such rows, whatever their verdict.
std::string verdict_of(const ResultRow& row);
/// The tolerance, and whether a limit of our own is kept.
std::string tolerance_of(const ResultRow& row);

struct ExperimentOptions {
  std::string name = {};                 ///< key in published.csv
  std::filesystem::path directory = {};  ///< where the experiment writes; exists
  int jobs = 1;                          ///< runs at a time
  std::optional<int> repetitions = {};   ///< instead of the experiment's own number
  bool quick = false;                    ///< a small version: fewer samples or seeds, shorter flights
  bool resume = false;                   ///< reuse the finished flights of an earlier attempt
  /// May be empty; called from one thread at a time.
  std::function<void(double done, const std::string& note)> progress = {};
};

/// Comma-separated values: a header, then rows of as many fields.
class CsvTable {
 public:
  explicit CsvTable(std::vector<std::string> columns) : columns_(std::move(columns)) {}
  CsvTable& row(std::initializer_list<double> values) { return row(std::span(values.begin(), values.size())); }
  CsvTable& row(std::span<const double> values);  ///< shortest text that reads back as the same number
  CsvTable& row(const std::string& name, std::initializer_list<double> values);  ///< the first field is text
  std::string text() const;

 private:
  CsvTable& add(const std::vector<std::string>& fields);
  std::vector<std::string> columns_;
  std::vector<std::string> lines_;
};

class FlightLog;

/// Options, result table and output files of one experiment.
class Experiment {
 public:
  explicit Experiment(ExperimentOptions options);
  ~Experiment();

  bool quick() const { return options_.quick; }
  int jobs() const { return options_.jobs; }
  /// Runs per case: the user's choice, else the experiment's number for this version.
  int repetitions(int full, int quick_version);
  /// Largest number that repetitions() returned; 0: not called.
  int most_repetitions() const { return most_repetitions_; }
  void progress(double done, const std::string& note) const;
  /// nullptr: flights are not kept (no directory). Throws std::runtime_error when it cannot be written.
  FlightLog* flight_log() const;

  /// The published figure of the row `what`. Throws std::logic_error when there is none.
  const PublishedFigure& published(const std::string& what) const;

  /// Adds any row. This and the functions below look up the published figure in published.csv.
  void row(ResultRow row);
  /// Reproduced when |ours - published| <= tolerance * |published|.
  void within(const std::string& what, double ours, double tolerance, int digits, const std::string& note = {});
  /// Reproduced when ours is within the limit.
  void at_most(const std::string& what, double ours, double limit, int digits, const std::string& note = {});
  void at_least(const std::string& what, double ours, double limit, int digits, const std::string& note = {});
  /// A statement that holds or does not.
  void claim(const std::string& what, const std::string& ours, bool holds, const std::string& note = {});

  void write(const std::string& file, const CsvTable& table);
  void write(const std::string& file, const sim::plot::Figure& figure);
  void write(const std::string& file, const std::string& text);

  const std::vector<ResultRow>& rows() const { return rows_; }
  const std::vector<std::string>& files() const { return files_; }

 private:
  ExperimentOptions options_;
  mutable std::unique_ptr<FlightLog> flight_log_;  // created with the first flights
  int most_repetitions_ = 0;
  std::vector<ResultRow> rows_;
  std::vector<std::string> files_;
};

/// One row of registry.cpp.
struct ExperimentType {
  const char* name;  ///< "uncertainty-table"
  const char* doc;   ///< one line: what it shows and which figure or table it regenerates
  void (*run)(Experiment& experiment);
};

std::span<const ExperimentType> experiment_types();
/// Throws InputError with the known names.
const ExperimentType& experiment_type(const std::string& name);

/// `digits` significant digits, plain or in powers of ten.
std::string short_number(double value, int digits);
/// The table as Markdown and as JSON (with the experiment's name, revision and files).
std::string to_markdown(const ExperimentType& type, const Experiment& experiment);
std::string to_json(const ExperimentType& type, const Experiment& experiment);

}  // namespace swiftlet::tools
