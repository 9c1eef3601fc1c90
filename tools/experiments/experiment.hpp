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

/// Experiments of the literature, flown or computed again: one file each in this folder, one row each in registry.cpp.
namespace swiftlet::tools {

enum class Verdict {
  kReproduced,       ///< within the tolerance
  kBetter,           ///< beyond what was published, under the same conditions or harder ones
  kDiffers,          ///< outside the tolerance: the row's note says why
  kOtherConditions,  ///< the conditions are not the same, so the two figures say little about each other
  kNotJudged,        ///< a figure of our own
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
/// The words of the table. A row without a published figure says so, whatever it was judged by.
std::string verdict_of(const ResultRow& row);
/// The tolerance, and whether a limit of our own is kept.
std::string tolerance_of(const ResultRow& row);

struct ExperimentOptions {
  std::string name = {};                 ///< under which published.csv knows the experiment
  std::filesystem::path directory = {};  ///< where the experiment writes; exists
  int jobs = 1;                          ///< runs at a time
  std::optional<int> repetitions = {};   ///< instead of the experiment's own number
  bool quick = false;                    ///< a small version: fewer samples or seeds, shorter flights
  bool resume = false;                   ///< flights that an earlier attempt finished are not flown again
  std::function<void(double done, const std::string& note)> progress =
      {};  ///< may be empty; called from one thread at a time
};

/// Comma-separated values: a header, then rows of as many fields.
class CsvTable {
 public:
  explicit CsvTable(std::vector<std::string> columns) : columns_(std::move(columns)) {}
  CsvTable& row(std::initializer_list<double> values) { return row(std::span(values.begin(), values.size())); }
  CsvTable& row(std::span<const double> values);  ///< shortest text that reads back as the same number
  CsvTable& row(const std::string& name, std::initializer_list<double> values);  ///< the first field is a word
  std::string text() const;

 private:
  CsvTable& add(const std::vector<std::string>& fields);
  std::vector<std::string> columns_;
  std::vector<std::string> lines_;
};

class FlightLog;

/// What an experiment is handed, and where its results go.
class Experiment {
 public:
  explicit Experiment(ExperimentOptions options);
  ~Experiment();

  bool quick() const { return options_.quick; }
  int jobs() const { return options_.jobs; }
  /// How many runs a case: what the user asked for, else the experiment's number for this version.
  int repetitions(int full, int quick_version);
  /// The largest number that was asked for so; 0: none was.
  int most_repetitions() const { return most_repetitions_; }
  void progress(double done, const std::string& note) const;
  /// nullptr: nothing is to be kept (no directory). Throws std::runtime_error when it cannot be written.
  FlightLog* flight_log() const;

  /// What was published for the row `what`. Throws std::logic_error when nothing was.
  const PublishedFigure& published(const std::string& what) const;

  /// Any row. What was published stands in the table published.csv, here and below.
  void row(ResultRow row);
  /// Reproduced when |ours - published| <= tolerance * |published|.
  void within(const std::string& what, double ours, double tolerance, int digits, const std::string& note = {});
  /// Reproduced when ours is within the limit.
  void at_most(const std::string& what, double ours, double limit, int digits, const std::string& note = {});
  void at_least(const std::string& what, double ours, double limit, int digits, const std::string& note = {});
  /// A statement that came out or did not.
  void claim(const std::string& what, const std::string& ours, bool holds, const std::string& note = {});

  void write(const std::string& file, const CsvTable& table);
  void write(const std::string& file, const sim::plot::Figure& figure);
  void write(const std::string& file, const std::string& text);

  const std::vector<ResultRow>& rows() const { return rows_; }
  const std::vector<std::string>& files() const { return files_; }

 private:
  ExperimentOptions options_;
  mutable std::unique_ptr<FlightLog> flight_log_;  // made when the first flights are
  int most_repetitions_ = 0;
  std::vector<ResultRow> rows_;
  std::vector<std::string> files_;
};

/// One row of registry.cpp.
struct ExperimentType {
  const char* name;   ///< "uncertainty-table"
  const char* doc;    ///< one line: what it shows and which figure or table it regenerates
  double expected_s;  ///< processor time of the full version, roughly
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
