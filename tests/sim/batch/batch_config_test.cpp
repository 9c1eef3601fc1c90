// SPDX-License-Identifier: BSD-3-Clause
// Contents of a batch file, on both sides of every bound, and the resources requested from a cluster.
#include "swiftlet/sim/batch/batch_config.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>

#include "sim/batch/change_places.hpp"
#include "sim/batch/difference.hpp"
#include "swiftlet/sim/batch/slurm.hpp"
#include "swiftlet/sim/errors/errors.hpp"
#include "swiftlet/sim/scenario/document.hpp"
#include "tests/sim/batch/batch_support.hpp"
#include "tests/support/config_checks.hpp"

namespace swiftlet::sim {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::StartsWith;
using Law = ParameterConfig::Law;

template <class Config>
std::vector<std::string> problems_in(Config config) {
  return swiftlet::test::ConfigChecks(config).problems();
}
bool is_fine(const auto& config) { return problems_in(config).empty(); }

BatchConfig batch() {
  BatchConfig config;
  config.scenario = "hover";
  return config;
}

TEST(BatchConfig, NamesAreWords) {
  const auto takes = [](const std::string& name) {
    BatchConfig config = batch();
    config.name = name;
    return is_fine(config);
  };
  for (const char* name : {"a", "azAZ09_-.", "9"}) EXPECT_TRUE(takes(name)) << name;
  for (const char* name : {"", "a b", "/", ":", "\xC3\xA9"}) EXPECT_FALSE(takes(name)) << name;
  EXPECT_TRUE(takes(std::string(64, 'x')));
  EXPECT_FALSE(takes(std::string(65, 'x')));
}

TEST(BatchConfig, VariantsHaveUniqueNamesAndScenarios) {
  BatchConfig config = batch();
  config.variants.resize(2);
  config.variants[0].name = "a";
  config.variants[1].name = "b";
  EXPECT_TRUE(is_fine(config));
  config.scenario.clear();
  EXPECT_FALSE(is_fine(config));
  config.variants[0].scenario = "x";
  EXPECT_FALSE(is_fine(config)) << "the other has none";
  config.variants[1].scenario = "y";
  EXPECT_TRUE(is_fine(config));
  config.variants[1].name = "a";
  EXPECT_THAT(problems_in(config), ::testing::ElementsAre(StartsWith("variants[1].name: expected a name that is not")));
  config.variants[1].name = "a b";
  EXPECT_THAT(problems_in(config), ::testing::ElementsAre(StartsWith("variants[1].name: expected a word")));
  config = batch();
  config.scenario.clear();
  EXPECT_FALSE(is_fine(config)) << "nothing to fly";
}

ParameterConfig parameter(Law law, double min, double max) {
  ParameterConfig p;
  p.key = "world.stems_per_ha";
  p.law = law;
  p.min = min;
  p.max = max;
  if (law == Law::kValues) p.values = {"1"};
  return p;
}

TEST(BatchConfig, ValidatesTheBoundsOfEachLaw) {
  EXPECT_TRUE(is_fine(parameter(Law::kValues, 5, 1))) << "its bounds do not matter";
  EXPECT_TRUE(is_fine(parameter(Law::kNormal, 5, 1)));
  for (const Law law : {Law::kUniform, Law::kLogUniform, Law::kInteger}) {
    EXPECT_TRUE(is_fine(parameter(law, 1, 2)));
    EXPECT_FALSE(is_fine(parameter(law, 2, 1)));
    EXPECT_EQ(is_fine(parameter(law, 2, 2)), law == Law::kInteger);
  }
  EXPECT_FALSE(is_fine(parameter(Law::kLogUniform, 0, 1)));
  EXPECT_FALSE(is_fine(parameter(Law::kLogUniform, -1, 1)));
  EXPECT_TRUE(is_fine(parameter(Law::kUniform, 0, 1)));
  EXPECT_TRUE(is_fine(parameter(Law::kUniform, -1, 1)));
  ParameterConfig p = parameter(Law::kValues, 0, 1);
  p.values.clear();
  EXPECT_THAT(problems_in(p), ::testing::ElementsAre("values: expected at least one value"));
  p = parameter(Law::kUniform, 0, 1);
  p.values = {"3"};
  EXPECT_THAT(problems_in(p), ::testing::ElementsAre(HasSubstr("no values with law \"uniform\"")));
  p = parameter(Law::kUniform, 0, 1);
  p.key.clear();
  EXPECT_THAT(problems_in(p), ::testing::ElementsAre("key: expected the key that is swept"));
}

TEST(BatchConfig, SamplesNormalLawsWithDistinctColumns) {
  for (const auto method : {SweepConfig::Method::kGrid, SweepConfig::Method::kList,
                            SweepConfig::Method::kLatinHypercube, SweepConfig::Method::kRandom}) {
    SweepConfig sweep;
    sweep.method = method;
    sweep.parameters = {parameter(Law::kUniform, 0, 1), parameter(Law::kNormal, 0, 1)};
    sweep.parameters[0].name = "a";
    sweep.parameters[1].name = "b";
    const bool sampled = method == SweepConfig::Method::kLatinHypercube || method == SweepConfig::Method::kRandom;
    EXPECT_EQ(is_fine(sweep), sampled);
    sweep.parameters[1] = parameter(Law::kUniform, 0, 1);
    sweep.parameters[1].name = "a";
    EXPECT_THAT(problems_in(sweep), ::testing::ElementsAre(HasSubstr("parameters[1].name: expected a name")));
  }
}

TEST(BatchConfig, SeedsAreIntegersADatabaseHolds) {
  for (const char* seed : {"0", "7", "9223372036854775807"}) {
    SeedsConfig seeds;
    seeds.list = {"1", seed};
    EXPECT_TRUE(is_fine(seeds)) << seed;
  }
  for (const char* seed : {"", "-1", "9223372036854775808", "1.0", " 1", "x"}) {
    SeedsConfig seeds;
    seeds.list = {"1", seed};
    EXPECT_THAT(problems_in(seeds), ::testing::ElementsAre(StartsWith("list[1]: "))) << seed;
  }
}

TEST(BatchConfig, RefusesTextThatBreaksJobScripts) {
  SlurmConfig slurm;
  EXPECT_TRUE(is_fine(slurm)) << "empty names are the cluster's defaults";
  slurm.partition = "a,b-1";
  slurm.account = "c.d_e";
  slurm.options = {"--constraint=avx2", "--b \xC3\xA4"};
  EXPECT_TRUE(is_fine(slurm));
  for (const char c : {'\n', '\x1F', '\x7F', '\0'}) {
    slurm.options = {"--a", std::string("--b") + c};
    EXPECT_THAT(problems_in(slurm), ::testing::ElementsAre(StartsWith("options[1]: ")));
  }
  slurm.options = {"echo"};
  EXPECT_FALSE(is_fine(slurm));
  slurm.options.clear();
  for (std::string* name : {&slurm.partition, &slurm.account}) {
    const std::string before = std::exchange(*name, "a;b");
    EXPECT_FALSE(is_fine(slurm));
    *name = before;
  }
}

TEST(BatchConfig, ReportRefusesUnknownMetrics) {
  const BatchFolder folder;
  EXPECT_NO_THROW(folder.plan("report: {metrics: [path_length_m, a.path_length_m], worst_by: path_length_m}\n"));
  EXPECT_NO_THROW(folder.plan("report: {worst_by: a.path_length_m}\n"));
  try {
    folder.plan("report: {metrics: [path_length_m, path_lenght_m]}\n");
    ADD_FAILURE();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("report.metrics[1]: expected a metric"));
    EXPECT_THAT(error.what(), HasSubstr("did you mean \"path_length_m\"?"));
  }
  EXPECT_THROW(folder.plan("report: {metrics: [path_lenght_m, path_length_m]}\n"), InputError);
  EXPECT_THROW(folder.plan("report: {worst_by: uav1.path_lenght_m}\n"), InputError);
}

// --- a cluster ---

std::string line_of(const std::string& script, const std::string& option) {
  const std::size_t at = script.find("#SBATCH --" + option + "=");
  if (at == std::string::npos) return "";
  const std::size_t begin = script.find('=', at) + 1;
  return script.substr(begin, script.find('\n', begin) - begin);
}

TEST(Slurm, CreatesTheTasksThatEpisodesNeed) {
  const BatchFolder folder;
  for (const auto& [episodes, per_task, cpus] :
       {std::tuple(1, 0, 1), {21, 0, 1}, {100, 0, 2}, {100, 7, 4}, {20'021, 0, 1}, {5000, 1, 1}}) {
    const BatchPlan plan = folder.plan("seeds: {count: " + std::to_string(episodes) + "}\nslurm: {episodes_per_task: " +
                                       std::to_string(per_task) + ", cpus_per_task: " + std::to_string(cpus) + "}\n");
    const SlurmScripts job = make_slurm_scripts(plan, "out", "/bin/swiftlet");
    EXPECT_LE(job.num_tasks, 1000) << "a cluster's usual bound";
    EXPECT_EQ(job.episodes_per_task, (episodes + job.num_tasks - 1) / job.num_tasks) << "equal shares";
    if (per_task > 0 && episodes < 1000 * per_task) EXPECT_EQ(job.episodes_per_task, per_task);
    EXPECT_EQ(line_of(job.array, "array"), "1-" + std::to_string(job.num_tasks));
    EXPECT_EQ(line_of(job.array, "cpus-per-task"), std::to_string(cpus));
    EXPECT_THAT(job.array, HasSubstr("/" + std::to_string(job.num_tasks) + "\" --jobs " + std::to_string(cpus)));
  }
}

TEST(Slurm, TaskTimeCoversItsEpisodesMaximum) {
  const BatchFolder folder;
  const auto minutes = [&](const std::string& text) {
    const SlurmScripts job = make_slurm_scripts(folder.plan("seeds: {count: 25}\n" + text), "out", "/bin/swiftlet");
    EXPECT_EQ(line_of(job.array, "time"), std::to_string(job.time_limit_min));
    return job.time_limit_min;
  };
  const auto expect_margin = [](int limit_min, double least_min) {
    EXPECT_GE(limit_min, least_min);
    EXPECT_LE(limit_min, least_min + 10.0) << "some minutes to start";
  };
  expect_margin(minutes("timeout_s: 61\nslurm: {episodes_per_task: 25}\n"), 25 * 61 / 60.0);
  expect_margin(minutes("timeout_s: 60\nslurm: {episodes_per_task: 25, cpus_per_task: 4}\n"), 7);
  EXPECT_GE(minutes("timeout_s: 0\n"), 60) << "without a time-out";
  EXPECT_EQ(minutes("timeout_s: 60\nslurm: {time_limit_min: 90.2}\n"), 91) << "as asked for";
}

TEST(Slurm, ScriptHoldsOnlyRequestedOptions) {
  const BatchFolder folder;
  const auto array = [&](const std::string& text) {
    return make_slurm_scripts(folder.plan("seeds: {count: 25}\n" + text), "out", "/bin/swiftlet").array;
  };
  EXPECT_EQ(line_of(array(""), "partition"), "");
  EXPECT_EQ(line_of(array(""), "account"), "");
  EXPECT_EQ(line_of(array("slurm: {partition: p, account: a}\n"), "partition"), "p");
  EXPECT_EQ(line_of(array("slurm: {partition: p, account: a}\n"), "account"), "a");
  EXPECT_EQ(line_of(array("slurm: {max_running_tasks: 1}\n"), "array"), "1-2%1");
  EXPECT_EQ(line_of(array("slurm: {memory_per_cpu_mb: 1000.5}\n"), "mem-per-cpu"), "1001M");
  // A limit of the batch's own is kept where it is below nine tenths of the share.
  EXPECT_THAT(array("slurm: {memory_per_cpu_mb: 1000}\n"), HasSubstr("--memory-limit 900 &"));
  EXPECT_THAT(array("memory_limit_mb: 899\nslurm: {memory_per_cpu_mb: 1000}\n"),
              ::testing::Not(HasSubstr("--memory-limit")));
  const SlurmScripts job =
      make_slurm_scripts(folder.plan("slurm: {account: a}\n"), "some where", "/opt/my dir/swiftlet");
  EXPECT_THAT(job.merge, StartsWith("#!/bin/bash\n#SBATCH --job-name=test-merge\n#SBATCH --account=a\n"));
  EXPECT_THAT(job.merge, HasSubstr("'/opt/my dir/swiftlet' batch merge --out "));
  EXPECT_THAT(job.array, HasSubstr("some where/slurm/%A_%a.log'"));
  EXPECT_THROW(make_slurm_scripts(folder.plan(""), "out\nid", "/bin/x"), InputError);
}

/// An sbatch of our own in the path.
TEST(Slurm, SubmitsJobsSequentially) {
  const BatchFolder folder;
  const std::string path = std::getenv("PATH");
  const auto with_sbatch = [&](const std::string& script) {
    folder.write("sbatch", "#!/bin/sh\n" + script);
    std::filesystem::permissions(folder.path("sbatch"), std::filesystem::perms::owner_all);
    setenv("PATH", (folder.path().string() + ":" + path).c_str(), 1);
  };
  const SlurmFiles files =
      write_slurm_scripts(make_slurm_scripts(folder.plan(""), folder.path("out"), "/bin/swiftlet"), folder.path("out"));
  with_sbatch("echo \"$@\" >> " + folder.path("calls").string() + "\necho '41;cluster'\n");
  const SlurmJobs jobs = submit(files);
  EXPECT_EQ(jobs.array, "41");
  EXPECT_EQ(jobs.merge, "41");
  std::ifstream in(folder.path("calls"));
  std::string first, second;
  std::getline(in, first);
  std::getline(in, second);
  EXPECT_EQ(first, "--parsable " + files.array.string());
  EXPECT_EQ(second, "--parsable --dependency=afterany:41 " + files.merge.string());
  with_sbatch("echo no such partition >&2\nexit 3\n");
  EXPECT_THAT([&] { submit(files); },
              ::testing::ThrowsMessage<std::runtime_error>(HasSubstr("sbatch ended with status 3: no such partition")));
  with_sbatch("kill -9 $$\n");
  EXPECT_THROW(submit(files), std::runtime_error);
  setenv("PATH", path.c_str(), 1);
}

// --- texts about changes ---

TEST(Difference, IsTheFirstDifferingValue) {
  const char* const cases[][3] = {
      {"{a: 1, b: [1, {c: x}]}", "{b: [1, {c: x}], a: 1}", ""},  // the order of keys means nothing
      {"{a: 1, b: 2}", "{a: 1, b: 3}", "set.b: \"2\" then, \"3\" now"},
      {"{a: 1, b: 2}", "{a: 1}", "set.b: \"2\" then, nothing now"},
      {"{a: [1]}", "{a: [1, 2]}", "set.a[1]: nothing then, \"2\" now"},
      {"{a: [1, {b: 2}]}", "{a: [1, {b: 3}]}", "set.a[1].b: \"2\" then, \"3\" now"},
      {"{a: [1]}", "{a: {b: 1}}", "set.a: a list of 1 value then, a map now"},
      {"{a: ~}", "{a: ~}", ""},
  };
  for (const auto& [then, now, difference] : cases) {
    EXPECT_EQ(first_difference(parse_document(then, {"a", "."}), parse_document(now, {"b", "."}), "set"), difference);
  }
}

TEST(ChangePlaces, LocatesEachChangeInMultilineMessage) {
  const Node batch = parse_document(
      "set: {a: 1}\nvariants:\n  - name: x\n  - {name: y, set: {b: 2}}\n"
      "sweep: {parameters: [{values: [1]}, {key: c, values: [1]}]}\n",
      {"batch.yaml", "."});
  EXPECT_EQ(
      with_places_of_changes("--set a: wrong\n--set b: bad: worse\n--set c: no\n--set d: where\nx.yaml:1: a: fine\n"
                             "--set a",
                             batch),
      "batch.yaml:1:7: set.a: wrong\nbatch.yaml:4:21: variants[1].set.b: bad: worse\n"
      "batch.yaml:5:43: sweep.parameters[1].key: c: no\n--set d: where\nx.yaml:1: a: fine\n--set a");
  EXPECT_EQ(with_places_of_changes("--set a: wrong", parse_document("name: x", {"b", "."})), "--set a: wrong");
}

}  // namespace
}  // namespace swiftlet::sim
