// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/scenario/suggest.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace swiftlet::sim {
namespace {

/// The word suggested for a refused one, or "".
std::string suggestion(const std::string& word, const std::vector<std::string>& candidates) {
  const std::string message = did_you_mean(word, candidates);
  if (message.empty()) return "";
  const std::size_t from = message.find('"') + 1;
  EXPECT_EQ(message, "; did you mean \"" + message.substr(from, message.rfind('"') - from) + "\"?");
  return message.substr(from, message.rfind('"') - from);
}

TEST(DidYouMean, SuggestsTheNearestWord) {
  const struct {
    const char* word;
    std::vector<std::string> candidates;
    const char* expected;
  } cases[] = {
      {"guidence", {"guidance", "tracking"}, "guidance"},  // a wrong letter
      {"guidnce", {"guidance", "tracking"}, "guidance"},   // one missing
      {"guuidance", {"guidance", "tracking"}, "guidance"},
      {"gudiance", {"guidance", "tracking"}, "guidance"},  // two that changed places
      {"mpas", {"maps"}, "maps"},
      {"GUIDANCE", {"guidance", "tracking"}, "guidance"},
      {"sky", {"guidance", "tracking"}, ""},
      {"", {"guidance"}, ""},
      {"guidance", {}, ""},
      {"guidance", {"guidance"}, ""},  // the word itself was refused
      {"guidance", {"guidance", "guidances"}, "guidances"},
      {"abxdxf", {"abcdef"}, "abcdef"},  // long words may have more mistakes
      {"axxdxf", {"abcdef"}, ""},
      {"ax", {"ab"}, "ab"},
      {"x", {"a"}, ""},
      {"trackers", {"trackage", "tracker", "trackerz"}, "tracker"},  // the first of the nearest
      {"rate", {"color", "rate_hz"}, "rate_hz"},                     // another unit
      {"length_inch", {"color", "length_m"}, "length_m"},
      {"spedd_kmph", {"color", "speed_mps"}, "speed_mps"},
      {"spedd", {"speed_limit"}, ""},
      {"spedd", {"speed_mps", "spend"}, "spend"},
      {"abc.yaml", {"xyz.yaml"}, ""},  // extensions do not count
      {"forst.yaml", {"forest.yaml"}, "forest.yaml"},
  };
  for (const auto& c : cases) EXPECT_EQ(suggestion(c.word, c.candidates), c.expected) << c.word;
  EXPECT_EQ(suggestion(std::string(10'000, 'a'), {std::string(10'001, 'a')}), "") << "too long to compare";
}

TEST(OneOf, ListsItsWordsUpToSixteen) {
  EXPECT_EQ(one_of({}), "none");
  EXPECT_EQ(one_of({"a"}), "\"a\"");
  EXPECT_EQ(one_of({"a", "b", "c"}), "one of \"a\", \"b\", \"c\"");
  EXPECT_TRUE(one_of(std::vector<std::string>(17, "x")).ends_with("\"x\", ..."));
}

}  // namespace
}  // namespace swiftlet::sim
