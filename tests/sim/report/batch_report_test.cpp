// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/report/batch_report.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <iterator>
#include <sstream>

#include "sim/report/time_series.hpp"
#include "swiftlet/sim/errors.hpp"
#include "swiftlet/sim/io/files.hpp"
#include "swiftlet/sim/report/run_report.hpp"
#include "tests/support/temporary_directory.hpp"

namespace swiftlet::sim {
namespace {

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
    // The seed's own luck, 1 m for the wind, 0.5 m less and a little noise for the new variant.
    const double luck = 10.0 * static_cast<double>(seed);
    const double noise = variant == 1 ? 0.01 * (seed % 2 == 0 ? 1.0 : -1.0) : 0.0;
    row.metrics = {
        {"error_m", "a", luck + static_cast<double>(point) - 0.5 * static_cast<double>(variant) + noise, "m", ""},
        {"error_m", "b", luck, "m", ""},
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

TEST_F(BatchReport, AllPointsTogetherArePairedByPointAndSeed) {
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

TEST_F(BatchReport, ThePageTellsItAll) {
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

TEST_F(BatchReport, TheTenWorstEpisodesComeFirstToLast) {
  const std::string page = batch_report_html(table());
  const std::size_t begin = page.find("Worst episodes");
  std::string section = page.substr(begin, page.find("</table>", begin) - begin);
  std::vector<int> episodes;
  // The first cell of a row is the episode's number.
  for (std::size_t at = 0; (at = section.find("<tr><td", at)) != std::string::npos; ++at) {
    episodes.push_back(std::stoi(section.substr(section.find('>', at + 4) + 1)));
  }
  // 23 was not done. The seed counts 10 m, the wind 1 m, the old variant 0.5 m.
  EXPECT_EQ(episodes, (std::vector<int>{22, 10, 11, 20, 21, 8, 9, 18, 19, 6}));
}

TEST_F(BatchReport, APictureOfPointsNamesEachOfThem) {
  const std::string page = batch_report_html(table());
  int figures = 0;
  for (std::size_t at = 0; (at = page.find("<figure>", at)) != std::string::npos; ++at) {
    const std::string figure = page.substr(at, page.find("</figure>", at) - at);
    ++figures;
    EXPECT_EQ(figure.find("wind_mps 0") != std::string::npos, figure.find("wind_mps 5") != std::string::npos);
  }
  EXPECT_GE(figures, 2);
}

// Points of one episode each are a cloud that only the totals sum up; points of two are told one by one.
TEST(BatchReportOfFew, PointsOfTwoEpisodesAreShownOneByOneAndPointsOfOneTogether) {
  for (const std::uint64_t seeds : {1U, 2U}) {
    const TemporaryDirectory folder;
    {
      ResultStore store(folder.path() / "results.sqlite", ResultStore::Mode::kCreate);
      BatchInfo info;
      info.name = "few";
      info.text =
          "name: few\nscenario: x\nsweep: {parameters: [{key: wind, name: wind_mps, values: [0.1234567, 5]}]}\n";
      info.file = "batch.yaml";
      info.fingerprint = "f00d";
      info.version = "0.1.0";
      info.num_episodes = 2 * seeds;
      info.variants = {"base"};
      info.parameters = {"wind_mps"};
      store.set_info(info);
      for (std::uint64_t id = 0; id < 2 * seeds; ++id) {
        EpisodeRow row;
        row.id = id;
        row.variant = "base";
        row.point = id / seeds;
        row.seed = id % seeds;
        row.parameters = {row.point == 0 ? "0.1234567" : "5"};
        row.status = "done";
        row.outcome = "done";
        row.metrics = {{"error_m", "", static_cast<double>(id), "m", ""}};
        store.add(row);
      }
    }
    const BatchTable table = read_batch_table(ResultStore(folder.path() / "results.sqlite", ResultStore::Mode::kRead));
    const std::string page = batch_report_html(table);
    const std::size_t begin = page.find("Outcomes");
    ASSERT_NE(begin, std::string::npos);
    const std::string outcomes = page.substr(begin, page.find("</table>", begin) - begin);
    EXPECT_THAT(outcomes, HasSubstr("all points"));
    EXPECT_EQ(outcomes.find("wind_mps 5") != std::string::npos, seeds == 2);
    // Swept values are shown with four digits.
    EXPECT_EQ(table.point_name(table.groups[0]), "wind_mps 0.1235");
  }
}

TEST_F(BatchReport, TheCsvHasEveryGroupAndQuantity) {
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

TEST_F(BatchReport, OnlyABatchHasOne) {
  EXPECT_THROW(write_batch_report(folder_.path() / "nowhere"), InputError);
  EXPECT_THROW(write_run_report(folder_.path()), InputError);
}

TEST(RunReport, ASummaryOfSomethingElseIsRefusedWithItsName) {
  const TemporaryDirectory folder;
  std::ofstream(folder.path() / "summary.json") << R"({"scenario": "gap", "metrics": 7, "stage_wall_s": "x"})";
  EXPECT_THAT([&] { write_run_report(folder.path()); },
              ::testing::ThrowsMessage<InputError>(HasSubstr("summary.json: expected the summary of a run")));
}

TEST(RunReport, ShowsMetricsFlightEventsPicturesAndStages) {
  const TemporaryDirectory folder;
  const auto write = [&](const std::string& name, const std::string& text) {
    std::filesystem::create_directories((folder.path() / name).parent_path());
    std::ofstream(folder.path() / name) << text;
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
  ASSERT_EQ(write_run_report(folder.path()).size(), 1U);
  std::ifstream file(folder.path() / "report.html");
  const std::string page((std::istreambuf_iterator<char>(file)), {});
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

TEST(TimeSeries, CsvStatesGiveErrorsAndAreThinned) {
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

TEST(RunReport, DamagedTablesAreRefusedByTheirName) {
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

TEST(RunReport, JsonThatIsNestedWithoutEndIsRefused) {
  const TemporaryDirectory folder;
  const std::string deep = std::string(100'000, '[') + std::string(100'000, ']');
  write_file(folder.path() / "summary.json", "{\"outcome\": " + deep + "}");
  EXPECT_THROW(write_run_report(folder.path()), InputError);
  write_file(folder.path() / "summary.json", "{}");
  write_file(folder.path() / "events.jsonl", "{\"kind\": " + deep + "}\n");
  write_run_report(folder.path());  // such a line is no event
}

}  // namespace
}  // namespace swiftlet::sim
