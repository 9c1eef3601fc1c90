// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/batch/shard.hpp"

#include <gtest/gtest.h>

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "swiftlet/sim/errors/errors.hpp"

namespace swiftlet::sim {
namespace {

using Variables = std::map<std::string, std::string>;

Shard shard_in(Variables variables) {
  return shard_of_environment([&](const std::string& name) -> std::optional<std::string> {
    return variables.contains(name) ? std::optional(variables[name]) : std::nullopt;
  });
}

Variables slurm_array(const std::string& id, const std::string& count, const std::string& min, const std::string& max) {
  return {{"SLURM_ARRAY_TASK_ID", id},
          {"SLURM_ARRAY_TASK_COUNT", count},
          {"SLURM_ARRAY_TASK_MIN", min},
          {"SLURM_ARRAY_TASK_MAX", max}};
}

TEST(Shard, IsTypedFromOne) {
  EXPECT_EQ(parse_shard("2/8").index, 1);
  EXPECT_EQ(parse_shard("8/8").count, 8);
  EXPECT_EQ(parse_shard("2/8").str(), "2/8");
  EXPECT_TRUE(parse_shard("1/1").whole());
  for (const char* wrong : {"", "2", "0/8", "9/8", "a/8", "2/8 ", "-1/4", "2/", "/3", "1/10000001", "1/99999999999"}) {
    EXPECT_THROW(parse_shard(wrong), InputError) << wrong;
  }
}

TEST(Shard, FollowsTheCluster) {
  const std::string most = "2147483647", least = "-2147483648";
  Variables array_of_ranks = slurm_array("1", "3", "0", "2");
  array_of_ranks.insert({{"OMPI_COMM_WORLD_RANK", "1"}, {"OMPI_COMM_WORLD_SIZE", "2"}});
  const std::pair<Variables, const char*> environments[] = {
      {{}, "1/1"},
      {slurm_array("14", "4", "10", "16"), "3/4"},  // a stride of two
      {slurm_array("0", "1", "0", "0"), "1/1"},
      {slurm_array(most, "2", least, most), "2/2"},
      {{{"SLURM_ARRAY_TASK_ID", "2"}, {"SLURM_ARRAY_TASK_COUNT", "4"}}, "3/4"},
      {{{"SLURM_PROCID", "0"}}, "1/1"},  // a batch script of one task
      {{{"SLURM_PROCID", "1"}, {"SLURM_STEP_NUM_TASKS", "5"}}, "2/5"},
      {{{"OMPI_COMM_WORLD_RANK", "3"}, {"OMPI_COMM_WORLD_SIZE", "4"}}, "4/4"},
      {{{"PMI_RANK", "1"}, {"PMI_SIZE", "2"}}, "2/2"},
      {{{"JOB_COMPLETION_INDEX", "0"}, {"SWIFTLET_NUM_SHARDS", "3"}}, "1/3"},
      {array_of_ranks, "4/6"},  // ranks divide the share of an array task
  };
  for (const auto& [variables, expected] : environments) EXPECT_EQ(shard_in(variables).str(), expected);
}

TEST(Shard, RefusesContradictoryClusters) {
  const std::string most = "2147483647", least = "-2147483648";
  const std::vector<Variables> environments = {
      slurm_array("7", "2", "3", "8"),  // an array with holes
      slurm_array("4", "3", "1", "6"),
      slurm_array("0", "3", "0", "0"),
      slurm_array("7", "1", "7", "7"),  // resubmitted alone
      slurm_array(most, most, least, most),
      {{"SLURM_ARRAY_TASK_ID", "0"}, {"SLURM_ARRAY_TASK_COUNT", "2147483648"}},
      {{"SLURM_ARRAY_TASK_ID", "4"}, {"SLURM_ARRAY_TASK_COUNT", "4"}},
      {{"SLURM_ARRAY_TASK_ID", "0"}},
      {{"PMI_RANK", "1"}},
      {{"PMI_RANK", "one"}, {"PMI_SIZE", "2"}},
      {{"PMI_RANK", "2"}, {"PMI_SIZE", "2"}},
      {{"PMI_RANK", "-1"}, {"PMI_SIZE", "3"}},
      {{"PMI_RANK", "0"}, {"PMI_SIZE", "10000001"}},
      {{"JOB_COMPLETION_INDEX", "0"}},
      {{"JOB_COMPLETION_INDEX", "9999999"},
       {"SWIFTLET_NUM_SHARDS", "10000000"},
       {"PMI_RANK", "9999999"},
       {"PMI_SIZE", "10000000"}},
  };
  for (std::size_t i = 0; i < environments.size(); ++i) EXPECT_THROW(shard_in(environments[i]), InputError) << i;
}

TEST(Shard, StatesItsSource) {
  EXPECT_EQ(parse_shard("2/8").source, "--shard");
  EXPECT_EQ(shard_in({}).source, "");
  EXPECT_EQ(shard_in({{"PMI_RANK", "1"}, {"PMI_SIZE", "2"}}).source, "PMI_RANK");
  EXPECT_EQ(
      shard_in({{"PMI_RANK", "1"}, {"PMI_SIZE", "2"}, {"JOB_COMPLETION_INDEX", "0"}, {"SWIFTLET_NUM_SHARDS", "3"}})
          .source,
      "JOB_COMPLETION_INDEX, PMI_RANK");
}

}  // namespace
}  // namespace swiftlet::sim
