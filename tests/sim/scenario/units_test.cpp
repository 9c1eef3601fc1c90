// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/scenario/units.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace swiftlet::sim {
namespace {

struct SameAmount {
  const char* key;     // ends with the unit of its value
  const char* symbol;  // another unit
  double value;        // size of one such unit, in the unit of the key
};

// The definitions of the units, as books print them.
const SameAmount kSameAmounts[] = {{"range_m", "km", 1000.0},
                                   {"range_m", "cm", 0.01},
                                   {"duration_s", "ms", 0.001},
                                   {"duration_s", "min", 60.0},
                                   {"duration_s", "h", 3600.0},
                                   {"delay_ms", "s", 1000.0},
                                   {"rate_hz", "kHz", 1000.0},
                                   {"yaw_deg", "rad", 180.0 / std::numbers::pi},
                                   {"yaw_rad", "deg", std::numbers::pi / 180.0},
                                   {"speed_mps", "km/h", 1.0 / 3.6},
                                   {"rate_degps", "rad/s", 180.0 / std::numbers::pi},
                                   {"rate_degps", "rpm", 6.0},
                                   {"rotor_speed_max_radps", "rpm", 2.0 * std::numbers::pi / 60.0},
                                   {"rate_degps2", "rad/s^2", 180.0 / std::numbers::pi},
                                   {"mass_kg", "g", 0.001},
                                   {"force_N", "mN", 0.001},
                                   {"size_kB", "B", 0.001},
                                   {"rate_kbps", "bps", 0.001},
                                   {"rate_kbps", "Mbit/s", 1000.0},
                                   {"area_m2", "cm^2", 1e-4}};

TEST(Units, MatchTheirDefinitions) {
  for (const SameAmount& equal : kSameAmounts) {
    const Unit* const unit = unit_of_key(equal.key);
    ASSERT_NE(unit, nullptr) << equal.key;
    const Unit* const other = find_unit(equal.symbol, *unit);
    ASSERT_NE(other, nullptr) << equal.symbol;
    EXPECT_NEAR(convert(1.0, *other, *unit), equal.value, 1e-15 * equal.value) << equal.key << ' ' << equal.symbol;
    EXPECT_NEAR(convert(convert(7.3, *other, *unit), *unit, *other), 7.3, 1e-14)
        << "conversion to the other unit and back";
    EXPECT_EQ(convert(7.3, *unit, *unit), 7.3);
  }
}

TEST(Units, WholeRatiosAreRoundedOnce) {
  const Unit& second = *unit_of_key("duration_s");
  EXPECT_EQ(convert(300.0, *find_unit("ms", second), second), 0.3);
  EXPECT_EQ(convert(7.0, *find_unit("ms", second), second), 0.007);
  EXPECT_EQ(convert(0.1, *find_unit("min", second), second), 6.0);
  EXPECT_EQ(convert(2000.0, *unit_of_key("yaw_deg"), *unit_of_key("yaw_deg")), 2000.0);
}

TEST(Units, KeysLastWordNamesTheUnit) {
  EXPECT_STREQ(unit_of_key("rate_hz")->symbol, "Hz");
  EXPECT_STREQ(unit_of_key("wind_speed_mps")->symbol, "m/s");
  EXPECT_EQ(unit_of_key("m"), nullptr) << "a word, not a suffix";
  EXPECT_EQ(unit_of_key("range_"), nullptr);
  EXPECT_EQ(unit_of_key("area_min"), nullptr) << "not a minute";
  EXPECT_EQ(unit_of_key("detection_rate_per_s"), nullptr);
  EXPECT_EQ(unit_of_key("speed_knots"), nullptr);
}

TEST(Units, OfAnotherDimensionFitNot) {
  EXPECT_EQ(find_unit("s", *unit_of_key("range_m")), nullptr);
  EXPECT_EQ(find_unit("parsec", *unit_of_key("range_m")), nullptr);
  EXPECT_EQ(find_unit("", *unit_of_key("range_m")), nullptr);
}

TEST(Quantity, ParsesANumberAndItsUnit) {
  const auto expect = [](std::string_view text, double value, std::string_view unit) {
    const auto quantity = parse_quantity(text);
    ASSERT_TRUE(quantity.has_value()) << text;
    EXPECT_EQ(quantity->value, value) << text;
    EXPECT_EQ(quantity->unit, unit) << text;
  };
  expect("20 cm", 20.0, "cm");
  expect("20cm", 20.0, "cm");
  expect("-1.5e3 \t km/h \t", -1500.0, "km/h");
  expect("+2 m", 2.0, "m");
  expect("7", 7.0, "");
  expect("5 kg m^2", 5.0, "kg m^2");
  for (const char* text : {"", "+", "+-3 m", "++3 m", "m", "nan", "inf", "1e999 m", " 3 m"})
    EXPECT_FALSE(parse_quantity(text).has_value()) << text;
}

TEST(YamlNumber, IsReadBackAsItWas) {
  EXPECT_EQ(yaml_number(0.1), "0.1");
  EXPECT_EQ(yaml_number(std::nan("")), ".nan");
  EXPECT_EQ(yaml_number(INFINITY), ".inf");
  EXPECT_EQ(yaml_number(-INFINITY), "-.inf");
  EXPECT_EQ(std::stod(yaml_number(1.0 / 3.0)), 1.0 / 3.0);
}

}  // namespace
}  // namespace swiftlet::sim
