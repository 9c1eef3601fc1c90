// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/scenario/suggest.hpp"

#include <gtest/gtest.h>

namespace swiftlet::sim {
namespace {

std::string meant(const std::string& word, const std::vector<std::string>& candidates) {
  const std::string told = did_you_mean(word, candidates);
  if (told.empty()) return "";
  const std::size_t from = told.find('"') + 1;
  EXPECT_EQ(told, "; did you mean \"" + told.substr(from, told.rfind('"') - from) + "\"?");
  return told.substr(from, told.rfind('"') - from);
}

TEST(DidYouMean, CorrectsACommonSingleMistake) {
  const std::vector<std::string> words = {"guidance", "tracking", "detector"};
  EXPECT_EQ(meant("guidence", words), "guidance") << "a wrong letter";
  EXPECT_EQ(meant("guidnce", words), "guidance") << "one that is missing";
  EXPECT_EQ(meant("guuidance", words), "guidance") << "one too many";
  EXPECT_EQ(meant("gudiance", words), "guidance") << "two that changed places";
  EXPECT_EQ(meant("GUIDANCE", words), "guidance") << "in capitals";
  EXPECT_EQ(meant("detecotr", words), "detector");
  EXPECT_EQ(meant("mpas", {"maps"}), "maps") << "changed places are one mistake, of which four letters may have one";
  EXPECT_EQ(meant("sky", words), "");
  EXPECT_EQ(meant("", words), "");
  EXPECT_EQ(meant("guidance", {}), "");
  EXPECT_EQ(meant("guidance", words), "") << "the word itself was refused";
  EXPECT_EQ(meant("guidance", {"guidance", "guidances"}), "guidances");
  EXPECT_EQ(meant("rate_hz", {"rate_hz"}), "");
}

// A third of the letters may be wrong, one at least, but never all.
TEST(DidYouMean, LongWordsMayHaveMoreMistakes) {
  EXPECT_EQ(meant("abcdxf", {"abcdef"}), "abcdef");
  EXPECT_EQ(meant("abxdxf", {"abcdef"}), "abcdef");
  EXPECT_EQ(meant("axxdxf", {"abcdef"}), "");
  EXPECT_EQ(meant("ax", {"ab"}), "ab");
  EXPECT_EQ(meant("xx", {"ab"}), "");
  EXPECT_EQ(meant("x", {"a"}), "") << "all of it";
  EXPECT_EQ(meant("abxxxxghi", {"abcdefghi"}), "");
  EXPECT_EQ(meant("abcxxxghi", {"abcdefghi"}), "abcdefghi");
}

TEST(DidYouMean, SuggestsTheFirstOfTheNearest) {
  EXPECT_EQ(meant("trackers", {"trackage", "tracker", "trackerz"}), "tracker");
  EXPECT_EQ(meant("bat", {"cat", "hat"}), "cat");
}

TEST(DidYouMean, CountsNeighborSwapsAsOneMistake) {
  EXPECT_EQ(meant("ba", {"ab"}), "ab");
  EXPECT_EQ(meant("cba", {"abc"}), "") << "two mistakes";
}

TEST(DidYouMean, FindsTheWordWithAnotherUnit) {
  EXPECT_EQ(meant("rate", {"color", "rate_hz"}), "rate_hz");
  EXPECT_EQ(meant("length_inch", {"color", "length_m"}), "length_m");
  EXPECT_EQ(meant("rate_hz", {"color", "rates"}), "");
}

TEST(DidYouMean, FindsMisspeltWordsWithAnotherUnit) {
  EXPECT_EQ(meant("spedd", {"color", "speed_mps"}), "speed_mps");
  EXPECT_EQ(meant("spedd_kmph", {"color", "speed_mps"}), "speed_mps");
  EXPECT_EQ(meant("spedd", {"speed_limit"}), "") << "no unit";
  EXPECT_EQ(meant("spedd", {"speed_mps", "spend"}), "spend") << "one mistake is nearer";
  EXPECT_EQ(meant("width", {"speed_mps"}), "");
}

TEST(DidYouMean, IgnoresCommonFileExtensions) {
  EXPECT_EQ(meant("abc.yaml", {"xyz.yaml"}), "");
  EXPECT_EQ(meant("forst.yaml", {"forest.yaml"}), "forest.yaml");
}

TEST(DidYouMean, IgnoresWordsBeyond64Letters) {
  const std::string longest(64, 'a'), longer(65, 'a');
  EXPECT_EQ(meant(longest.substr(1), {longest}), longest);
  EXPECT_EQ(meant(longest, {longer}), "");
  EXPECT_EQ(meant(longer, {longest}), "");
}

TEST(OneOf, ListsItsWordsUpToSixteen) {
  EXPECT_EQ(one_of({}), "none");
  EXPECT_EQ(one_of({"a"}), "\"a\"");
  EXPECT_EQ(one_of({"a", "b", "c"}), "one of \"a\", \"b\", \"c\"");
  const std::vector<std::string> sixteen(16, "x"), seventeen(17, "x");
  EXPECT_EQ(one_of(sixteen).find("..."), std::string::npos);
  EXPECT_EQ(one_of(seventeen), one_of(sixteen) + ", ...");
}

}  // namespace
}  // namespace swiftlet::sim
