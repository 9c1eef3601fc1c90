// SPDX-License-Identifier: BSD-3-Clause
// Texts, trees and messages on both sides of every bound; numbers by their ranges; names of files.
#include "swiftlet/sim/scenario/document.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <limits>

#include "sim/scenario/changes.hpp"
#include "swiftlet/sim/scenario/assets.hpp"
#include "swiftlet/sim/scenario/recorder_paths.hpp"
#include "swiftlet/sim/scenario/yaml_reader.hpp"
#include "tests/sim/scenario/example_config.hpp"
#include "tests/support/temporary_directory.hpp"

namespace swiftlet::sim {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::StartsWith;

Node parsed(const std::string& text) { return parse_document(text, {"a.yaml", "."}); }
std::string parse_error(const std::string& text) {
  try {
    parsed(text);
  } catch (const InputError& problem) {
    return problem.what();
  }
  return "";
}
std::string times(const std::string& text, int count) {
  std::string all;
  for (int i = 0; i < count; ++i) all += text;
  return all;
}

// Table 3-7 of the Unicode standard, both sides of each of its bounds.
TEST(Document, TakesOnlyWellFormedUtf8) {
  for (const char* good :
       {"\x7E", "\xC2\x80", "\xDF\xBF", "\xE0\xA0\x80", "\xE0\xBF\xBF", "\xE1\x80\x80", "\xEC\xBF\xBF", "\xED\x80\x80",
        "\xED\x9F\xBF", "\xEE\x80\x80", "\xEF\xBF\xBD", "\xF0\x90\x80\x80", "\xF0\xBF\xBF\xBF", "\xF1\x80\x80\x80",
        "\xF3\xBF\xBF\xBF", "\xF4\x80\x80\x80", "\xF4\x8F\xBF\xBF"}) {
    EXPECT_EQ(parse_error(std::string("a: x") + good), "") << good;
  }
  for (const char* bad : {"\x80", "\xC0\xAF", "\xC2", "\xC2\x7F", "\xE0\x9F\xBF", "\xE1\x80", "\xE1\x80\x28",
                          "\xED\xA0\x80", "\xF0\x8F\xBF\xBF", "\xF1\x80\x80", "\xF4\x90\x80\x80", "\xFF"}) {
    EXPECT_THAT(parse_error(std::string("a: x") + bad), StartsWith("a.yaml:1:5: expected UTF-8 text")) << bad;
  }
}

TEST(Document, LocatesInvalidBytes) {
  EXPECT_EQ(parse_error("a: 1\nb: \x1F"), "a.yaml:2:4: expected text, found the control character 0x1f");
  EXPECT_EQ(parse_error("\xC3\xA4: \x7F"), "a.yaml:1:5: expected text, found the control character 0x7f");
  EXPECT_EQ(parse_error("a: x\ty\r\n"), "") << "tabs within and ends of lines are fine";
  EXPECT_EQ(parse_error("a:\n  \t\tb: 1\n"), "a.yaml:2:3: expected spaces as indentation, found a tab");
  EXPECT_EQ(parse_error("a:\n \t b: 1\n"), "a.yaml:2:2: expected spaces as indentation, found a tab");
  EXPECT_EQ(parse_error("a: 1 #\t\n#\tb\nc: 2\n"), "");
}

TEST(Document, HasAtMost64LevelsAliasesCounted) {
  const auto nested = [](int levels) { return "a: " + times("[", levels) + times("]", levels); };
  EXPECT_EQ(parse_error(nested(kMaxDepth - 1)), "") << "with the map itself 64";
  EXPECT_THAT(parse_error(nested(kMaxDepth)), HasSubstr("at most 64 levels"));
  const auto with_alias = [](int inner, int outer) {
    return "a: &x " + times("[", inner) + times("]", inner) + "\nb: " + times("[", outer) + "*x" + times("]", outer);
  };
  EXPECT_EQ(parse_error(with_alias(30, 33)), "");
  EXPECT_THAT(parse_error(with_alias(30, 34)), HasSubstr("at most 64 levels"));
  EXPECT_THAT(parse_error(with_alias(31, 33)), HasSubstr("at most 64 levels"));
}

TEST(Document, ListsAndMapsHaveTheirBounds) {
  EXPECT_EQ(parsed("a: [" + times("x,", 100'000) + "]").find("a")->items.size(), 100'000U);
  EXPECT_THAT(parse_error("a: [" + times("x,", 100'001) + "]"), HasSubstr("a list of at most 100000 values"));
  const auto map = [](int keys) {
    std::string text;
    for (int i = 0; i < keys; ++i) text += "k" + std::to_string(i) + ": 1\n";
    return text;
  };
  EXPECT_EQ(parsed(map(4096)).entries.size(), 4096U);
  EXPECT_THAT(parse_error(map(4097)), HasSubstr("a map of at most 4096 keys"));
}

TEST(Document, ReportsFirstOfSeveralDuplicateKeys) {
  EXPECT_EQ(parse_error("a: 1\nb: 1\nb: 2\na: 2\n"),
            "a.yaml:3:1: expected each key once, found \"b\" again (first in line 2)");
  EXPECT_EQ(parse_error("b: 1\na: 1\na: 2\nb: 2\n"),
            "a.yaml:3:1: expected each key once, found \"a\" again (first in line 2)");
  EXPECT_EQ(parse_error("a: 1\na: 2\na: 3\n"),
            "a.yaml:2:1: expected each key once, found \"a\" again (first in line 1)");
}

TEST(Document, RecognizesSelectorsInOneBracketPair) {
  EXPECT_EQ(parsed("a[0]: 1").find("a")->kind, Node::Kind::kElements);
  EXPECT_EQ(parsed("a[x]: 1\na[0]: 2").find("a")->entries.size(), 2U);
  for (const char* plain : {"\"[0]\"", "\"a[]\"", "\"a[0\"", "\"a]\"", "\"a[0][1]\"", "\"a[0]b\""}) {
    const Node node = parsed(std::string(plain) + ": 1");
    ASSERT_EQ(node.entries.size(), 1U);
    EXPECT_EQ("\"" + node.entries[0].key + "\"", plain);
    EXPECT_EQ(node.entries[0].value.kind, Node::Kind::kScalar) << plain;
  }
  // For a list of the same map it is a change.
  const Node changed = parsed("a: [1, 2]\n\"a[1]\": 5");
  EXPECT_EQ(changed.find("a")->items[1].text, "5");
  EXPECT_EQ(changed.entries.size(), 1U);
}

TEST(Document, ValuesAreCountedAndDescribed) {
  EXPECT_EQ(num_nodes(parsed("{a: 1, b: [1, 2, {c: 3}]}")), 7U);
  EXPECT_EQ(describe(*parsed("a: []").find("a")), "an empty list");
  EXPECT_EQ(describe(*parsed("a: [1]").find("a")), "a list of 1 value");
  EXPECT_EQ(describe(*parsed("a: [1, 2]").find("a")), "a list of 2 values");
  EXPECT_EQ(describe(*parsed("a: {}").find("a")), "a map");
  EXPECT_EQ(describe(*parsed("a: ~").find("a")), "nothing");
  EXPECT_EQ(describe(*parsed("a[0]: 1").find("a")), "changes to elements of a list");
}

TEST(Document, LongTextsAreCutBetweenCharacters) {
  EXPECT_EQ(quote(std::string(60, 'x')), "\"" + std::string(60, 'x') + "\"");
  EXPECT_EQ(quote(std::string(61, 'x')), "\"" + std::string(60, 'x') + "...\"");
  EXPECT_EQ(quote(std::string(59, 'x') + "\xC3\xA4"), "\"" + std::string(59, 'x') + "\xC3\xA4\"");
  EXPECT_EQ(quote(std::string(59, 'x') + "\xC3\xA4y"), "\"" + std::string(59, 'x') + "\xC3\xA4...\"");
  EXPECT_EQ(quote("a\nb\tc\x01\x7F~ "), "\"a\\nb\\tc\\x01\\x7f~ \"");
  EXPECT_EQ(join_path("", std::string(60, 'x')), std::string(60, 'x'));
  EXPECT_EQ(join_path("p", std::string(61, 'x')), "p." + std::string(60, 'x'));
  EXPECT_EQ(join_path("", std::string(59, 'x') + "\xC3\xA4y"), std::string(59, 'x') + "\xC3\xA4");
}

TEST(Document, ReportsEachErrorInOneLine) {
  const auto source = std::make_shared<const Source>(Source{"f.yaml", "."});
  EXPECT_EQ(error_line({source, 3, 7}, "a.b", "wrong"), "f.yaml:3:7: a.b: wrong");
  EXPECT_EQ(error_line({source, 0, 0}, "a", "wrong"), "f.yaml: a: wrong");
  EXPECT_EQ(error_line({source, 1, 1}, "", "wrong"), "f.yaml:1:1: wrong");
  EXPECT_EQ(error_line({source, 1, 1}, "a\nb", "c\x1Fx\x7F ~"), "f.yaml:1:1: a?b: c?x? ~");
  const auto option = std::make_shared<const Source>(Source{"--set a.b", "."});
  EXPECT_EQ(error_line({option, 0, 0}, "a.b", "wrong"), "--set a.b: wrong") << "not twice";
  EXPECT_EQ(error_line({option, 0, 0}, "a", "wrong"), "--set a.b: a: wrong");
}

TEST(Document, LimitsOverridePartsAndLength) {
  const auto takes = [](const std::string& path) {
    try {
      parse_override(path, "1");
      return true;
    } catch (const InputError&) {
      return false;
    }
  };
  EXPECT_TRUE(takes(std::string(1000, 'a')));
  EXPECT_FALSE(takes(std::string(1001, 'a')));
  EXPECT_TRUE(takes("a" + times(".a", 63)));
  EXPECT_FALSE(takes("a" + times(".a", 64)));
  EXPECT_FALSE(takes("a\x1F"));
  EXPECT_FALSE(takes("a\xFF"));
  for (const char* good : {"a[0].b", "a[b]", "a[0].b[*].c", "a b"}) EXPECT_TRUE(takes(good)) << good;
  const Node node = parse_override("a[0].b", " \t\r\n");
  EXPECT_EQ(node.find("a")->entries[0].key, "[0]");
  EXPECT_EQ(node.find("a")->entries[0].value.find("b")->kind, Node::Kind::kNull);
  EXPECT_EQ(node.find("a")->place.str(), "--set a[0].b");
}

TEST(Document, LocatesNestedAndDottedKeys) {
  const Node changes = parsed("a:\n  b: {c: 1}\nd.e: 2\nf[0]: {g: 3}\nh[x].i: 4\n");
  EXPECT_EQ(place_of_key(changes, "a.b.c")->str(), "a.yaml:2:7");
  EXPECT_EQ(place_of_key(changes, "d.e")->str(), "a.yaml:3:1");
  EXPECT_EQ(place_of_key(changes, "f[0].g")->str(), "a.yaml:4:8");
  EXPECT_EQ(place_of_key(changes, "h[x].i")->str(), "a.yaml:5:1");
  EXPECT_EQ(place_of_key(changes, "a.x"), nullptr);
  EXPECT_EQ(place_of_key(changes, "z"), nullptr);
}

// --- numbers ---

struct RangesConfig {
  double any = 0, open = 5, closed = 5, half_open = 5, above = 5, from = 5, below = 5, up_to = 5, large = 0;
  int count = 3;
  std::vector<RangesConfig*> unused;

  void visit(ConfigVisitor& v) {
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    v.field("any", any, "[-] x");
    v.field("open", open, "[-] x", Range{2, 9, true, true});
    v.field("closed", closed, "[-] x", Range{2, 9, false, false});
    v.field("half_open", half_open, "[-] x", Range{2, 9, true, false});
    v.field("above", above, "[-] x", Range{2, kInfinity, true, false});
    v.field("from", from, "[-] x", Range{2, kInfinity, false, false});
    v.field("below", below, "[-] x", Range{-kInfinity, 9, false, true});
    v.field("up_to", up_to, "[-] x", Range{-kInfinity, 9, false, false});
    v.field("large", large, "[-] x", Range{2e9, kInfinity, false, false});
    v.field("count", count, "[-] x", Range{2, 9, true, false});
  }
};

std::string range_error(const std::string& text) {
  RangesConfig config;
  config.large = 3e9;
  try {
    read_config_text(
        text, "r.yaml", [&](ConfigVisitor& v) { config.visit(v); }, {}, example_files());
  } catch (const InputError& problem) {
    std::string message = problem.what();
    const std::size_t at = message.find("expected ");
    return message.substr(at, message.find(", found") - at);
  }
  return "";
}

TEST(Ranges, EnforceAndReportBothEnds) {
  const struct {
    const char* key;
    bool takes_2, takes_9;
    const char* words;
  } ranges[] = {{"open", false, false, "expected a number in (2, 9)"},
                {"closed", true, true, "expected a number in [2, 9]"},
                {"half_open", false, true, "expected a number in (2, 9]"},
                {"above", false, true, "expected a number > 2"},
                {"from", true, true, "expected a number >= 2"},
                {"below", true, false, "expected a number < 9"},
                {"up_to", true, true, "expected a number <= 9"},
                {"count", false, true, "expected a whole number in (2, 9]"}};
  for (const auto& range : ranges) {
    const std::string key = std::string(range.key) + ": ";
    EXPECT_EQ(range_error(key + "2"), range.takes_2 ? "" : range.words);
    EXPECT_EQ(range_error(key + "9"), range.takes_9 ? "" : range.words);
    EXPECT_EQ(range_error(key + "5"), "");
    EXPECT_EQ(range_error(key + "x"), range.words);
    const bool ends_above = std::string(range.words).find("9") != std::string::npos;
    const bool ends_below = std::string(range.words).find("2") != std::string::npos;
    EXPECT_EQ(range_error(key + "10"), ends_above ? range.words : "");
    EXPECT_EQ(range_error(key + "1"), ends_below ? range.words : "");
  }
}

TEST(Ranges, ReachABillionWithoutAnEnd) {
  EXPECT_EQ(range_error("any: 1e9"), "");
  EXPECT_EQ(range_error("any: -1e9"), "");
  EXPECT_EQ(range_error("any: 1.0001e9"), "expected a number in [-1e+09, 1e+09]");
  EXPECT_EQ(range_error("any: -1.0001e9"), "expected a number in [-1e+09, 1e+09]");
  EXPECT_EQ(range_error("above: 1e9"), "");
  EXPECT_EQ(range_error("above: 2e9"), "expected a number in (2, 1e+09]");
  EXPECT_EQ(range_error("below: -2e9"), "expected a number in [-1e+09, 9)");
  EXPECT_EQ(range_error("large: 2e9"), "") << "unless the least is larger";
  EXPECT_EQ(range_error("any: .inf"), "expected a number");
}

TEST(Ranges, AcceptOnlyWholeNumbersThatFit) {
  EXPECT_EQ(range_error("count: 4.0"), "");
  EXPECT_EQ(range_error("count: 3.5"), "expected a whole number in (2, 9]");
  struct Wide {
    int n = 0;
    void visit(ConfigVisitor& v) { v.field("n", n, "[-] x"); }
  };
  for (const auto& [text, fits] :
       {std::pair("2147483647", true), {"2147483648", false}, {"-2147483648", true}, {"-2147483649", false}}) {
    Wide wide;
    const auto read = [&, text = text] {
      read_config_text(
          std::string("n: ") + text, "w.yaml", [&](ConfigVisitor& v) { wide.visit(v); }, {}, example_files());
    };
    if (fits) {
      EXPECT_NO_THROW(read());
      EXPECT_EQ(std::to_string(wide.n), text);
    } else {
      EXPECT_THROW(read(), InputError) << text;
    }
  }
}

TEST(Ranges, SuggestBooleansForYesAndNo) {
  const auto suggested = [](const std::string& word) {
    FleetConfig fleet;
    try {
      read_config_text(
          "racing: " + word, "f.yaml", [&](ConfigVisitor& v) { fleet.visit(v); }, {}, example_files());
    } catch (const InputError& problem) {
      const std::string message = problem.what();
      const std::size_t at = message.find("did you mean \"");
      return at == std::string::npos ? std::string("nothing") : message.substr(at + 14, message.rfind('"') - at - 14);
    }
    return std::string("taken");
  };
  for (const char* yes : {"yes", "Yes", "on", "On", "True", "TRUE", "1"}) EXPECT_EQ(suggested(yes), "true") << yes;
  for (const char* no : {"no", "No", "off", "Off", "False", "FALSE", "0"}) EXPECT_EQ(suggested(no), "false") << no;
  EXPECT_EQ(suggested("true"), "taken");
  EXPECT_EQ(suggested("false"), "taken");
  EXPECT_EQ(suggested("\"true\""), "nothing");
  EXPECT_EQ(suggested("2"), "nothing");
  EXPECT_EQ(suggested("[true]"), "nothing");
}

// --- files ---

TEST(AssetLists, ShowFirstHeadSentenceOrDescription) {
  const std::pair<const char*, const char*> texts[] = {
      {"# A small boat. With a sail.\na: 1\n", "A small boat"},
      {"# Two lines\n# of one sentence: and more\n", "Two lines of one sentence"},
      {"# Weighs 1.5 kg, see [Vrba 2025. Fig. 3]. More\n", "Weighs 1.5 kg, see [Vrba 2025. Fig. 3]"},
      {"a: 1\n# no head\n", ""},
      {"# Head.\nname: x\ndescription: It flies. Far.\nb: 1\n", "It flies. Far."},
      {"name: x\ndescription: >-\n  Of two\n  lines. More\nb: 1\n", "Of two lines"}};
  for (const auto& [text, expected] : texts) {
    const MemoryFiles files({{"/assets/boats/one.yaml", text}, {"/assets/boats/two.txt", "# no"}});
    const auto assets = list_assets("boats", files);
    ASSERT_EQ(assets.size(), 1U);
    EXPECT_EQ(assets[0].name, "one");
    EXPECT_EQ(assets[0].doc, expected) << text;
  }
  const MemoryFiles scenarios({{"/scenarios/a.yaml", "# Top. x"}, {"/scenarios/batch/b.yaml", "# Below. x"}});
  EXPECT_EQ(list_assets("scenarios", scenarios).at(0).doc, "Top");
  EXPECT_EQ(list_assets("scenarios/batch", scenarios).at(0).name, "b");
}

TEST(SystemFiles, AreSortedAndLimitedInSize) {
  const TemporaryDirectory folder;
  for (const char* name : {"b", "a", "c"}) std::ofstream(folder.path() / name) << name;
  EXPECT_THAT(system_files().list(folder.path()), ElementsAre("a", "b", "c"));
  EXPECT_THAT(system_files().list(folder.path() / "none"), IsEmpty());
  EXPECT_EQ(system_files().read(folder.path() / "a"), "a");
  EXPECT_TRUE(system_files().is_file(folder.path() / "a"));
  EXPECT_FALSE(system_files().is_file(folder.path()));
  EXPECT_THROW(system_files().read(folder.path() / "none"), std::runtime_error);
  std::ofstream(folder.path() / "large") << std::string(kMaxFileBytes + 10, 'x');
  EXPECT_EQ(system_files().read(folder.path() / "large").size(), kMaxFileBytes + 1) << "enough to be refused";
}

TEST(FileNames, AllowLettersDigitsAndFewSymbols) {
  for (const char* good : {"a", "z", "A", "Z", "0", "9", "_", "a-", "a.b", "_x"})
    EXPECT_TRUE(is_file_name(good)) << good;
  for (const char* bad : {"", ".a", "-a", "`", "{", "@", "[", "/", ":", "a b", "\xC3\xA4"})
    EXPECT_FALSE(is_file_name(bad)) << bad;
  EXPECT_TRUE(is_file_name(std::string(64, 'x')));
  EXPECT_FALSE(is_file_name(std::string(65, 'x')));
}

TEST(FlowText, QuotesOnlyWhatNeedsIt) {
  const auto flow = [](const std::string& text) {
    Node node;
    node.kind = Node::Kind::kScalar;
    node.text = text;
    return flow_text(node);
  };
  for (const char* plain : {"a", "z", "A", "Z", "0", "9", "_./+-% x", "-1", "-a", "20 cm", "a-", "a - b", "\xC3\xA4"})
    EXPECT_EQ(flow(plain), plain);
  for (const char* quoted :
       {"", " a", "a ", "%a", "-", "- a", "--", "---a", "`", "{", "@", "[", ":", "a: b", "a#", "a,b", "'"})
    EXPECT_EQ(flow(quoted), "\"" + std::string(quoted) + "\"");
  EXPECT_EQ(flow("a\"b\\c\nd\te"), "\"a\\\"b\\\\c\\nd\\te\"");
  Node word;
  word.kind = Node::Kind::kScalar;
  word.text = "a";
  word.quoted = true;
  EXPECT_EQ(flow_text(word), "\"a\"") << "what was quoted stays so";
  EXPECT_EQ(flow_text(parsed("{a: [1, ~, {b: x, \"c d\": \"y\"}], e: ~, f: []}")),
            "{a: [1, ~, {b: x, c d: \"y\"}], e: , f: []}");
  EXPECT_EQ(flow_text(parsed("{\"a[0]\": {b: 1}, \"a[x]\": 2, c: 3}")), "{c: 3, \"a[0]\": {b: 1}, \"a[x]\": 2}");
}

}  // namespace
}  // namespace swiftlet::sim
