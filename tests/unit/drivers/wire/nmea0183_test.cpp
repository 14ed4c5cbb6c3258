#include "drivers/wire/nmea0183.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>

#include "core/wind_geometry.h"
#include "drivers/wire/make_decoder.h"
#include "tests/unit/drivers/wire/fed_decoder.h"

namespace roseau::wire {
namespace {

using namespace std::chrono_literals;

class Fed : public FedDecoder<NmeaDecoder> {
 public:
  explicit Fed(NmeaWindSource source = NmeaWindSource::mwv_relative, bool requires_checksum = true)
      : FedDecoder({.stream = 7, .source = source, .requires_checksum = requires_checksum}) {}
  const WindSample& wind(std::size_t index) const { return std::get<WindSample>(samples().at(index).payload); }
  double direction(std::size_t index) const { return wind_direction_deg(wind(index).u_mps, wind(index).v_mps, 0); }
  double speed(std::size_t index) const { return std::hypot(wind(index).u_mps, wind(index).v_mps); }
};

TEST(Nmea, ReadsWindOfEveryUnit) {
  struct Case {
    std::string sentence;
    double angle_deg;
    double speed_mps;
  };
  // The first four were seen on real devices.
  for (const auto& expected :
       {Case{"$WIMWV,39,R,1.3,M,A*06", 39, 1.3}, Case{"$WIMWV,57.5,R,13.0,N,A*26", 57.5, 13 * 1852 / 3600.0},
        Case{"$WIMWV,214.8,R,0.1,K,A*28", 214.8, 0.1 / 3.6}, Case{"$WIMWV,61,R,1.0,M,A*08", 61, 1.0},
        Case{nmea_sentence("IIMWV,010,R,010.00,S,A"), 10, 4.4704}}) {
    Fed decoder;
    decoder.feed(expected.sentence + "\r\n");
    ASSERT_EQ(decoder.samples().size(), 1U) << expected.sentence << describe(decoder.counters());
    EXPECT_NEAR(decoder.direction(0), expected.angle_deg, 1e-9);
    EXPECT_NEAR(decoder.speed(0), expected.speed_mps, 1e-9);
    EXPECT_TRUE(decoder.wind(0).valid);
  }
}

TEST(Nmea, RelativeAndTrueAreNotMixed) {
  const std::string both =
      "$WIMWV,73.7,R,11.1,N,A*21\r\n$WIMWV,96.6,T,11.2,N,A*2E\r\n$WIMWD,328.2,T,326.8,M,11.2,N,5.8,M*61\r\n";
  Fed relative;
  relative.feed(both);
  ASSERT_EQ(relative.samples().size(), 1U);
  EXPECT_NEAR(relative.direction(0), 73.7, 1e-9);
  EXPECT_EQ(describe(relative.counters()), "good 1 bad 0 skipped 0 text 2");
  Fed absolute(NmeaWindSource::mwv_true);
  absolute.feed(both);
  ASSERT_EQ(absolute.samples().size(), 1U);
  EXPECT_NEAR(absolute.direction(0), 96.6, 1e-9);
}

TEST(Nmea, ReadsMda) {
  const std::string body = "WIMDA,29.7544,I,1.0076,B,35.5,C,,,42.1,,20.6,C,116.4,T,107.7,M,1.2,N,0.6,M";
  const auto weather = parse_nmea_mda(body);
  ASSERT_TRUE(weather);
  EXPECT_NEAR(weather->pressure_hpa, 1007.6, 1e-9);
  EXPECT_EQ(weather->air_temperature_celsius, 35.5);
  EXPECT_EQ(weather->relative_humidity_percent, 42.1);
  Fed decoder(NmeaWindSource::mda);
  decoder.feed("$" + body + "*66\r\n");
  ASSERT_EQ(decoder.samples().size(), 1U);
  EXPECT_NEAR(decoder.direction(0), 116.4, 1e-9);
  EXPECT_NEAR(decoder.speed(0), 0.6, 1e-9);
}

TEST(Nmea, ReadsXdr) {
  const auto xdr = parse_nmea_xdr("IIXDR,C,,C,AIRTEMP,A,-1.0,D,HEEL,A,2.9,D,TRIM,P,,B,BARO,A,-3.9,D,RUDDER");
  ASSERT_TRUE(xdr);
  ASSERT_EQ(xdr->transducers.size(), 5U);
  EXPECT_TRUE(std::isnan(xdr->transducers[0].value));
  EXPECT_EQ(xdr->transducers[1].value, -1.0);
  EXPECT_EQ(xdr->transducers[1].name, "HEEL");
  EXPECT_FALSE(parse_nmea_xdr("IIXDR,C,,C")) << "a group cut short";
  // Minimum, average and maximum, as Vaisala sends them.
  Fed decoder(NmeaWindSource::xdr);
  decoder.feed(nmea_sentence("WIXDR,A,302,D,0,A,320,D,1,A,330,D,2,S,0.1,M,0,S,0.2,M,1,S,0.3,M,2"));
  decoder.feed("$APXDR,A,3.866,D,ROLL*62\r\n");
  ASSERT_EQ(decoder.samples().size(), 1U);
  EXPECT_NEAR(decoder.direction(0), 320, 1e-9);
  EXPECT_NEAR(decoder.speed(0), 0.2, 1e-9);
  EXPECT_EQ(describe(decoder.counters()), "good 1 bad 0 skipped 0 text 1") << "roll is no wind";
}

TEST(Nmea, WhatIsMissingIsNotValid) {
  Fed decoder;
  decoder.feed(nmea_sentence("WIMWV,,R,,M,V") + nmea_sentence("WIMWV,120,R,2.1,M,V") + nmea_sentence("WIMWV,,R,,,V") +
               nmea_sentence("WIMWV,,R,0.4,M,A"));
  ASSERT_EQ(decoder.samples().size(), 4U);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_FALSE(decoder.wind(i).valid) << i;
    EXPECT_TRUE(std::isnan(decoder.wind(i).u_mps)) << i;
    EXPECT_EQ(decoder.samples()[i].header.status, kStatusDeviceError);
  }
  Fed calm;
  calm.feed(nmea_sentence("WIMWV,,R,0.0,M,A"));
  EXPECT_EQ(calm.wind(0).u_mps, 0);
  EXPECT_TRUE(calm.wind(0).valid);
}

TEST(Nmea, WhatMakesNoSenseIsCounted) {
  for (const char* body :
       {"WIMWV,400,R,1.0,M,A", "WIMWV,-10,R,1.0,M,A", "WIMWV,10,R,101,M,A", "WIMWV,10,R,1.0,X,A", "WIMWV,10,R,1.0,M,Q",
        "WIMWV,10,R,1.0,M", "WIMWV,10,R,1.0,M,A,1", "WIMWV,1e2,R,1,M,A", "WIMWV,nan,R,1,M,A", "WIMWV"}) {
    Fed decoder;
    decoder.feed(nmea_sentence(body));
    EXPECT_TRUE(decoder.samples().empty()) << body;
    EXPECT_EQ(decoder.counters().bad_records, 1U) << body;
  }
}

TEST(Nmea, WrongAndMissingChecksums) {
  for (const char* sentence :
       {"$WIMWV,39,R,1.3,M,A*07", "$WIMWV,39,R,1.4,M,A*06", "$WIMWV,39,R,1.3,M,A", "$WIMWV,39,R,1.3,M,A*0"}) {
    Fed decoder;
    decoder.feed(std::string(sentence) + "\r\n$WIMWV,61,R,1.0,M,A*08\r\n");
    ASSERT_EQ(decoder.samples().size(), 1U) << sentence;
    EXPECT_NEAR(decoder.direction(0), 61, 1e-9) << sentence;
    EXPECT_EQ(decoder.counters().bad_records, 1U) << sentence;
  }
  Fed lenient(NmeaWindSource::mwv_relative, false);
  lenient.feed("$WIMWV,39,R,1.3,M,A\r\n$WIMWV,39,R,1.3,M,A*07\r\n$WIMWV,61,R,1.0,M,A*08\r\n");
  EXPECT_EQ(lenient.samples().size(), 2U) << "a wrong checksum is wrong all the same";
}

TEST(Nmea, CivilTimes) {
  const auto new_year = std::chrono::sys_days(std::chrono::year{2025} / 1 / 1).time_since_epoch();
  EXPECT_EQ(parse_nmea_time("GPZDA,235959.50,31,12,2024,-1,00"), new_year - 500ms);
  EXPECT_EQ(parse_nmea_time("GPZDA,000000.00,01,01,2025,,"), new_year);
  EXPECT_EQ(parse_nmea_time("GPRMC,000001,A,4807.038,N,01131.000,E,022.4,084.4,010125,003.1,W"), new_year + 1s);
  EXPECT_FALSE(parse_nmea_time("GPRMC,000001,V,4807.038,N,01131.000,E,022.4,084.4,010125,003.1,W")) << "no fix";
  for (const char* bad :
       {"GPZDA,240000,01,01,2025,,", "GPZDA,000000,30,02,2025,,", "GPZDA,,01,01,2025,,", "GPZDA,00000,01,01,2025,,",
        "GPRMC,000001,A,,,,,,,0101,,", "WIMWV,39,R,1.3,M,A", "GPZDA,00-100,01,01,2025,,"}) {
    EXPECT_FALSE(parse_nmea_time(bad)) << bad;
  }
  const auto encoded = encode_nmea_zda(new_year - 500ms);
  EXPECT_EQ(encoded.substr(0, encoded.find('*')), "$GPZDA,235959.500,31,12,2024,00,00");
  EXPECT_EQ(parse_nmea_time(*nmea_body(encoded.substr(0, encoded.size() - 2))), new_year - 500ms);
}

TEST(Nmea, WhatIsEncodedIsReadAgain) {
  for (const auto source : {NmeaWindSource::mwv_relative, NmeaWindSource::mwv_true, NmeaWindSource::mda, NmeaWindSource::xdr}) {
    const Vec2 wind = wind_components_mps(7.25, 359.98, 0);
    Fed decoder(source);
    decoder.feed(encode_nmea_wind({.u_mps = wind.x, .v_mps = wind.y}, source) + encode_nmea_wind({.valid = false}, source));
    ASSERT_EQ(decoder.samples().size(), 2U) << to_string(source) << describe(decoder.counters());
    EXPECT_NEAR(decoder.speed(0), 7.25, 1e-9);
    EXPECT_NEAR(decoder.wind(0).u_mps, wind.x, 0.01);
    EXPECT_FALSE(decoder.wind(1).valid);
  }
}

TEST(Nmea, TroubleIsTheSameHoweverItIsCut) {
  const std::string good = "$WIMWV,39,R,1.3,M,A*06\r\n";
  const std::string text = good.substr(7) + good + "noise\r\n\r\n" + good.substr(0, 12) + good + "$" + std::string(700, 'A') +
                           "\r\n" + good + std::string(9, '\0') + good + "$$$" + good + "\xFF\xFE$WIMWV,39,R,1.3,M,A*0Z\r\n" +
                           good + "$WIM";
  Fed whole;
  whole.feed(text);
  EXPECT_EQ(whole.samples().size(), 6U);
  for (std::size_t size = 1; size < 90; ++size) {
    Fed cut;
    cut.feed_in_pieces(text, size);
    ASSERT_EQ(cut.samples().size(), whole.samples().size()) << size;
    for (std::size_t i = 0; i < cut.samples().size(); ++i) {
      EXPECT_EQ(cut.samples()[i].header.arrival_time, whole.samples()[i].header.arrival_time) << size;
    }
    EXPECT_EQ(describe(cut.counters()), describe(whole.counters())) << size;
  }
}

TEST(Nmea, IsMadeFromTheMetadataOfItsStream) {
  StreamTable streams;
  const auto raw = raw_stream("boat", NmeaOptions{.source = NmeaWindSource::mda}, "log");
  ASSERT_TRUE(make_decoder(raw, streams));
  EXPECT_TRUE(streams.find("/boat/wind"));
  auto broken = raw;
  broken.metadata["sentence"] = "vwr";
  EXPECT_FALSE(make_decoder(broken, streams));
}

}  // namespace
}  // namespace roseau::wire
