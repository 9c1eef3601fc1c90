// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/report/batch_report.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sqlite3.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <sstream>

#include "sim/report/group_samples.hpp"
#include "sim/report/html.hpp"
#include "sim/report/time_series.hpp"
#include "swiftlet/sim/errors/errors.hpp"
#include "swiftlet/sim/io/files.hpp"
#include "swiftlet/sim/io/text.hpp"
#include "swiftlet/sim/report/run_report.hpp"
#include "tests/support/temporary_directory.hpp"

namespace swiftlet::sim {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::Not;

/// Two variants, two winds, six seeds; known numbers.
class BatchReport : public ::testing::Test {
 protected:
  void SetUp() override {
    ResultStore store(folder_.path() / "results.sqlite", ResultStore::Mode::kCreate);
    BatchInfo info;
    info.name = "winds & gains";
    info.text =
        "name: winds\nscenario: x\nsweep: {parameters: [{key: wind, name: wind_mps, values: [0, 5]}]}\nreport: "
        "{worst_by: error_m}\n";
    info.file = "batch.yaml";
    info.fingerprint = "f00d";
    info.version = "0.1.0";
    info.num_episodes = 24;
    info.variants = {"old", "new"};
    info.parameters = {"wind_mps"};
    store.set_info(info);
    for (std::uint64_t id = 0; id < 24; ++id) store.add(row(id));
  }

  static EpisodeRow row(std::uint64_t id) {
    const std::uint64_t variant = id % 2, seed = id / 2 % 6, point = id / 12;
    EpisodeRow row;
    row.id = id;
    row.variant = variant == 0 ? "old" : "new";
    row.point = point;
    row.seed = seed;
    row.parameters = {point == 0 ? "0" : "5"};
    row.status = "done";
    row.outcome = variant == 0 && seed < 2 ? "crashed" : "done";
    row.state_hash = "0123";
    row.simulated_s = 10.0;
    row.command = "swiftlet run x --seed " + std::to_string(seed);
    // error_m of a: 10 m times the seed, plus 1 m at the second point, less 0.5 m +- 0.01 m for the new variant.
    const double seed_error_m = 10.0 * static_cast<double>(seed);
    const double noise = variant == 1 ? 0.01 * (seed % 2 == 0 ? 1.0 : -1.0) : 0.0;
    row.metrics = {{"error_m", "a",
                    seed_error_m + static_cast<double>(point) - 0.5 * static_cast<double>(variant) + noise, "m", ""},
                   {"error_m", "b", seed_error_m, "m", ""},
                   {"never_m", "", std::nan(""), "m", ""},
                   {"partner", "", 0.0, "", "tree <1>"}};
    if (id == 23) {
      row.status = "crashed";
      row.outcome = "";
      row.message = "killed by signal 11";
      row.metrics.clear();
    }
    return row;
  }

  BatchTable table() const {
    return read_batch_table(ResultStore(folder_.path() / "results.sqlite", ResultStore::Mode::kRead));
  }

  TemporaryDirectory folder_;
};

TEST_F(BatchReport, GathersGroupsOutcomesAndNumbers) {
  const BatchTable t = table();
  ASSERT_EQ(t.groups.size(), 4U);
  EXPECT_EQ(t.name_of(t.groups[1]), "wind_mps 0, new");
  EXPECT_EQ(t.groups[2].episodes.size(), 6U);
  EXPECT_EQ(t.outcomes, (std::vector<std::string>{"crashed", "done"}));
  EXPECT_EQ(t.find("never_m", ""), nullptr);
  EXPECT_EQ(t.find("partner", ""), nullptr);
  ASSERT_NE(t.find("error_m", "mean"), nullptr);
  EXPECT_DOUBLE_EQ(t.find("error_m", "mean")->values[2], 10.0);  // (10 + 10) / 2
  EXPECT_DOUBLE_EQ(t.find("error_m", "a")->values[1], -0.5 + 0.01);
  EXPECT_EQ(count_outcome(t, "crashed", t.groups[0]), 2U);
}

// Databases that Swiftlet never writes: either a report is written, or an InputError names the file.
TEST_F(BatchReport, IncompleteDatabasesYieldReportOrMessage) {
  const fs::path file = folder_.path() / "results.sqlite";
  const auto run = [&](const char* sql) {
    sqlite3* database = nullptr;
    ASSERT_EQ(sqlite3_open(file.c_str(), &database), SQLITE_OK);
    EXPECT_EQ(sqlite3_exec(database, sql, nullptr, nullptr, nullptr), SQLITE_OK) << sql;
    sqlite3_close(database);
  };
  const fs::path whole = folder_.path() / "whole";
  fs::copy_file(file, whole);
  for (const char* sql :
       {"UPDATE batch SET value = '[]' WHERE key = 'variants'",
        "UPDATE batch SET value = '[]' WHERE key IN ('variants', 'parameters')",
        "UPDATE batch SET value = '[\"other\"]' WHERE key = 'variants'", "DELETE FROM batch WHERE key = 'variants'",
        "DELETE FROM batch WHERE key = 'parameters'", "DELETE FROM episodes", "DELETE FROM metrics",
        "DELETE FROM parameters", "DELETE FROM timing", "UPDATE metrics SET value = NULL, text = NULL",
        "UPDATE episodes SET simulated_s = NULL", "UPDATE episodes SET point = -1",
        "UPDATE episodes SET point = 9223372036854775807, seed = -1", "UPDATE metrics SET value = 1e308",
        "UPDATE parameters SET value = NULL, name = 'wind_mps'",
        "UPDATE timing SET wall_s = NULL, flight_wall_s = 0"}) {
    fs::copy_file(whole, file, fs::copy_options::overwrite_existing);
    run(sql);
    EXPECT_EQ(write_batch_report(folder_.path()).size(), 2U) << sql;
  }
  for (const char* sql : {"DELETE FROM batch", "DELETE FROM batch WHERE key = 'fingerprint'",
                          "DELETE FROM batch WHERE key = 'num_episodes'", "DELETE FROM batch WHERE key = 'text'",
                          "UPDATE batch SET value = 'nonsense: 1' WHERE key = 'text'",
                          "UPDATE batch SET value = '[[]]' WHERE key = 'variants'", "DROP TABLE metrics",
                          "DROP TABLE episodes", "DROP TABLE timing", "DROP TABLE parameters"}) {
    fs::copy_file(whole, file, fs::copy_options::overwrite_existing);
    run(sql);
    EXPECT_THAT([&] { write_batch_report(folder_.path()); },
                ::testing::ThrowsMessage<InputError>(HasSubstr(file.string() + ": ")))
        << sql;
  }
}

TEST_F(BatchReport, DifferencesArePairedBySeed) {
  const BatchTable t = table();
  ASSERT_EQ(t.reference_of(t.groups[0]), nullptr);
  ASSERT_EQ(t.reference_of(t.groups[3]), &t.groups[2]);
  const Quantity& error = *t.find("error_m", "a");
  const PairedValues all = paired_values(t, error, t.groups[0], t.groups[1]);
  const SampleSummary d = paired_difference(all.first, all.second);
  EXPECT_EQ(d.n, 6U);
  EXPECT_NEAR(d.mean, -0.5, 1e-12);
  EXPECT_LT(d.mean_ci.high, -0.48);  // although the seeds differ by 10 m each
  const PairedValues with_failure = paired_values(t, error, t.groups[2], t.groups[3]);
  EXPECT_EQ(paired_difference(with_failure.first, with_failure.second).n, 5U);
  const PairedCounts counts = paired_outcomes(t, "crashed", t.groups[2], t.groups[3]);
  EXPECT_EQ(counts.first_only, 2U);
  EXPECT_EQ(counts.neither, 3U);
}

TEST_F(BatchReport, PairsAllByPointAndSeed) {
  const BatchTable t = table();
  ASSERT_EQ(t.totals.size(), 2U);
  EXPECT_EQ(t.name_of(t.totals[1]), "all points, new");
  EXPECT_EQ(t.totals[0].episodes.size(), 12U);
  ASSERT_EQ(t.reference_of(t.totals[1]), &t.totals[0]);
  const Quantity& error = *t.find("error_m", "a");
  const PairedValues all = paired_values(t, error, t.totals[0], t.totals[1]);
  const SampleSummary d = paired_difference(all.first, all.second);
  EXPECT_EQ(d.n, 11U);  // one of the twelve failed
  // Every pair differs by 0.5 m less its noise of -+0.01 m, although points and seeds differ by meters.
  EXPECT_NEAR(d.mean, -0.5 + 0.01 / 11.0, 1e-12);
  EXPECT_LT(d.sd, 0.011);
  EXPECT_EQ(paired_outcomes(t, "crashed", t.totals[0], t.totals[1]).first_only, 4U);
}

TEST_F(BatchReport, PageContainsEveryResult) {
  const std::string page = batch_report_html(table());
  EXPECT_THAT(page, HasSubstr("winds &amp; gains"));
  EXPECT_THAT(page, HasSubstr("crashed [% of episodes]"));
  EXPECT_THAT(page, HasSubstr("difference of error_m (mean) to old"));
  EXPECT_THAT(page, HasSubstr("23 done"));
  EXPECT_THAT(page, HasSubstr("<svg"));
  EXPECT_THAT(page, HasSubstr("wind_mps 5, new"));
  EXPECT_THAT(page, HasSubstr("33.33 %"));  // two crashes of six
  EXPECT_THAT(page, HasSubstr("killed by signal 11"));
  EXPECT_THAT(page, HasSubstr("Worst episodes: greatest error_m (a)"));
  EXPECT_LT(page.find("<td class=\"w\">22</td>"), page.find("<td class=\"w\">10</td>"));  // 51 m before 50 m
  EXPECT_THAT(page, HasSubstr("swiftlet run x --seed 5 --replay"));
  EXPECT_THAT(page, Not(HasSubstr("<1>")));
  EXPECT_THAT(page, Not(HasSubstr("nan")));
}

TEST_F(BatchReport, ListsTenWorstEpisodesInOrder) {
  const std::string page = batch_report_html(table());
  const std::size_t begin = page.find("Worst episodes");
  std::string section = page.substr(begin, page.find("</table>", begin) - begin);
  std::vector<int> episodes;
  // The first cell of a row is the episode's number.
  for (std::size_t at = 0; (at = section.find("<tr><td", at)) != std::string::npos; ++at) {
    episodes.push_back(std::stoi(section.substr(section.find('>', at + 4) + 1)));
  }
  // Episode 23 is not done. The seed accounts for 10 m, the wind for 1 m, the old variant for 0.5 m.
  EXPECT_EQ(episodes, (std::vector<int>{22, 10, 11, 20, 21, 8, 9, 18, 19, 6}));
}

TEST_F(BatchReport, CsvHasEveryGroupAndQuantity) {
  const auto written = write_batch_report(folder_.path());
  ASSERT_EQ(written.size(), 2U);
  std::ifstream file(folder_.path() / "report.csv");
  std::vector<std::string> lines;
  for (std::string line; std::getline(file, line);) lines.push_back(line);
  ASSERT_EQ(lines.size(), 1U + (4U + 2U) * (2U + 3U));  // groups and totals; two outcomes, a, b and their mean
  const auto commas = [](const std::string& line) { return std::count(line.begin(), line.end(), ','); };
  for (const std::string& line : lines) EXPECT_EQ(commas(line), commas(lines[0])) << line;
  EXPECT_THAT(lines, ::testing::Contains(HasSubstr("0,old,0,outcome = crashed,,6,0.3333333333333333,,0.0967")));
  EXPECT_THAT(lines, ::testing::Contains(HasSubstr("all,old,,outcome = crashed,,12,0.3333333333333333,,")));
}

/// Cells of the first table after the first occurrence of `mark`, by rows, without the header.
std::vector<std::vector<std::string>> table_after(const std::string& page, const std::string& mark) {
  std::vector<std::vector<std::string>> rows;
  const std::size_t begin = page.find("<tbody>", page.find(mark)), end = page.find("</tbody>", begin);
  for (std::size_t row = page.find("<tr>", begin); row < end; row = page.find("<tr>", row + 1)) {
    rows.emplace_back();
    const std::size_t row_end = page.find("</tr>", row);
    for (std::size_t cell = page.find("<td", row); cell < row_end; cell = page.find("<td", cell + 1)) {
      const std::size_t text = page.find('>', cell) + 1;
      rows.back().push_back(page.substr(text, page.find("</td>", text) - text));
    }
  }
  return rows;
}

/// A row of report.csv by its columns.
std::map<std::string, std::string> csv_row(const std::string& csv, const std::string& begin) {
  std::istringstream lines(csv);
  std::string head, line;
  std::getline(lines, head);
  while (std::getline(lines, line) && !line.starts_with(begin)) {
  }
  const auto cells = [](const std::string& text) {
    std::vector<std::string> words;
    for (std::size_t at = 0; at <= text.size();) {
      const std::size_t end = std::min(text.find(',', at), text.size());
      words.push_back(text.substr(at, end - at));
      at = end + 1;
    }
    return words;
  };
  const auto names = cells(head), values = cells(line);
  EXPECT_EQ(names.size(), values.size()) << line;
  std::map<std::string, std::string> row;
  for (std::size_t i = 0; i < std::min(names.size(), values.size()); ++i) row[names[i]] = values[i];
  return row;
}

TEST_F(BatchReport, CsvRowsHoldTheirGroupsNumbers) {
  const BatchTable t = table();
  const std::string csv = batch_report_csv(t);
  for (const bool all : {false, true}) {
    const EpisodeGroup& group = all ? t.totals[1] : t.groups[3];
    const EpisodeGroup& reference = all ? t.totals[0] : t.groups[2];
    const std::string head = all ? "all,new,," : "1,new,5,";
    const Quantity& error = *t.find("error_m", "a");
    const SampleSummary s = summarize(values_of(error, group), seeds_of(t, group));
    const PairedValues pairs = paired_values(t, error, reference, group);
    const SampleSummary d = paired_difference(pairs.first, pairs.second, pairs.seeds);
    auto row = csv_row(csv, head + "error_m,a,");
    EXPECT_EQ(row["n"] + " " + row["pairs"], std::to_string(s.n) + " " + std::to_string(d.n));
    for (const auto& [name, value] : {std::pair("mean", s.mean),
                                      {"sd", s.sd},
                                      {"ci_low", s.mean_ci.low},
                                      {"ci_high", s.mean_ci.high},
                                      {"min", s.min},
                                      {"median", s.median},
                                      {"max", s.max},
                                      {"difference", d.mean},
                                      {"difference_ci_low", d.mean_ci.low},
                                      {"difference_ci_high", d.mean_ci.high}}) {
      EXPECT_EQ(row[name], std::isfinite(value) ? shortest(value) : "") << name;
    }
    row = csv_row(csv, head + "outcome = crashed,");
    EXPECT_EQ(row["pairs"], all ? "11" : "5");
    EXPECT_EQ(row["difference"],
              shortest(paired_rate_difference(paired_outcomes(t, "crashed", reference, group)).difference));
    EXPECT_EQ(row["sd"] + row["min"] + row["difference_sd"], "") << "rates have none";
  }
  const auto reference = csv_row(csv, "0,old,0,error_m,a,");
  EXPECT_EQ(reference.at("pairs") + reference.at("difference"), "");
}

/// Table of a batch in which every episode has the metrics returned by metrics(point, variant, seed).
BatchTable made_table(std::size_t points, std::vector<std::string> variants, std::uint64_t seeds,
                      const std::string& report,
                      const std::function<std::vector<MetricRow>(std::size_t, std::size_t, std::uint64_t)>& metrics) {
  const TemporaryDirectory folder;
  ResultStore store(folder.path() / "results.sqlite", ResultStore::Mode::kCreate);
  BatchInfo info;
  info.name = "made";
  info.text = "name: made\nscenario: x\nsweep: {parameters: [{key: k, law: log_uniform, min: 1, max: 9}]}\n" + report;
  info.file = "batch.yaml";
  info.fingerprint = "f";
  info.version = "1";
  info.variants = std::move(variants);
  info.parameters = {"k"};
  store.set_info(info);
  std::uint64_t id = 0;
  for (std::size_t point = 0; point < points; ++point) {
    for (std::uint64_t seed = 0; seed < seeds; ++seed) {
      for (std::size_t v = 0; v < info.variants.size(); ++v) {
        EpisodeRow row;
        row.id = id++;
        row.variant = info.variants[v];
        row.point = point;
        row.seed = seed;
        row.parameters = {std::to_string(point + 1)};
        row.status = "done";
        row.outcome = "done";
        row.simulated_s = 10.0;
        row.flight_wall_s = 2.5;
        row.setup_wall_s = 0.5;
        row.wall_s = 3.0;
        row.built_world = v == 0;
        row.command = "run";
        row.metrics = metrics(point, v, seed);
        store.add(row);
      }
    }
  }
  return read_batch_table(store);
}

std::vector<std::string> labels(const std::vector<const Quantity*>& quantities) {
  std::vector<std::string> names;
  for (const Quantity* q : quantities) names.push_back(q->label());
  return names;
}

// If every point has a single episode, the table has only the row of all points.
TEST(BatchTables, OmitsPointRowsWithSingleEpisodes) {
  const auto metrics = [](std::size_t point, std::size_t, std::uint64_t) {
    return std::vector<MetricRow>{{"error_m", "", static_cast<double>(point), "m", ""}};
  };
  for (const std::uint64_t seeds : {1U, 2U}) {
    const std::string page = batch_report_html(made_table(2, {"base"}, seeds, "", metrics));
    const auto rows = table_after(page, "<h2>Outcomes");
    EXPECT_EQ(rows.size(), seeds == 1 ? 1U : 3U);
    EXPECT_THAT(rows.front().front(), HasSubstr("all points"));
  }
}

TEST(BatchTables, ShowsSixBestExplainedQuantities) {
  // Two points of four seeds. m0 to m7 differ by 1 m between the points; their noise falls from 0.8 m (m0) to 0.1 m
  // (m7), so the share of the variance between the points rises.
  const auto metrics = [](std::size_t point, std::size_t, std::uint64_t seed) {
    std::vector<MetricRow> rows;
    const double noise = seed % 2 == 0 ? 1.0 : -1.0;
    for (int i = 0; i < 8; ++i)
      rows.push_back({"m" + std::to_string(i), "", static_cast<double>(point) + 0.1 * (8 - i) * noise, "m", ""});
    rows.push_back({"same", "", 3.0, "", ""});
    rows.push_back({"only_noise", "", noise, "", ""});
    return rows;
  };
  EXPECT_EQ(labels(informative_quantities(made_table(2, {"v"}, 4, "", metrics))),
            (std::vector<std::string>{"m7", "m6", "m5", "m4", "m3", "m2"}));
  // With a single group, the metrics with the largest variation relative to their mean.
  const auto alone = [](std::size_t, std::size_t, std::uint64_t seed) {
    const auto s = static_cast<double>(seed);
    return std::vector<MetricRow>{{"little", "", 100.0 + s, "m", ""},
                                  {"more", "", 100.0 + 20.0 * s, "m", ""},
                                  {"none", "", 5.0, "m", ""},
                                  {"negative", "", -100.0 - 10.0 * s, "m", ""},
                                  {"about_zero", "", s - 1.5, "m", ""}};
  };
  EXPECT_EQ(labels(informative_quantities(made_table(1, {"v"}, 4, "", alone))),
            (std::vector<std::string>{"about_zero", "more", "negative", "little"}));
}

TEST(BatchTables, NamesSelectRunMeanOrVehicle) {
  const auto metrics = [](std::size_t, std::size_t, std::uint64_t seed) {
    const auto s = static_cast<double>(seed);
    return std::vector<MetricRow>{{"of_run", "", s, "", ""},
                                  {"each", "a", s, "", ""},
                                  {"each", "b", 2 * s, "", ""},
                                  {"each", "c", std::nan(""), "", ""},
                                  {"single", "a", s, "", ""}};
  };
  const auto shown = [&](const std::string& names) {
    return labels(informative_quantities(made_table(1, {"v"}, 3, "report: {metrics: [" + names + "]}\n", metrics)));
  };
  EXPECT_EQ(shown("of_run"), std::vector<std::string>{"of_run"});
  EXPECT_EQ(shown("each"), std::vector<std::string>{"each (mean)"});
  EXPECT_EQ(shown("single"), std::vector<std::string>{"single (a)"}) << "the only one there is";
  EXPECT_EQ(shown("b.each"), std::vector<std::string>{"each (b)"});
  EXPECT_EQ(shown("b.each, of_run, each"), (std::vector<std::string>{"each (b)", "of_run", "each (mean)"}));
  const BatchTable t = made_table(1, {"v"}, 3, "", metrics);
  EXPECT_DOUBLE_EQ(t.find("each", "mean")->values[2], 3.0) << "mean over the vehicles with a measured value";
  EXPECT_EQ(t.find("each", "c"), nullptr);
  EXPECT_EQ(t.find("single", "mean"), nullptr);
  EXPECT_TRUE(t.totals.empty()) << "with a single point";
  EXPECT_EQ(t.name_of(t.groups[0]), "k 1");
}

std::size_t count_of(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (std::size_t at = 0; (at = text.find(part, at)) != std::string::npos; ++at) ++count;
  return count;
}

TEST(BatchPages, TruncatesLongListsWithANotice) {
  const auto metrics = [](std::size_t point, std::size_t, std::uint64_t seed) {
    return std::vector<MetricRow>{{"m", "", static_cast<double>(point) + 0.1 * static_cast<double>(seed), "", ""}};
  };
  const std::string points = "The rest is in report.csv", groups = "The other groups are in report.csv",
                    failures = " more in the database";
  const std::string few = batch_report_html(made_table(3, {"v"}, 2, "", metrics));
  EXPECT_EQ(table_after(few, "<h2>Outcomes").size(), 4U) << "three points, and all together";
  for (const std::string& notice : {points, groups, failures}) EXPECT_THAT(few, Not(HasSubstr(notice)));
  BatchTable large = made_table(400, {"v"}, 2, "", metrics);
  for (std::size_t i = 0; i < 100; ++i) large.episodes[i].status = "failed";
  const std::string many = batch_report_html(large);
  EXPECT_LT(table_after(many, "<h2>Outcomes").size(), 300U);
  EXPECT_LT(table_after(many, "Episodes that are not done: 100").size(), 50U);
  for (const std::string& notice : {points, groups, failures}) EXPECT_THAT(many, HasSubstr(notice));
}

TEST(BatchPages, RanksLowestFirstWhenConfigured) {
  const auto metrics = [](std::size_t, std::size_t, std::uint64_t seed) {
    return std::vector<MetricRow>{{"m", "a", static_cast<double>(seed * 7 % 12), "", ""},
                                  {"n", "", static_cast<double>(seed), "", ""}};
  };
  const auto order = [&](const std::string& report) {
    std::vector<std::string> seeds;
    for (const auto& row : table_after(batch_report_html(made_table(1, {"v"}, 12, report, metrics)), "<h2>Worst"))
      seeds.push_back(row.at(4));
    return seeds;
  };
  EXPECT_EQ(order("report: {worst_by: a.m, worst_is: low}\n"),
            (std::vector<std::string>{"0", "1", "2", "3", "4", "5", "6", "7", "8", "9"}));
  EXPECT_EQ(order("report: {worst_by: m}\n"),
            (std::vector<std::string>{"11", "10", "9", "8", "7", "6", "5", "4", "3", "2"}));
  EXPECT_EQ(order("report: {metrics: [n], worst_is: low}\n").front(), "0");
}

TEST(Html, RoundsToFourDigitsOrInteger) {
  EXPECT_EQ(html::number(0.123456), "0.1235");
  EXPECT_EQ(html::number(9999.4), "9999");
  EXPECT_EQ(html::number(10000.0), "10000");
  EXPECT_EQ(html::number(12345.6), "12346");
  EXPECT_EQ(html::number(-12345.6), "-12346");
  EXPECT_EQ(html::number(9'999'999.0), "9999999");
  EXPECT_EQ(html::number(1e7), "1e+07");
  EXPECT_EQ(html::number(0.0), "0");
  EXPECT_EQ(html::number(std::nan("")), "–");
  EXPECT_EQ(html::interval(1.0, 2.5), "[1, 2.5]");
  EXPECT_EQ(html::interval(1.0, std::nan("")), "–");
  EXPECT_EQ(html::interval(std::nan(""), 1.0), "–");
}

/// Page of a run's folder.
std::string run_report_of(const fs::path& folder) {
  write_run_report(folder);
  return read_whole_file(folder / "report.html");
}

TEST_F(BatchReport, RejectsFoldersWithoutBatchOrRun) {
  EXPECT_THROW(write_batch_report(folder_.path() / "nowhere"), InputError);
  EXPECT_THROW(write_run_report(folder_.path()), InputError);
}

TEST(RunReport, ErrorNamesForeignSummary) {
  const TemporaryDirectory folder;
  std::ofstream(folder.path() / "summary.json") << R"({"scenario": "gap", "metrics": 7, "stage_wall_s": "x"})";
  EXPECT_THAT([&] { write_run_report(folder.path()); },
              ::testing::ThrowsMessage<InputError>(HasSubstr("summary.json: expected the summary of a run")));
}

TEST(RunReport, ShowsMetricsEventsPicturesAndStages) {
  const TemporaryDirectory folder;
  const auto write = [&](const std::string& name, const std::string& text) {
    write_file(folder.path() / name, text, MissingFolders::kMade);
  };
  write(
      "summary.json",
      R"({"scenario":"gap","seed":4,"outcome":"crashed","state_hash":"00ff","simulated_s":2.0,"stage_wall_s":{"physics":0.25,"sensors":0.75},
            "metrics":{"run":{"outcome":"crashed"},"vehicles":{"uav1":{"path_length_m":1.5,"crash_time_s":null}}}})");
  write("trajectories/uav1.tum", "# t_s x_m y_m z_m qx qy qz qw\n0 0 0 2 0 0 0 1\n1 1 0 2 0 0 0 1\n2 3 0 2 0 0 0 1\n");
  write("trajectories/uav1.estimate.tum", "# t_s x_m y_m z_m qx qy qz qw\n0 0 0 2 0 0 0 1\n2 3 0.4 2.3 0 0 0 1\n");
  write("events.jsonl",
        R"({"t_s":1.9,"kind":"crash","vehicle":"uav1","partner":"wall & door","position_m":[1,2,3],"note":""})"
        "\n");
  write("snapshots/top_0001.png", "png");
  const std::string page = run_report_of(folder.path());
  for (const char* expected :
       {"gap, seed 4: crashed", "path_length_m", "1.5", "wall &amp; door", "snapshots/top_0001.png", "physics", "75 %",
        "seen from above", "error of the estimate [m]"}) {
    EXPECT_THAT(page, HasSubstr(expected));
  }
  const auto series = read_time_series(folder.path());
  ASSERT_EQ(series.size(), 1U);
  EXPECT_EQ(series[0].speed_mps[2], 2.0);
  EXPECT_NEAR(series[0].estimate_error_m[2], 0.5, 1e-12);
  // Half-way between the estimates: (1.5, 0.2, 2.15) against (1, 0, 2).
  EXPECT_NEAR(series[0].estimate_error_m[1], std::hypot(0.5, 0.2, 0.15), 1e-12);
}

TEST(RunReport, CountsTimeFromTheRunsStart) {
  const TemporaryDirectory folder;
  std::filesystem::create_directories(folder.path() / "trajectories");
  std::ofstream(folder.path() / "summary.json") << R"({"scenario":"gap","outcome":"done"})";
  std::ofstream(folder.path() / "scenario.yaml") << "tick_s: 0.004\nstart_time_s: 1700000000\n";
  std::ofstream(folder.path() / "trajectories/uav1.tum")
      << "# t_s x_m y_m z_m qx qy qz qw\n1700000000.000000000 0 0 2 0 0 0 1\n1700000008.000000000 4 0 2 0 0 0 1\n";
  std::ofstream(folder.path() / "events.jsonl") << R"({"t_s":1700000002.5,"kind":"capture"})"
                                                << "\n";
  const std::string page = run_report_of(folder.path());
  EXPECT_THAT(page, HasSubstr(">2.5<"));
  EXPECT_THAT(page, ::testing::Not(HasSubstr("10⁹")));
}

TEST(TimeSeries, ComputesErrorsFromCsvAndThins) {
  const TemporaryDirectory folder;
  std::filesystem::create_directories(folder.path() / "csv/uav1");
  std::ofstream file(folder.path() / "csv/uav1/state.csv");
  file << "t_s,x_m,y_m,z_m,vx_mps,vy_mps,vz_mps,clearance_m,est_x_m,est_y_m,est_z_m,ref_x_m,ref_y_m,ref_z_m\n";
  for (int i = 0; i < 1000; ++i) file << i << ",0,0,1,3,4,0," << (i == 0 ? "nan" : "2.5") << ",0,3,5,0,0,2\n";
  file.close();
  const auto series = read_time_series(folder.path(), 100);
  ASSERT_EQ(series.size(), 1U);
  EXPECT_EQ(series[0].t_s.size(), 100U);
  EXPECT_EQ(series[0].t_s[1], 10.0);
  EXPECT_EQ(series[0].speed_mps[7], 5.0);
  EXPECT_EQ(series[0].estimate_error_m[7], 5.0);
  EXPECT_EQ(series[0].tracking_error_m[7], 1.0);
  EXPECT_TRUE(std::isnan(series[0].clearance_m[0]));
  EXPECT_EQ(series[0].clearance_m[7], 2.5);
}

TEST(TimeSeries, ToleratesNonNumbersAndShortLines) {
  const TemporaryDirectory folder;
  std::ofstream(folder.path() / "a.csv") << "t_s,x,word\n1,2,three\n# a comment\n\n4\n5,,6\n7,8,9,10\n1e,2x,inf\n";
  const NumberTable table = read_number_table(folder.path() / "a.csv", ',', 0);
  EXPECT_EQ(table.names, (std::vector<std::string>{"t_s", "x", "word"}));
  ASSERT_EQ(table.columns[0].size(), 5U);
  EXPECT_EQ(table.columns[0][1], 4.0);
  EXPECT_TRUE(std::isnan(table.columns[2][0]));
  EXPECT_TRUE(std::isnan(table.columns[1][1]));
  EXPECT_TRUE(std::isnan(table.columns[1][2]));
  EXPECT_EQ(table.columns[2][2], 6.0);
  EXPECT_EQ(table.columns[2][3], 9.0);
  EXPECT_TRUE(std::isnan(table.columns[0][4]));
  EXPECT_TRUE(std::isnan(table.columns[1][4]));
  std::ofstream(folder.path() / "a.tum") << "#  t_s x_m\n1  2\n 3 4 \n";
  const NumberTable tum = read_number_table(folder.path() / "a.tum", ' ', 0);
  EXPECT_EQ(tum.names, (std::vector<std::string>{"t_s", "x_m"}));
  EXPECT_EQ(tum.columns[1], (std::vector<double>{2.0, 4.0})) << "several blanks are one";
  EXPECT_EQ(tum.find("y_m"), nullptr);
  EXPECT_THROW(read_number_table(folder.path() / "none", ',', 0), std::runtime_error);
}

TEST(TimeSeries, InterpolatesEstimatesWithoutExtrapolating) {
  const TemporaryDirectory folder;
  std::filesystem::create_directories(folder.path() / "trajectories");
  std::ofstream(folder.path() / "trajectories/a.tum")
      << "# t_s x_m y_m z_m\n0 0 0 0\n1 0 3 4\n2 0 3 4\n4 0 3 9\n5 2 5 10\n";
  std::ofstream(folder.path() / "trajectories/a.estimate.tum") << "# t_s x_m y_m z_m\n1 1 3 4\n3 2 4 5\n4.5 2 4 5\n";
  std::ofstream(folder.path() / "trajectories/b.tum") << "# t_s x_m y_m z_m\n0 0 0 0\n";
  std::filesystem::create_directories(folder.path() / "csv/c");
  const auto all = read_time_series(folder.path());
  ASSERT_EQ(all.size(), 2U) << "c has an empty folder and no series";
  EXPECT_EQ(all[0].name, "a");
  ASSERT_EQ(all[0].speed_mps.size(), 5U);
  EXPECT_TRUE(std::isnan(all[0].speed_mps[0]));
  EXPECT_EQ(all[0].speed_mps[1], 5.0);
  EXPECT_EQ(all[0].speed_mps[2], 0.0);
  EXPECT_EQ(all[0].speed_mps[3], 2.5);
  EXPECT_EQ(all[0].speed_mps[4], 3.0);
  const auto& error_m = all[0].estimate_error_m;
  ASSERT_EQ(error_m.size(), 5U);
  EXPECT_TRUE(std::isnan(error_m[0])) << "before the first";
  EXPECT_EQ(error_m[1], 1.0);
  EXPECT_NEAR(error_m[2], std::hypot(1.5, 0.5, 0.5), 1e-12);
  EXPECT_NEAR(error_m[3], std::hypot(2.0, 1.0, -4.0), 1e-12);
  EXPECT_TRUE(std::isnan(error_m[4])) << "after the last";
  EXPECT_TRUE(all[1].estimate_error_m.empty());
  EXPECT_TRUE(all[1].clearance_m.empty());
}

TEST(RunReport, TruncatesLongLists) {
  const TemporaryDirectory folder;
  write_file(folder.path() / "summary.json", R"({"scenario": "x"})");
  std::string events;
  for (int i = 0; i < 1000; ++i) events += "{\"t_s\": " + std::to_string(i) + ", \"kind\": \"k\"}\n";
  write_file(folder.path() / "events.jsonl", events + "[1]\n");
  for (int i = 0; i < 100; ++i)
    write_file(folder.path() / "snapshots" / ("p" + std::to_string(i) + ".png"), "", MissingFolders::kMade);
  write_file(folder.path() / "snapshots/depth.mm.png", "");
  for (int i = 0; i < 13; ++i) {
    write_file(folder.path() / "trajectories" / ("uav" + std::to_string(10 + i) + ".tum"),
               "# t_s x_m y_m z_m\n0 0 0 1\n1 2 0 1\n", MissingFolders::kMade);
  }
  const std::string page = run_report_of(folder.path());
  EXPECT_LT(table_after(page, "<h2>Events: 1000").size(), 500U);
  EXPECT_LT(count_of(page, "<img "), 80U);
  EXPECT_THAT(page, Not(HasSubstr("depth.mm.png")));
  EXPECT_THAT(page, HasSubstr("Only the first 12 vehicles are drawn."));
  EXPECT_THAT(page, Not(HasSubstr("uav22</text>")));
}

TEST(RunReport, ListsStagesAndRadioTraffic) {
  const TemporaryDirectory folder;
  write_file(folder.path() / "summary.json",
             R"({"scenario": "x", "threads": 2, "simulated_s": 4.0, "stage_wall_s": {"a": 0.5, "b": 1.5},
                 "radio": {"topics": [{"topic": "t", "from": "uav1", "messages": 7, "bytes": 90, "rate_hz": 2.5}]},
                 "metrics": {"vehicles": {"u": {"m": 1.25}, "v": {"n": 20000.4}}}})");
  const std::string page = run_report_of(folder.path());
  EXPECT_EQ(table_after(page, "<h2>Wall time of each stage"),
            (std::vector<std::vector<std::string>>{{"a", "0.5", "25 %", "125"}, {"b", "1.5", "75 %", "375"}}));
  EXPECT_EQ(table_after(page, "<h2>Radio"),
            (std::vector<std::vector<std::string>>{{"t", "uav1", "7", "90", "2.5", "–"}}));
  EXPECT_THAT(page, HasSubstr("<td>1.25</td><td>–</td>"));
  EXPECT_THAT(page, HasSubstr(", 2 threads."));
  EXPECT_THAT(page, HasSubstr("No recorder wrote states"));
  write_file(folder.path() / "replay.html", "");
  write_file(folder.path() / "summary.json", R"({"stage_wall_s": {"a": 0}, "detection_over_distance": {}})");
  const std::string bare = run_report_of(folder.path());
  EXPECT_THAT(bare, HasSubstr("The run in three dimensions"));
  EXPECT_EQ(table_after(bare, "<h2>Wall time of each stage"),
            (std::vector<std::vector<std::string>>{{"a", "0", "–", "–"}}));
  for (const char* absent : {"<h2>Radio", "over distance"}) EXPECT_THAT(bare, Not(HasSubstr(absent)));
}

TEST(RunReport, PlotsRecallAndErrorOverDistance) {
  const TemporaryDirectory folder;
  write_file(folder.path() / "summary.json", R"({"detection_over_distance": {
    "a<b": {"tracker": [{"from_m": 0, "to_m": 10, "targets": 8, "recall": 1.0, "recall_visible": 1.0, "error_mean_m": 0.125},
                        {"from_m": 10, "to_m": 20, "targets": 6, "recall": 0.5, "recall_visible": 0.75, "error_mean_m": null}],
            "detector": [{"from_m": 0, "to_m": 10, "targets": 9, "recall": 0.25}]},
    "uav2": {"detector": []}}})");
  const std::string page = run_report_of(folder.path());
  EXPECT_LT(page.find("recall of the detector"), page.find("recall of the tracker"));
  EXPECT_THAT(page, HasSubstr("error of the tracker"));
  EXPECT_THAT(page, Not(HasSubstr("a<b")));
  const auto numbers = table_after(page, "recall of the tracker");
  ASSERT_EQ(numbers.size(), 2U);
  EXPECT_EQ(numbers[0], (std::vector<std::string>{"a&lt;b", "0 to 10", "8", "1", "1", "0.125", "–", "–", "–"}));
  EXPECT_EQ(numbers[1], (std::vector<std::string>{"a&lt;b", "10 to 20", "6", "0.5", "0.75", "–", "–", "–", "–"}));
  write_file(folder.path() / "summary.json", R"({"detection_over_distance": {"a": {"detector": [{"from_m": "x"}]}}})");
  EXPECT_THROW(write_run_report(folder.path()), InputError);
}

TEST(RunReport, RejectsDamagedTables) {
  for (const std::string& content : {std::string(), std::string("# t_s\n1\n2\n"), std::string("# t_s x_m y_m\n1 2 3\n"),
                                     std::string("\0\0\n\xff 1", 6)}) {
    const TemporaryDirectory folder;
    write_file(folder.path() / "summary.json", "{}");
    std::filesystem::create_directories(folder.path() / "trajectories");
    const std::string whole = "# t_s x_m y_m z_m qx qy qz qw\n0 1 2 3 0 0 0 1\n1 1 2 4 0 0 0 1\n";
    for (const auto& [broken, good] : {std::pair{"a.tum", "a.estimate.tum"}, {"a.estimate.tum", "a.tum"}}) {
      write_file(folder.path() / "trajectories" / broken, content);
      write_file(folder.path() / "trajectories" / good, whole);
      EXPECT_THROW(write_run_report(folder.path()), InputError) << broken << ": " << content;
    }
    std::filesystem::create_directories(folder.path() / "csv/a");
    write_file(folder.path() / "csv/a/state.csv", content);
    EXPECT_THROW(write_run_report(folder.path()), InputError) << content;
  }
}

TEST(RunReport, RejectsDeeplyNestedJson) {
  const TemporaryDirectory folder;
  const std::string deep = std::string(100'000, '[') + std::string(100'000, ']');
  write_file(folder.path() / "summary.json", "{\"outcome\": " + deep + "}");
  EXPECT_THROW(write_run_report(folder.path()), InputError);
  write_file(folder.path() / "summary.json", "{}");
  write_file(folder.path() / "events.jsonl", "{\"kind\": " + deep + "}\n");
  write_run_report(folder.path());  // skips lines that are nested too deeply
}

}  // namespace
}  // namespace swiftlet::sim
