#include "drivers/wire/trisonica.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "core/wind_geometry.h"
#include "drivers/wire/make_decoder.h"
#include "tests/unit/drivers/wire/fed_decoder.h"

namespace roseau::wire {
namespace {

// As recorded in the field.
const std::string kLine =
    "S2  02.222 D  255 U  02.142 V  00.592 W  00.040 T  23.80 H  29.14 AD  0.9655064 AX    336 AY   -648 AZ  17176 MD  349";
const std::string kNext =
    "S2  01.871 D  276 U  01.861 V -00.201 W  00.091 T  23.74 H  29.23 AD  0.9656870 AX    280 AY   -616 AZ  17152 MD  350";
// The bytes in the middle were lost.
const std::string kMerged =
    "S2  02.008 D  255 U  01.942 V  00.510 W -00.049 T  23.68 H  29.S2  02.338 D  257 U  02.276 V  00.534 W -00.069 T  23.89 ";
const std::string kRest = "H  28.95 AD  0.9652169 AX    320 AY   -648 AZ  17136 MD  349";

class Fed : public FedDecoder<TriSonicaDecoder> {
 public:
  explicit Fed(std::optional<TriSonicaLayout> layout = default_trisonica_layout(), Duration delay = {})
      : FedDecoder({.stream = 7, .delay = delay, .layout = std::move(layout)}) {}
  const WindSample& wind(std::size_t index) const { return std::get<WindSample>(samples().at(index).payload); }
};

TEST(TriSonica, ReadsALineFromTheField) {
  Fed decoder(default_trisonica_layout(), std::chrono::milliseconds{50});
  decoder.feed("\r\n" + kLine + " \r\n");
  ASSERT_EQ(decoder.samples().size(), 1U);
  EXPECT_EQ(decoder.wind(0).u_mps, 2.142);
  EXPECT_EQ(decoder.wind(0).v_mps, 0.592);
  EXPECT_EQ(decoder.wind(0).w_mps, 0.040);
  EXPECT_EQ(decoder.wind(0).sonic_temperature_celsius, 23.80);
  EXPECT_TRUE(std::isnan(decoder.wind(0).speed_of_sound_mps));
  EXPECT_TRUE(decoder.wind(0).valid);
  const auto& header = decoder.samples()[0].header;
  EXPECT_EQ(header.arrival_time, kFirstArrival + 2 * kByteTime) << "that of the S";
  EXPECT_EQ(header.sample_time, header.arrival_time - std::chrono::milliseconds{50});
  EXPECT_EQ(header.stream, 7);
  EXPECT_EQ(describe(decoder.counters()), "good 1 bad 0 skipped 0 text 0");
}

TEST(TriSonica, ItsComponentsAgreeWithItsDirection) {
  const auto layout = default_trisonica_layout();
  for (const auto& line : {kLine, kNext}) {
    const auto values = parse_trisonica(line, layout);
    ASSERT_TRUE(values);
    const auto wind = trisonica_wind(*values, layout);
    EXPECT_NEAR(wind_direction_deg(wind->u_mps, wind->v_mps, 0, WindAxes::east_north), (*values)[1], 1);
    EXPECT_NEAR(std::hypot(wind->u_mps, wind->v_mps), (*values)[0], 0.002);
  }
}

TEST(TriSonica, ALayoutIsReadFromALineAndFromText) {
  const auto layout = TriSonicaLayout::of_line(kLine);
  ASSERT_TRUE(layout);
  EXPECT_EQ(layout->text(), "S2:3,D:0,U:3,V:3,W:3,T:2,H:2,AD:7,AX:0,AY:0,AZ:0,MD:0");
  EXPECT_EQ(*TriSonicaLayout::parse(layout->text()), *layout);
  for (const char* bad : {"", "U:3", "U:3,V:3,U:3", "U,V", "u:3,v:3", "U:33,V:3", "T:2,H:2"}) {
    EXPECT_FALSE(TriSonicaLayout::parse(bad)) << bad;
  }
}

TEST(TriSonica, AMergedLineGivesTheWholeRecordAtItsEnd) {
  Fed decoder;
  decoder.feed(kMerged + kRest + " \r\n" + kLine + "\r\n");
  ASSERT_EQ(decoder.samples().size(), 2U);
  EXPECT_EQ(decoder.wind(0).u_mps, 2.276);
  EXPECT_EQ(decoder.samples()[0].header.arrival_time,
            kFirstArrival + kByteTime * static_cast<Duration::rep>(kMerged.find("S2  02.338")));
  EXPECT_EQ(describe(decoder.counters()), "good 2 bad 1 skipped 63 text 0");
}

TEST(TriSonica, PartsOfLinesAreNoRecords) {
  for (const auto& line : {kMerged, kRest, kLine.substr(0, 60), kLine.substr(0, kLine.size() - 9), kLine.substr(4),
                           kLine + "9.", kLine + " X", std::string("S2  02.2")}) {
    Fed decoder;
    decoder.feed(line + "\r\n");
    EXPECT_TRUE(decoder.samples().empty()) << line;
    EXPECT_EQ(decoder.counters().bad_records, 1U) << line;
    EXPECT_EQ(decoder.counters().skipped_bytes, line.size() + 1) << line;
  }
}

TEST(TriSonica, ALostDecimalIsNoticed) {
  auto line = kLine;
  line.erase(line.find("00.592") + 5, 1);
  Fed decoder;
  decoder.feed(line + "\r\n");
  EXPECT_TRUE(decoder.samples().empty());
}

TEST(TriSonica, LearnsTheLayoutFromTwoLinesThatAgree) {
  Fed decoder(std::nullopt);
  decoder.feed("TriSonica Mini\r\n" + kRest + "\r\n" + kLine + "\r\n");
  EXPECT_TRUE(decoder.samples().empty());
  decoder.feed(kNext + "\r\n" + kLine + "\r\n");
  EXPECT_EQ(decoder.samples().size(), 2U);
  EXPECT_EQ(decoder.wind(0).u_mps, 1.861);
}

TEST(TriSonica, AnInstrumentSetUpAnewIsReadOn) {
  const auto short_layout = TriSonicaLayout::parse("S:2,D:0,U:2,V:2,W:2,T:2").value();
  const auto line =
      encode_trisonica({.u_mps = 1.5, .v_mps = -2.25, .w_mps = 0.5, .sonic_temperature_celsius = 20}, short_layout);
  EXPECT_EQ(line, "S  02.75 D  326 U  01.50 V -02.25 W  00.50 T  20.00\r\n");
  Fed decoder;
  decoder.feed(kLine + "\r\n" + line + line + line);
  ASSERT_EQ(decoder.samples().size(), 3U) << "the first line with the new layout is not trusted yet";
  EXPECT_EQ(decoder.wind(1).v_mps, -2.25);
}

TEST(TriSonica, WhatWasNotMeasuredIsNotValid) {
  const auto layout = TriSonicaLayout::parse("S2:2,D:0,U:2,V:2,W:2,T:2").value();
  Fed decoder(layout);
  decoder.feed("S2 -99.99 D  -99 U -99.99 V -99.99 W -99.99 T -99.99\r\n");
  ASSERT_EQ(decoder.samples().size(), 1U);
  EXPECT_FALSE(decoder.wind(0).valid);
  EXPECT_TRUE(std::isnan(decoder.wind(0).u_mps));
  EXPECT_EQ(decoder.samples()[0].header.status, kStatusDeviceError);
  decoder.feed("S2  150.00 D  010 U  150.00 V  00.00 W  00.00 T  20.00\r\n");
  EXPECT_EQ(decoder.samples().size(), 1U);
  EXPECT_EQ(decoder.counters().bad_records, 1U) << "150 m/s make no sense";
}

TEST(TriSonica, SpeedAndDirectionWillDoWithoutComponents) {
  Fed decoder(TriSonicaLayout::parse("S2:2,D:0").value());
  decoder.feed("S2  02.00 D  270\r\n");
  ASSERT_EQ(decoder.samples().size(), 1U);
  EXPECT_NEAR(decoder.wind(0).u_mps, 2, 1e-12) << "from the west";
  EXPECT_NEAR(decoder.wind(0).v_mps, 0, 1e-12);
  EXPECT_TRUE(std::isnan(decoder.wind(0).w_mps));
}

TEST(TriSonica, WhatIsEncodedIsReadAgain) {
  const auto layout = default_trisonica_layout();
  const WindSample sent{.u_mps = -12.345, .v_mps = 0.004, .w_mps = -0.5, .sonic_temperature_celsius = -7.25};
  const auto line = encode_trisonica(sent, layout, {{"H", 55.5}, {"MD", 7}, {"AY", -648}});
  EXPECT_NE(line.find("AY   -648"), std::string::npos) << line;
  EXPECT_NE(line.find("MD  007\r\n"), std::string::npos) << line;
  Fed decoder;
  decoder.feed(line);
  ASSERT_EQ(decoder.samples().size(), 1U) << line;
  EXPECT_EQ(decoder.wind(0).u_mps, -12.345);
  EXPECT_EQ(decoder.wind(0).v_mps, 0.004);
  EXPECT_EQ(decoder.wind(0).sonic_temperature_celsius, -7.25);
}

TEST(TriSonica, TroubleIsTheSameHoweverItIsCut) {
  const std::string text = kLine.substr(50) + "\r\n" + kLine + "\r\n" + std::string(900, 'x') + kLine + "\r\n" + kMerged +
                           kRest + "\n\n" + kNext + "\r" + std::string(5, '\0') + kLine + "\r\n" + "\xFF\xFE" + kNext + "\r\n" +
                           kLine;
  Fed whole;
  whole.feed(text);
  EXPECT_EQ(whole.samples().size(), 6U) << "the last line has not ended yet";
  for (std::size_t size = 1; size < 140; ++size) {
    Fed cut;
    cut.feed_in_pieces(text, size);
    ASSERT_EQ(cut.samples().size(), whole.samples().size()) << size;
    for (std::size_t i = 0; i < cut.samples().size(); ++i) {
      EXPECT_EQ(cut.samples()[i].header.arrival_time, whole.samples()[i].header.arrival_time) << size;
    }
    EXPECT_EQ(describe(cut.counters()), describe(whole.counters())) << size;
  }
}

TEST(TriSonica, IsMadeFromTheMetadataOfItsStream) {
  StreamTable streams;
  const auto raw = raw_stream("mast", TriSonicaOptions{.layout = default_trisonica_layout(), .north_offset_deg = 12}, "serial");
  ASSERT_TRUE(make_decoder(raw, streams));
  const auto wind = streams.find("/mast/wind");
  ASSERT_TRUE(wind);
  EXPECT_EQ(streams.info(*wind).metadata.at("axes"), "east_north");
  EXPECT_EQ(streams.info(*wind).metadata.at("north_offset_deg"), "12");
  auto broken = raw;
  broken.metadata["items"] = "what";
  EXPECT_FALSE(make_decoder(broken, streams));
}

}  // namespace
}  // namespace roseau::wire
