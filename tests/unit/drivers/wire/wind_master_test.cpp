#include "drivers/wire/wind_master.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/unit/drivers/wire/decoder_support.h"

namespace roseau::wire {
namespace {

constexpr double kRadians = std::numbers::pi / 180.0;

DecoderUnderTest decoded(std::string_view text) {
  DecoderUnderTest decoder(kWindMasterDialect);
  decoder.feed(text);
  return decoder;
}

DecoderUnderTest decoded_message(std::string_view text) {
  DecoderUnderTest decoder(GillDecoder::Options{.keeps_messages_apart = true, .dialect = kWindMasterDialect});
  decoder.feed(text);
  return decoder;
}

const std::string kUvw = "Q,+000.04,-000.04,+000.06,M,+347.06,+025.88,00,";

TEST(WindMaster, ReadsComponentsOfAFieldInstrument) {
  const auto decoder = decoded(framed(kUvw, "28"));
  ASSERT_EQ(decoder.samples().size(), 1U);
  const auto& wind = decoder.wind(0);
  EXPECT_TRUE(wind.valid);
  EXPECT_DOUBLE_EQ(wind.u_mps, 0.04);
  EXPECT_DOUBLE_EQ(wind.v_mps, -0.04);
  EXPECT_DOUBLE_EQ(wind.w_mps, 0.06);
  EXPECT_DOUBLE_EQ(wind.speed_of_sound_mps, 347.06);
  EXPECT_DOUBLE_EQ(wind.sonic_temperature_celsius, 25.88);
  EXPECT_EQ(text_of(encode_wind_master(wind, {})), framed(kUvw, "28"));
}

struct PolarVector {
  std::string body;
  std::string checksum;
  double direction_deg;
  double speed_mps;
  double w_mps;
  double speed_of_sound_mps;
  double temperature_celsius;
  std::vector<double> analogue_inputs;
};

class WindMasterPolar : public ::testing::TestWithParam<PolarVector> {};

INSTANTIATE_TEST_SUITE_P(
    Verified, WindMasterPolar,
    ::testing::Values(PolarVector{"Q,335.3,001.261,-001.282,M,+345.41,+023.05,00,+2.4181,+2.4181,+2.4162,+2.4175,-50.00C,",
                                  "78",
                                  335.3,
                                  1.261,
                                  -1.282,
                                  345.41,
                                  23.05,
                                  {2.4181, 2.4181, 2.4162, 2.4175}},
                      PolarVector{"Q,251.7,000.860,-000.401,M,+346.43,+024.80,00,+2.4181,+2.4187,+2.4169,+2.4175,-50.00C,",
                                  "7F",
                                  251.7,
                                  0.860,
                                  -0.401,
                                  346.43,
                                  24.80,
                                  {2.4181, 2.4187, 2.4169, 2.4175}}));

TEST_P(WindMasterPolar, DecodesIntoComponents) {
  const auto& vector = GetParam();
  const auto decoder = decoded(framed(vector.body, vector.checksum));
  ASSERT_EQ(decoder.samples().size(), 1U);
  const auto& wind = decoder.wind(0);
  EXPECT_NEAR(wind.u_mps, -vector.speed_mps * std::cos(vector.direction_deg * kRadians), 1e-12);
  EXPECT_NEAR(wind.v_mps, vector.speed_mps * std::sin(vector.direction_deg * kRadians), 1e-12);
  EXPECT_DOUBLE_EQ(wind.w_mps, vector.w_mps);
  EXPECT_DOUBLE_EQ(wind.speed_of_sound_mps, vector.speed_of_sound_mps);
  EXPECT_DOUBLE_EQ(wind.sonic_temperature_celsius, vector.temperature_celsius);
}

TEST_P(WindMasterPolar, IsEncodedAsTheInstrumentPrintsIt) {
  const auto& vector = GetParam();
  const auto decoder = decoded(framed(vector.body, vector.checksum));
  const WindMasterFormat format{.mode = WindMasterFormat::Mode::polar,
                                .high_resolution = true,
                                .analogue_inputs = vector.analogue_inputs,
                                .platinum_celsius = -50.0};
  EXPECT_EQ(text_of(encode_wind_master(decoder.wind(0), format)), framed(vector.body, vector.checksum));
}

TEST(WindMaster, FailedPathsGiveNoWind) {
  const std::string inputs = "+2.4181,+2.4187,+2.4162,+2.4175,-50.00C,";
  const std::string empty = framed("Q,,,,M,,,07," + inputs, "72");
  const std::string nines =
      framed("Q,999.9,999.999,+999.999,M,+999.99,+999.99,07,+2.4181,+2.4187,+2.4169,+2.4181,-50.00C,", "77");
  for (const auto& record : {empty, nines}) {
    const auto decoder = decoded(record);
    ASSERT_EQ(decoder.samples().size(), 1U);
    EXPECT_FALSE(decoder.wind(0).valid);
    EXPECT_EQ(decoder.wind(0).device_status, 7);
    EXPECT_TRUE(std::isnan(decoder.wind(0).u_mps));
    EXPECT_TRUE(std::isnan(decoder.wind(0).speed_of_sound_mps));
    EXPECT_EQ(decoder.samples()[0].header.status, kStatusDeviceError);
  }
  const WindSample failed{.device_status = 7, .valid = false};
  WindMasterFormat format{.mode = WindMasterFormat::Mode::polar,
                          .high_resolution = true,
                          .analogue_inputs = {2.4181, 2.4187, 2.4162, 2.4175},
                          .platinum_celsius = -50.0};
  EXPECT_EQ(text_of(encode_wind_master(failed, format)), empty);
  format.fixed_fields = true;
  format.analogue_inputs = {2.4181, 2.4187, 2.4169, 2.4181};
  EXPECT_EQ(text_of(encode_wind_master(failed, format)), nines);
}

TEST(WindMaster, TheManualsMisprintIsRejectedAndCounted) {
  const std::string body = "Q,-000.92,-000.24,+001.51,M,+344.39,+021.38,00,+2.4181,+2.4187,+2.4162,+2.4175,-50.00C,";
  const auto misprinted = decoded(framed(body, "47"));
  EXPECT_TRUE(misprinted.samples().empty());
  EXPECT_EQ(misprinted.counters().bad_records, 1U);
  const auto mended = decoded(framed(body, "49"));
  ASSERT_EQ(mended.samples().size(), 1U);
  EXPECT_DOUBLE_EQ(mended.wind(0).w_mps, 1.51);
}

TEST(WindMaster, MarginalStatesAreStillGood) {
  for (const char* status : {"0A", "0B"}) {
    const auto decoder = decoded(framed("Q,+000.04,-000.04,+000.06,M,+347.06,+025.88," + std::string(status) + ","));
    ASSERT_EQ(decoder.samples().size(), 1U) << status;
    EXPECT_TRUE(decoder.wind(0).valid) << status;
    EXPECT_EQ(decoder.wind(0).device_status, *parse_hex_byte(status));
  }
  for (const char* status : {"01", "02", "03", "04", "05", "06", "07", "08", "09", "10"}) {
    const auto decoder = decoded(framed("Q,+000.04,-000.04,+000.06,M,+347.06,+025.88," + std::string(status) + ","));
    ASSERT_EQ(decoder.samples().size(), 1U) << status;
    EXPECT_FALSE(decoder.wind(0).valid) << status;
  }
}

TEST(WindMaster, TakesEveryFieldCount) {
  const std::string wind = "Q,+001.00,-002.00,+003.00,M,";
  const std::string temperature = "+347.06,+025.88,";
  for (const auto& body : {wind + "00,", wind + "00", wind + temperature + "00,", wind + temperature + "00,-50.00C,",
                           wind + temperature + "00,+2.4181,", wind + "00,+2.4181,+2.4181,+2.4162,+2.4175,",
                           wind + "00,-50.00C,", wind + temperature + "00,+2.4181,-2.4181,+2.4162,+2.4175,-50.00C,"}) {
    const auto decoder = decoded(framed(body));
    ASSERT_EQ(decoder.samples().size(), 1U) << body;
    EXPECT_DOUBLE_EQ(decoder.wind(0).w_mps, 3.0) << body;
    EXPECT_EQ(std::isnan(decoder.wind(0).speed_of_sound_mps), body.find(temperature) == std::string::npos) << body;
  }
}

TEST(WindMaster, SenselessFieldsAreBadRecords) {
  const std::string wind = "Q,+001.00,-002.00,+003.00,M,";
  for (const auto& body :
       {wind, wind + "+347.06,", wind + "+347.06,00,", wind + "+347.06,+025.88,0,", wind + "00,+1.0,+1.0,+1.0,+1.0,+1.0,",
        wind + "00,-50.00C,+1.0,", wind + "00,28,", wind + "00,,,", std::string("Q,+001.00,-002.00,M,00,"),
        std::string("Q,+101.00,-002.00,+003.00,M,00,"), std::string("Q,+001.00,-002.00,+103.00,M,00,"),
        std::string("Q,+001.00,-002.00,+003.00,X,00,"), std::string("Q,+001.00,-002.00,abc,M,00,"),
        std::string("Q,400,002.00,+003.00,M,00,"), wind + "+999,+025.88,0,", wind + "+047.06,+025.88,00,"}) {
    const auto decoder = decoded(framed(body));
    EXPECT_TRUE(decoder.samples().empty()) << body;
    EXPECT_EQ(decoder.counters().bad_records, 1U) << body;
  }
}

TEST(WindMaster, SpacesThatSomeFirmwareLeavesAreNoHarm) {
  const auto decoder = decoded(framed("Q,+  0.04,-  0.24, +1.51,M,+347.06,+025.88,00,"));
  ASSERT_EQ(decoder.samples().size(), 1U);
  EXPECT_DOUBLE_EQ(decoder.wind(0).u_mps, 0.04);
  EXPECT_DOUBLE_EQ(decoder.wind(0).v_mps, -0.24);
  EXPECT_DOUBLE_EQ(decoder.wind(0).w_mps, 1.51);
}

TEST(WindMaster, ReadsTheBareLineThatLoggersPassOnByUdp) {
  for (const auto& line : {kUvw, kUvw + "28", kUvw + "\r\n", kUvw + "28\r\n", framed(kUvw)}) {
    const auto decoder = decoded_message(line);
    ASSERT_EQ(decoder.samples().size(), 1U) << line;
    EXPECT_DOUBLE_EQ(decoder.wind(0).u_mps, 0.04) << line;
    EXPECT_EQ(decoder.counters().bad_records, 0U) << line;
  }
  const auto wrong = decoded_message(kUvw + "29");
  EXPECT_TRUE(wrong.samples().empty());
  EXPECT_EQ(wrong.counters().bad_records, 1U);
  const WindMasterFormat format{.is_delimited = false, .ends_with_line = false};
  EXPECT_EQ(text_of(encode_wind_master(decoded_message(kUvw).wind(0), format)), kUvw);
}

TEST(WindMaster, MessagesDoNotRunIntoEachOther) {
  DecoderUnderTest decoder(GillDecoder::Options{.keeps_messages_apart = true, .dialect = kWindMasterDialect});
  for (int i = 0; i < 3; ++i) {
    decoder.feed(kUvw);
    decoder.feed("Q,+000.04,-000.04,+0");      // a message cut short
    decoder.feed("\x02Q,+000.04,-000.04,+0");  // and one with STX
  }
  EXPECT_EQ(decoder.samples().size(), 3U);
  EXPECT_EQ(decoder.counters().bad_records, 6U);
}

TEST(WindMaster, InAStreamABareLineNeedsItsChecksum) {
  EXPECT_TRUE(decoded(kUvw + "\r\n").samples().empty());
  EXPECT_EQ(decoded(kUvw + "28\r\n").samples().size(), 1U);
  EXPECT_EQ(decoded(kUvw + "\x03"
                           "28\r\n")
                .samples()
                .size(),
            1U);  // only STX lost
}

TEST(WindMaster, SurvivesAChangeOfModeInMidStream) {
  const auto decoder = decoded(framed(kUvw) + framed("Q,335,001.26,-001.28,M,+345.41,+023.05,00,") +
                               "CONFIGURATION MODE\r\nM1\r\n" + framed(kUvw) + framed("Q,+000.04,-000.04,+000.06,M,00,"));
  EXPECT_EQ(decoder.samples().size(), 4U);
  EXPECT_EQ(decoder.counters().bad_records, 0U);
}

TEST(WindMaster, BinaryOutputIsNoiseAndNoSamples) {
  const std::string big_endian = {'\xb2', '\xb2', 0, 0, '\xff', '\xa4', '\xff', '\xe8', 0, '\x97', '\x86', '\x87', '\xda'};
  std::string stream;
  for (int i = 0; i < 100; ++i) stream += big_endian;
  const auto decoder = decoded(stream + "\r\n" + framed(kUvw));
  EXPECT_EQ(decoder.samples().size(), 1U);
  EXPECT_EQ(decoder.counters().bad_records, 0U);
  EXPECT_EQ(decoder.counters().skipped_bytes, stream.size() + 2);
}

TEST(WindMaster, SpeedOfSoundMayFollowTheUnit) {
  const auto knots = decoded(framed("Q,+010.00,+000.00,+000.00,N,+668.68,+020.00,00,"));
  ASSERT_EQ(knots.samples().size(), 1U);
  EXPECT_NEAR(knots.wind(0).speed_of_sound_mps, 344.0, 0.01);
  EXPECT_NEAR(knots.wind(0).u_mps, 5.1444, 1e-4);
  const auto metres = decoded(framed("Q,+010.00,+000.00,+000.00,N,+344.00,+020.00,00,"));
  ASSERT_EQ(metres.samples().size(), 1U);
  EXPECT_NEAR(metres.wind(0).speed_of_sound_mps, 344.0, 1e-9);
}

TEST(WindMaster, RoundTripsInEveryMode) {
  using Mode = WindMasterFormat::Mode;
  for (const auto mode : {Mode::uvw, Mode::polar}) {
    for (const bool high_resolution : {false, true}) {
      for (double direction_deg = 0.25; direction_deg < 360; direction_deg += 3.7) {
        const double speed_mps = 0.2 + direction_deg / 10;
        const WindSample sent{.u_mps = -speed_mps * std::cos(direction_deg * kRadians),
                              .v_mps = speed_mps * std::sin(direction_deg * kRadians),
                              .w_mps = (direction_deg - 180) / 50,
                              .sonic_temperature_celsius = -12.34,
                              .speed_of_sound_mps = 323.45,
                              .device_status = 0x0A};
        const auto decoder = decoded(text_of(encode_wind_master(sent, {.mode = mode, .high_resolution = high_resolution})));
        ASSERT_EQ(decoder.samples().size(), 1U);
        const auto& got = decoder.wind(0);
        const double step = high_resolution ? 0.00051 : 0.0051;
        const double angle_step_deg = high_resolution ? 0.051 : 0.51;
        const double resolution_mps = step + (mode == Mode::uvw ? 0 : speed_mps * angle_step_deg * kRadians);
        EXPECT_NEAR(got.u_mps, sent.u_mps, resolution_mps);
        EXPECT_NEAR(got.v_mps, sent.v_mps, resolution_mps);
        EXPECT_NEAR(got.w_mps, sent.w_mps, step);
        EXPECT_DOUBLE_EQ(got.sonic_temperature_celsius, -12.34);
        EXPECT_DOUBLE_EQ(got.speed_of_sound_mps, 323.45);
        EXPECT_EQ(got.device_status, 0x0A);
      }
    }
  }
}

}  // namespace
}  // namespace roseau::wire
