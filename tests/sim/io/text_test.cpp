// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/io/text.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "swiftlet/core/base/frames.hpp"
#include "swiftlet/sim/io/text_row.hpp"

namespace swiftlet::sim {
namespace {

TEST(Text, WritesShortestRoundTripNumbers) {
  EXPECT_EQ(shortest(0.1), "0.1");
  EXPECT_EQ(shortest(0.1F), "0.1");
  EXPECT_EQ(shortest(0.30000000000000004), "0.30000000000000004");
  EXPECT_EQ(shortest(1e300), "1e+300");
  EXPECT_EQ(shortest(std::numeric_limits<std::uint64_t>::max()), "18446744073709551615");
  EXPECT_EQ(shortest(-7), "-7");
}

TEST(Text, HashesHaveAllTheirDigits) { EXPECT_EQ(hex64(0xBEEF), "000000000000beef"); }

TEST(Text, QuotesCellsOnlyIfNecessary) {
  EXPECT_EQ(csv_cell("plain words"), "plain words");
  EXPECT_EQ(csv_cell("a,b"), "\"a,b\"");
  EXPECT_EQ(csv_cell("say \"no\""), "\"say \"\"no\"\"\"");
  EXPECT_EQ(csv_cell("a\nb"), "\"a\nb\"");
  EXPECT_EQ(csv_cell("a\rb"), "\"a\rb\"");
  EXPECT_EQ(csv_cell(0.25), "0.25");
  EXPECT_EQ(csv_cell(-INFINITY), "");
  EXPECT_EQ(csv_cell(std::nan("")), "");
}

TEST(Text, DropsWhatXmlForbidsFromMarkup) {
  EXPECT_EQ(escape_markup("a < b & \"c\"\x01\n"), "a &lt; b &amp; &quot;c&quot;\n");
  EXPECT_EQ(escape_markup("a\x1F\tb ~\x7F>\xC3\xA4\r"), "a\tb ~\x7F&gt;\xC3\xA4");
}

TEST(TextRow, WritesNumbersThatRoundTripExactly) {
  for (const double value : {0.1, -1.0 / 3.0, 1e-300, 123456789.123456789, -0.0}) {
    TextRow row(' ');
    const double read = std::stod(std::string(row.add(value).line()));
    EXPECT_EQ(std::signbit(read), std::signbit(value));
    EXPECT_EQ(read, value);
  }
}

TEST(TextRow, WritesSecondsWithNineDecimals) {
  const auto seconds = [](TimeNs t) {
    TextRow row(' ');
    return std::string(row.add_seconds(t).line());
  };
  EXPECT_EQ(seconds(0), "0.000000000\n");
  EXPECT_EQ(seconds(1), "0.000000001\n");
  EXPECT_EQ(seconds(-1), "-0.000000001\n");
  EXPECT_EQ(seconds(999'999'999), "0.999999999\n");
  EXPECT_EQ(seconds(12'000'000'340), "12.000000340\n");
  EXPECT_EQ(seconds(std::numeric_limits<TimeNs>::min()), "-9223372036.854775808\n");
  EXPECT_EQ(seconds(std::numeric_limits<TimeNs>::max()), "9223372036.854775807\n");
}

TEST(Text, ListsHaveCommasBetween) {
  EXPECT_EQ(listed({}), "");
  EXPECT_EQ(listed({"a"}), "a");
  EXPECT_EQ(listed({"a", "b", "c"}), "a, b, c");
}

TEST(TextRow, SeparatesValuesWithoutTrailingBlank) {
  TextRow row(' ');
  row.add_seconds(1'000'000'001).add(Vector3(1, 2.5, -3)).add(7).add(std::string_view("word"));
  EXPECT_EQ(row.line(), "1.000000001 1 2.5 -3 7 word\n");
  row.clear();
  EXPECT_EQ(row.add_seconds(-500'000'000).line(), "-0.500000000\n");
}

}  // namespace
}  // namespace swiftlet::sim
