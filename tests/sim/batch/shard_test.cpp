// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/batch/shard.hpp"

#include <gtest/gtest.h>

#include <map>

#include "swiftlet/sim/errors.hpp"

namespace swiftlet::sim {
namespace {

Shard shard_in(std::map<std::string, std::string> variables) {
  return shard_of_environment([&](const std::string& name) -> std::optional<std::string> {
    return variables.contains(name) ? std::optional(variables[name]) : std::nullopt;
  });
}

TEST(Shard, IsTypedFromOne) {
  EXPECT_EQ(parse_shard("2/8").index, 1);
  EXPECT_EQ(parse_shard("8/8").count, 8);
  EXPECT_EQ(parse_shard("2/8").str(), "2/8");
  EXPECT_TRUE(parse_shard("1/1").whole());
  for (const char* wrong : {"", "2", "0/8", "9/8", "a/8", "2/8 ", "-1/4", "2/", "/3", "1/99999999999"}) {
    EXPECT_THROW(parse_shard(wrong), InputError) << wrong;
  }
}

TEST(Shard, WithoutAClusterIsTheWhole) { EXPECT_TRUE(shard_in({}).whole()); }

TEST(Shard, ReadsSlurmArrayWithAnyStride) {
  const Shard shard = shard_in({{"SLURM_ARRAY_TASK_ID", "14"},
                                {"SLURM_ARRAY_TASK_COUNT", "4"},
                                {"SLURM_ARRAY_TASK_MIN", "10"},
                                {"SLURM_ARRAY_TASK_MAX", "16"},
                                {"SLURM_PROCID", "0"},
                                {"SLURM_NTASKS", "1"}});
  EXPECT_EQ(shard.index, 2);
  EXPECT_EQ(shard.count, 4);
}

TEST(Shard, RefusesSlurmArrayWithHoles) {
  EXPECT_THROW(shard_in({{"SLURM_ARRAY_TASK_ID", "7"},
                         {"SLURM_ARRAY_TASK_COUNT", "2"},
                         {"SLURM_ARRAY_TASK_MIN", "3"},
                         {"SLURM_ARRAY_TASK_MAX", "8"}}),
               InputError);
  EXPECT_THROW(shard_in({{"SLURM_ARRAY_TASK_ID", "4"},
                         {"SLURM_ARRAY_TASK_COUNT", "3"},
                         {"SLURM_ARRAY_TASK_MIN", "1"},
                         {"SLURM_ARRAY_TASK_MAX", "6"}}),
               InputError);
}

TEST(Shard, RefusesTaskResubmittedAlone) {
  const auto alone = [](const std::string& id) {
    return std::map<std::string, std::string>{{"SLURM_ARRAY_TASK_ID", id},
                                              {"SLURM_ARRAY_TASK_COUNT", "1"},
                                              {"SLURM_ARRAY_TASK_MIN", id},
                                              {"SLURM_ARRAY_TASK_MAX", id}};
  };
  EXPECT_TRUE(shard_in(alone("0")).whole());
  EXPECT_TRUE(shard_in(alone("1")).whole());
  EXPECT_THROW(shard_in(alone("2")), InputError);
  EXPECT_THROW(shard_in(alone("7")), InputError);
}

TEST(Shard, RefusesOrCountsLargeNumbersExactly) {
  const std::string most = "2147483647", least = "-2147483648";
  EXPECT_THROW(shard_in({{"SLURM_ARRAY_TASK_ID", most},
                         {"SLURM_ARRAY_TASK_COUNT", most},
                         {"SLURM_ARRAY_TASK_MIN", least},
                         {"SLURM_ARRAY_TASK_MAX", most}}),
               InputError);
  EXPECT_THROW(shard_in({{"SLURM_ARRAY_TASK_ID", "0"}, {"SLURM_ARRAY_TASK_COUNT", "2147483648"}}), InputError);
  EXPECT_EQ(shard_in({{"SLURM_ARRAY_TASK_ID", most},
                      {"SLURM_ARRAY_TASK_COUNT", "2"},
                      {"SLURM_ARRAY_TASK_MIN", least},
                      {"SLURM_ARRAY_TASK_MAX", most}})
                .str(),
            "2/2");
  // Ranks within an index: 10^7 parts at most, in all.
  EXPECT_THROW(shard_in({{"JOB_COMPLETION_INDEX", "9999999"},
                         {"SWIFTLET_NUM_SHARDS", "10000000"},
                         {"PMI_RANK", "9999999"},
                         {"PMI_SIZE", "10000000"}}),
               InputError);
}

TEST(Shard, OfAtMostTenMillions) {
  EXPECT_EQ(parse_shard("1/10000000").count, 10'000'000);
  EXPECT_THROW(parse_shard("1/10000001"), InputError);
  EXPECT_EQ(shard_in({{"PMI_RANK", "0"}, {"PMI_SIZE", "10000000"}}).count, 10'000'000);
  EXPECT_THROW(shard_in({{"PMI_RANK", "0"}, {"PMI_SIZE", "10000001"}}), InputError);
  EXPECT_THROW(shard_in({{"PMI_RANK", "0"}, {"PMI_SIZE", "0"}}), InputError);
  EXPECT_THROW(shard_in({{"PMI_RANK", "-1"}, {"PMI_SIZE", "3"}}), InputError);
}

TEST(Shard, CountsArrayWithoutBoundsFromZero) {
  EXPECT_EQ(shard_in({{"SLURM_ARRAY_TASK_ID", "2"}, {"SLURM_ARRAY_TASK_COUNT", "4"}}).str(), "3/4");
  EXPECT_EQ(shard_in({{"SLURM_ARRAY_TASK_ID", "0"}, {"SLURM_ARRAY_TASK_COUNT", "1"}}).str(), "1/1");
  EXPECT_EQ(
      shard_in({{"SLURM_ARRAY_TASK_ID", "6"}, {"SLURM_ARRAY_TASK_COUNT", "4"}, {"SLURM_ARRAY_TASK_MIN", "5"}}).str(),
      "2/4");
  EXPECT_THROW(shard_in({{"SLURM_ARRAY_TASK_ID", "4"}, {"SLURM_ARRAY_TASK_COUNT", "4"}}), InputError);
  EXPECT_THROW(shard_in({{"SLURM_ARRAY_TASK_ID", "0"}}), InputError);
  // Equal least and largest task numbers are no array.
  EXPECT_THROW(shard_in({{"SLURM_ARRAY_TASK_ID", "0"},
                         {"SLURM_ARRAY_TASK_COUNT", "3"},
                         {"SLURM_ARRAY_TASK_MIN", "0"},
                         {"SLURM_ARRAY_TASK_MAX", "0"}}),
               InputError);
}

TEST(Shard, StatesItsSource) {
  EXPECT_EQ(parse_shard("2/8").source, "--shard");
  EXPECT_EQ(shard_in({}).source, "");
  EXPECT_EQ(shard_in({{"PMI_RANK", "1"}, {"PMI_SIZE", "2"}}).source, "PMI_RANK");
  EXPECT_EQ(
      shard_in({{"PMI_RANK", "1"}, {"PMI_SIZE", "2"}, {"JOB_COMPLETION_INDEX", "0"}, {"SWIFTLET_NUM_SHARDS", "3"}})
          .source,
      "JOB_COMPLETION_INDEX, PMI_RANK");
  EXPECT_EQ(
      shard_in({{"PMI_RANK", "0"}, {"PMI_SIZE", "1"}, {"JOB_COMPLETION_INDEX", "0"}, {"SWIFTLET_NUM_SHARDS", "3"}})
          .source,
      "JOB_COMPLETION_INDEX");
  EXPECT_TRUE(shard_in({{"SLURM_PROCID", "0"}}).whole()) << "a batch script of one task";
  EXPECT_THROW(shard_in({{"PMI_RANK", "0"}}), InputError);
}

TEST(Shard, MpiRanksTellIt) {
  EXPECT_EQ(shard_in({{"OMPI_COMM_WORLD_RANK", "3"}, {"OMPI_COMM_WORLD_SIZE", "4"}}).index, 3);
  EXPECT_EQ(shard_in({{"PMI_RANK", "1"}, {"PMI_SIZE", "2"}}).count, 2);
  EXPECT_EQ(shard_in({{"SLURM_PROCID", "1"}, {"SLURM_STEP_NUM_TASKS", "5"}}).str(), "2/5");
  EXPECT_THROW(shard_in({{"PMI_RANK", "1"}}), InputError);
  EXPECT_THROW(shard_in({{"PMI_RANK", "one"}, {"PMI_SIZE", "2"}}), InputError);
  EXPECT_THROW(shard_in({{"PMI_RANK", "2"}, {"PMI_SIZE", "2"}}), InputError);
}

TEST(Shard, KubernetesJobNeedsIndexAndNumber) {
  const Shard shard = shard_in({{"JOB_COMPLETION_INDEX", "0"}, {"SWIFTLET_NUM_SHARDS", "3"}});
  EXPECT_EQ(shard.str(), "1/3");
  EXPECT_THROW(shard_in({{"JOB_COMPLETION_INDEX", "0"}}), InputError);
}

TEST(Shard, SubdividesArrayTasksByRank) {
  const std::map<std::string, std::string> array = {{"SLURM_ARRAY_TASK_ID", "1"},
                                                    {"SLURM_ARRAY_TASK_COUNT", "3"},
                                                    {"SLURM_ARRAY_TASK_MIN", "0"},
                                                    {"SLURM_ARRAY_TASK_MAX", "2"}};
  auto with_rank = array;
  with_rank.insert({{"OMPI_COMM_WORLD_RANK", "1"}, {"OMPI_COMM_WORLD_SIZE", "2"}});
  EXPECT_EQ(shard_in(with_rank).str(), "4/6");
}

}  // namespace
}  // namespace swiftlet::sim
