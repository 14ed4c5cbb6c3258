#include "drivers/wire/wind_sonic.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/unit/drivers/wire/decoder_support.h"

namespace roseau::wire {
namespace {

constexpr double kRadians = std::numbers::pi / 180.0;

struct PolarVector {
  std::string body;
  std::string checksum;
  double direction_deg;
  double speed_mps;
};

class WindSonicPolar : public ::testing::TestWithParam<PolarVector> {};

// Records of real instruments and of the manual whose checksums were recomputed by hand.
INSTANTIATE_TEST_SUITE_P(
    Verified, WindSonicPolar,
    ::testing::Values(PolarVector{"Q,229,002.74,M,00,", "16", 229, 2.74}, PolarVector{"Q,156,000.05,M,00,", "19", 156, 0.05},
                      PolarVector{"Q,100,000.09,M,00,", "16", 100, 0.09}, PolarVector{"Q,160,000.05,M,00,", "1C", 160, 0.05},
                      PolarVector{"Q,160,000.04,M,00,", "1D", 160, 0.04}, PolarVector{"Q,170,000.06,M,00,", "1E", 170, 0.06}));

TEST_P(WindSonicPolar, DecodesIntoComponents) {
  const auto& vector = GetParam();
  DecoderUnderTest decoder(kWindSonicDialect);
  decoder.feed(framed(vector.body, vector.checksum));
  ASSERT_EQ(decoder.samples().size(), 1U);
  const auto& wind = decoder.wind(0);
  EXPECT_TRUE(wind.valid);
  // Wind from the south is +u, from the east +v.
  EXPECT_NEAR(wind.u_mps, -vector.speed_mps * std::cos(vector.direction_deg * kRadians), 1e-12);
  EXPECT_NEAR(wind.v_mps, vector.speed_mps * std::sin(vector.direction_deg * kRadians), 1e-12);
  EXPECT_TRUE(std::isnan(wind.w_mps));
  EXPECT_TRUE(std::isnan(wind.sonic_temperature_celsius));
}

TEST_P(WindSonicPolar, IsEncodedAsTheInstrumentPrintsIt) {
  const auto& vector = GetParam();
  const WindSample sample{.u_mps = -vector.speed_mps * std::cos(vector.direction_deg * kRadians),
                          .v_mps = vector.speed_mps * std::sin(vector.direction_deg * kRadians)};
  const WindSonicFormat format{.mode = WindSonicFormat::Mode::polar, .calm_below_mps = 0};
  EXPECT_EQ(text_of(encode_wind_sonic(sample, format)), framed(vector.body, vector.checksum));
}

TEST(WindSonic, CalmHasNoDirectionAndNoComponents) {
  DecoderUnderTest decoder(kWindSonicDialect);
  decoder.feed(framed("Q,,000.04,M,00,", "2A"));
  ASSERT_EQ(decoder.samples().size(), 1U);
  EXPECT_TRUE(decoder.wind(0).valid);
  EXPECT_EQ(decoder.wind(0).u_mps, 0);
  EXPECT_EQ(decoder.wind(0).v_mps, 0);
  const WindSample calm{.u_mps = -0.04, .v_mps = 0};
  EXPECT_EQ(text_of(encode_wind_sonic(calm, {.mode = WindSonicFormat::Mode::polar})), framed("Q,,000.04,M,00,", "2A"));
}

TEST(WindSonic, ComponentsAreTakenAsTheyAre) {
  DecoderUnderTest decoder(kWindSonicDialect);
  decoder.feed(framed("Q,+001.59,-002.74,M,00,"));
  ASSERT_EQ(decoder.samples().size(), 1U);
  EXPECT_DOUBLE_EQ(decoder.wind(0).u_mps, 1.59);
  EXPECT_DOUBLE_EQ(decoder.wind(0).v_mps, -2.74);
  EXPECT_EQ(text_of(encode_wind_sonic(decoder.wind(0), {})), framed("Q,+001.59,-002.74,M,00,"));
}

struct BadVector {
  std::string record;
  std::string mended;
};

class WindSonicMisprint : public ::testing::TestWithParam<BadVector> {};

// Examples of the manual whose printed checksum is wrong, and the same with the right one.
INSTANTIATE_TEST_SUITE_P(OfTheManual, WindSonicMisprint,
                         ::testing::Values(BadVector{framed("Q,+001.59,-002.74,M,00,", "2D"),
                                                     framed("Q,+001.59,-002.74,M,00,", "3A")},
                                           BadVector{framed("Q,,,M,04,", "24"), framed("Q,,,M,04,", "34")},
                                           BadVector{framed("Q,999,999.99,M,04,", "0A"), framed("Q,999,999.99,M,04,", "1A")},
                                           BadVector{framed("Q,,000.03,M,00", "1C"), framed("Q,,000.03,M,00,", "2D")},
                                           BadVector{"$IIMWV,120,R,002.10,M,A*5D\r\n", "$IIMWV,120,R,002.10,M,A*10\r\n"}));

TEST_P(WindSonicMisprint, IsRejectedAndCounted) {
  DecoderUnderTest decoder(kWindSonicDialect);
  decoder.feed(GetParam().record);
  EXPECT_TRUE(decoder.samples().empty());
  EXPECT_EQ(decoder.counters().bad_records, 1U);
}

TEST_P(WindSonicMisprint, IsAcceptedOnceMended) {
  DecoderUnderTest decoder(kWindSonicDialect);
  decoder.feed(GetParam().mended);
  EXPECT_EQ(decoder.samples().size(), 1U);
  EXPECT_EQ(decoder.counters().bad_records, 0U);
  EXPECT_EQ(decoder.counters().skipped_bytes, 0U);
}

TEST(WindSonic, FailedAxesGiveNoWind) {
  for (const char* body : {"Q,,,M,04,", "Q,999,999.99,M,04,", "Q,+999.99,+999.99,M,01,", "Q,229,002.74,M,02,",
                           "Q,229,002.74,M,08,", "Q,229,002.74,M,09,", "Q,229,002.74,M,51,"}) {
    DecoderUnderTest decoder(kWindSonicDialect);
    decoder.feed(framed(body));
    ASSERT_EQ(decoder.samples().size(), 1U) << body;
    EXPECT_FALSE(decoder.wind(0).valid) << body;
    EXPECT_TRUE(std::isnan(decoder.wind(0).u_mps)) << body;
    EXPECT_EQ(decoder.samples()[0].header.status, kStatusDeviceError) << body;
  }
  DecoderUnderTest decoder(kWindSonicDialect);
  decoder.feed(framed("Q,,,M,04,"));
  EXPECT_EQ(decoder.wind(0).device_status, 4);
}

TEST(WindSonic, MarginalGainIsStillGood) {
  DecoderUnderTest decoder(kWindSonicDialect);
  decoder.feed(framed("Q,229,002.74,M,10,"));
  ASSERT_EQ(decoder.samples().size(), 1U);
  EXPECT_TRUE(decoder.wind(0).valid);
  EXPECT_EQ(decoder.wind(0).device_status, 0x10);
}

TEST(WindSonic, EveryUnitBecomesMetresPerSecond) {
  const std::vector<std::pair<char, double>> units = {
      {'M', 1.0}, {'N', 0.514444}, {'P', 0.44704}, {'K', 0.277778}, {'F', 0.00508}};
  for (const auto& [unit, mps] : units) {
    DecoderUnderTest decoder(kWindSonicDialect);
    decoder.feed(framed(std::string("Q,+010.00,-020.00,") + unit + ",00,"));
    ASSERT_EQ(decoder.samples().size(), 1U) << unit;
    EXPECT_NEAR(decoder.wind(0).u_mps, 10 * mps, 1e-4) << unit;
    EXPECT_NEAR(decoder.wind(0).v_mps, -20 * mps, 1e-4) << unit;
  }
  DecoderUnderTest decoder(kWindSonicDialect);
  decoder.feed(framed("Q,+010.00,-020.00,X,00,"));
  EXPECT_EQ(decoder.counters().bad_records, 1U);
}

TEST(WindSonic, ReadsNmeaInAllItsVariants) {
  struct Vector {
    std::string sentence;
    double direction_deg;
    double speed_mps;
  };
  const std::vector<Vector> vectors = {{"$WIMWV,57.5,R,13.0,N,A*26", 57.5, 13.0 * 1852 / 3600},
                                       {"$WIMWV,73.7,R,11.1,N,A*21", 73.7, 11.1 * 1852 / 3600},
                                       {"$WIMWV,39,R,1.3,M,A*06", 39, 1.3},
                                       {"$WIMWV,61,R,1.0,M,A*08", 61, 1.0},
                                       {"$WIMWV,214.8,R,0.1,K,A*28", 214.8, 0.1 / 3.6},
                                       {"$IIMWV,120,R,002.10,M,A*10", 120, 2.1}};
  for (const auto& vector : vectors) {
    DecoderUnderTest decoder(kWindSonicDialect);
    decoder.feed(vector.sentence + "\r\n");
    ASSERT_EQ(decoder.samples().size(), 1U) << vector.sentence;
    EXPECT_NEAR(decoder.wind(0).u_mps, -vector.speed_mps * std::cos(vector.direction_deg * kRadians), 1e-9);
    EXPECT_NEAR(decoder.wind(0).v_mps, vector.speed_mps * std::sin(vector.direction_deg * kRadians), 1e-9);
  }
}

TEST(WindSonic, NmeaSaysWhenItHasNoWind) {
  for (const char* body : {"IIMWV,,R,,M,V", "IIMWV,,R,,,V", "WIMWV,,R,,M,04"}) {
    DecoderUnderTest decoder(kWindSonicDialect);
    decoder.feed("$" + std::string(body) + "*" + hex_byte(xor_of(body)) + "\r\n");
    ASSERT_EQ(decoder.samples().size(), 1U) << body;
    EXPECT_FALSE(decoder.wind(0).valid) << body;
  }
}

TEST(WindSonic, OtherSentencesAreNoDamage) {
  DecoderUnderTest decoder(kWindSonicDialect);
  decoder.feed("$WIMWV,96.6,T,11.2,N,A*2E\r\n$WIMWD,328.2,T,326.8,M,11.2,N,5.8,M*61\r\n");
  decoder.feed("$IIXDR,C,,C,AIRTEMP,A,0.6,D,HEEL,A,2.4,D,TRIM,P,,B,BARO,A,-3.7,D,RUDDER*00\r\n");
  EXPECT_TRUE(decoder.samples().empty());
  EXPECT_EQ(decoder.counters().bad_records, 0U);
  EXPECT_EQ(decoder.counters().text_lines, 3U);
}

TEST(WindSonic, NmeaWithoutOrWithWrongChecksumIsRejected) {
  for (const char* line :
       {"$WIMWV,39,R,1.3,M,A\r\n", "$WIMWV,39,R,1.3,M,A*07\r\n", "$WIMWV,39,R,1.3,M,A*\r\n", "$WIMWV,39,R,1.3,M,A*0\r\n"}) {
    DecoderUnderTest decoder(kWindSonicDialect);
    decoder.feed(line);
    EXPECT_TRUE(decoder.samples().empty()) << line;
    EXPECT_EQ(decoder.counters().bad_records, 1U) << line;
  }
}

TEST(WindSonic, SenselessFieldsAreBadRecords) {
  for (const char* body :
       {"Q,361,002.74,M,00,", "Q,229,-02.74,M,00,", "Q,229,102.74,M,00,", "Q,+101.00,+000.00,M,00,", "Q,229,002.74,M,0,",
        "Q,229,002.74,M,0G,", "Q,229,002.74,M,00,00,", "Q,229,002.74,00,", "Q,2e1,002.74,M,00,", "Q,nan,002.74,M,00,",
        "Q,inf,002.74,M,00,", "Q,+1.2.3,+000.00,M,00,", "Q,+,+000.00,M,00,", "Q,229,002.74,MM,00,", "Q,"}) {
    DecoderUnderTest decoder(kWindSonicDialect);
    decoder.feed(framed(body));
    EXPECT_TRUE(decoder.samples().empty()) << body;
    EXPECT_EQ(decoder.counters().bad_records, 1U) << body;
  }
}

TEST(WindSonic, BannerEchoAndConfigurationModeAreTextAndNothingElse) {
  const std::string text =
      "\r\nWINDSONIC (Gill Instruments Ltd)\r\n2368-110-01\r\nRS485/RS422 (CFG)\r\nCHECKSUM ROM:E15C E15C *PASS*\r\n"
      "CHECKSUM FAC:04F9 04F9 *FAIL*\r\nCONFIGURATION MODE\r\nM2\r\n?&\r\nB4\r\n";
  DecoderUnderTest decoder(kWindSonicDialect);
  decoder.feed(text + framed("Q,229,002.74,M,00,") + text);
  EXPECT_EQ(decoder.samples().size(), 1U);
  EXPECT_EQ(decoder.counters().bad_records, 0U);
  EXPECT_EQ(decoder.counters().text_lines, 18U);
}

TEST(WindSonic, NodesWhoseLettersAreHexDigitsAreTakenApart) {
  std::string line;
  for (const char node : {'A', 'B', 'C', 'D', 'E', 'F'}) {
    line += node;  // the echo of the poll
    auto record = framed(std::string(1, node) + ",229,002.74,M,00,");
    record.resize(record.size() - 2);  // not even a terminator between
    line += record;
  }
  DecoderUnderTest all(kWindSonicDialect);
  all.feed(line);
  EXPECT_EQ(all.samples().size(), 6U);
  EXPECT_EQ(all.counters().bad_records, 0U);
  DecoderUnderTest one(GillDecoder::Options{.node = 'C', .dialect = kWindSonicDialect});
  one.feed(line);
  EXPECT_EQ(one.samples().size(), 1U);
  EXPECT_EQ(one.counters().bad_records, 0U);
}

TEST(WindSonic, FixedFieldsAndCarriageReturnAlone) {
  const WindSonicFormat format{.mode = WindSonicFormat::Mode::polar, .fixed_fields = true, .ends_with_line_feed = false};
  const WindSample failed{.device_status = 4, .valid = false};
  auto expected = framed("Q,999,999.99,M,04,", "1A");
  expected.pop_back();
  EXPECT_EQ(text_of(encode_wind_sonic(failed, format)), expected);
  DecoderUnderTest decoder(kWindSonicDialect);
  decoder.feed(expected + expected);
  EXPECT_EQ(decoder.samples().size(), 2U);
  EXPECT_EQ(decoder.counters().skipped_bytes, 0U);
}

TEST(WindSonic, RoundTripsInEveryModeAndUnit) {
  using Mode = WindSonicFormat::Mode;
  for (const auto mode : {Mode::uv, Mode::polar, Mode::nmea}) {
    for (const char unit : {'M', 'N', 'P', 'K', 'F'}) {
      for (double direction_deg = 0.5; direction_deg < 360; direction_deg += 7.25) {
        const double speed_mps = unit == 'F' ? 2.5 : 0.3 + direction_deg / 10;  // F has three digits too
        const WindSample sent{.u_mps = -speed_mps * std::cos(direction_deg * kRadians),
                              .v_mps = speed_mps * std::sin(direction_deg * kRadians)};
        DecoderUnderTest decoder(kWindSonicDialect);
        decoder.feed(text_of(encode_wind_sonic(sent, {.mode = mode, .unit = unit})));
        ASSERT_EQ(decoder.samples().size(), 1U);
        const double resolution_mps = 0.0051 + (mode == Mode::uv ? 0 : speed_mps * 0.51 * kRadians);
        EXPECT_NEAR(decoder.wind(0).u_mps, sent.u_mps, resolution_mps);
        EXPECT_NEAR(decoder.wind(0).v_mps, sent.v_mps, resolution_mps);
      }
    }
  }
}

TEST(WindSonic, InvalidSamplesRoundTripInEveryMode) {
  using Mode = WindSonicFormat::Mode;
  for (const auto mode : {Mode::uv, Mode::polar, Mode::nmea}) {
    for (const bool fixed : {false, true}) {
      const WindSample sent{.device_status = 4, .valid = false};
      DecoderUnderTest decoder(kWindSonicDialect);
      decoder.feed(text_of(encode_wind_sonic(sent, {.mode = mode, .fixed_fields = fixed, .nmea_status_is_gill = true})));
      ASSERT_EQ(decoder.samples().size(), 1U);
      EXPECT_FALSE(decoder.wind(0).valid);
      EXPECT_EQ(decoder.wind(0).device_status, 4);
    }
  }
}

}  // namespace
}  // namespace roseau::wire
