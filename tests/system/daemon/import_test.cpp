// Imported logs through the whole program: import, verify, replay.
#include <gmock/gmock.h>

#include <cmath>
#include <string>

#include "tests/support/data.h"
#include "tests/system/daemon/program.h"

namespace roseau::testing {
namespace {

using ::testing::HasSubstr;

class ImportTest : public ProgramTest {
 protected:
  /// What replaying the imported files says, after they were verified.
  nlohmann::json import_and_replay(std::vector<std::string> what) const {
    what.insert(what.begin(), {"import", "-o", path("s.mcap"), "--json"});
    const auto imported = run(what);
    EXPECT_EQ(imported.status, 0) << imported.err;
    const auto verified = run({"verify", path("s.mcap")});
    EXPECT_EQ(verified.status, 0) << verified.out << verified.err;
    const auto first = run({"replay", path("s.mcap"), "--max", "--headless", "--json"});
    EXPECT_EQ(first.status, 0) << first.err;
    const auto second = run({"replay", path("s.mcap"), "--max", "--headless", "--json"});
    EXPECT_EQ(first.json()["digest"], second.json()["digest"]);
    auto json = first.json();
    json["import"] = imported.json();
    return json;
  }
};

std::string sentence(const std::string& body) {
  unsigned sum = 0;
  for (const char c : body) sum ^= static_cast<unsigned char>(c);
  constexpr std::string_view kDigits = "0123456789ABCDEF";
  return "$" + body + "*" + kDigits[sum / 16] + kDigits[sum % 16] + "\r\n";
}

TEST_F(ImportTest, NmeaLog) {
  std::string log;
  for (int i = 0; i < 60; ++i) {
    const auto second = (i < 10 ? "0" : "") + std::to_string(i);
    log += "2024-05-01 10:00:" + second + " " + sentence("WIMWV," + std::to_string(i) + ",R,2.5,M,A");
    log += "2024-05-01 10:00:" + second + ".5 " + sentence("WIXDR,C,21.5,C,0");
  }
  const auto json = import_and_replay({"--sonic", "mast=" + folder_.write("log.txt", log), "--north-offset", "30"});
  EXPECT_EQ(json["streams"]["/mast/raw"]["received"], 120);
  EXPECT_EQ(json["streams"]["/mast/wind"]["received"], 60) << "decoded by replay as it was by the import";
  EXPECT_EQ(json["import"]["streams"]["/mast/wind"]["samples"], 60);
}

TEST_F(ImportTest, Toa5WithATrackerOfAnotherFormat) {
  const std::string toa5 =
      "\"TOA5\",\"mast\",\"CR3000\",\"2113\",\"CR3000.Std.11\",\"CPU:eddy.CR3\",\"32171\",\"ts_data\"\r\n"
      "\"TIMESTAMP\",\"RECORD\",\"Ux\",\"Uy\",\"Uz\",\"Ts\"\r\n\"TS\",\"RN\",\"m/s\",\"m/s\",\"m/s\",\"C\"\r\n"
      "\"\",\"\",\"Smp\",\"Smp\",\"Smp\",\"Smp\"\r\n"
      "\"2019-07-30 12:00:00\",1,1.5,-2.5,0.1,21.5\r\n\"2019-07-30 12:00:00.1\",2,1.5,-2.5,0.1,21.5\r\n";
  const std::string matrices = "1 0 0 1\n0 1 0 2\n0 0 1 3\n0 0 0 1\n\n1 0 0 1\n0 1 0 2\n0 0 1 3\n0 0 0 1\n";
  const auto json = import_and_replay({"--sonic", folder_.write("a.dat", toa5), "--format", "toa5", "--tracker",
                                       "hand=" + folder_.write("a.traj", matrices), "--format", "fastrak_matrices"});
  EXPECT_EQ(json["streams"]["/sonic/wind"]["received"], 2);
  EXPECT_EQ(json["streams"]["/hand/station1/pose"]["received"], 2);
}

TEST_F(ImportTest, WrongUseIsExplained) {
  const auto log = folder_.write("log.txt", "hello\n");
  const auto unclear = run({"import", "-o", path("s.mcap"), "--sonic", log});
  EXPECT_EQ(unclear.status, 1);
  EXPECT_THAT(unclear.err, HasSubstr("its format is not clear from its beginning, 'hello'"));
  const auto unknown = run({"import", "-o", path("s.mcap"), "--sonic", log, "--format", "toa6"});
  EXPECT_EQ(unknown.status, 1);
  EXPECT_THAT(unknown.err, HasSubstr("format 'toa6' is not known"));
  const auto other = run({"import", "-o", path("s.mcap"), "--sonic", log, "--format", "liberty"});
  EXPECT_EQ(other.status, 1);
  EXPECT_THAT(other.err, HasSubstr("--format liberty is of --tracker, and none is given"));
  const auto twice =
      run({"import", "-o", path("s.mcap"), "--sonic", log, "--sonic", log, "--format", "nmea", "--sonic-rate", "1"});
  EXPECT_EQ(twice.status, 1);
}

TEST_F(ImportTest, TriSonicaArrayOnOneTimeAxis) {
  ROSEAU_REQUIRE_DATA(folder, "data/sonic_trisonica_array");
  const auto json = import_and_replay(
      {"--sonic", "A=" + (folder / "sensor_A.txt").string(), "--sonic", "B=" + (folder / "sensor_B.txt").string()});
  EXPECT_EQ(json["streams"]["/A/wind"]["received"], 21118);
  EXPECT_EQ(json["streams"]["/B/wind"]["received"], 21120);
  EXPECT_EQ(json["streams"]["/A/wind"]["dropped"], 0);
  // Both saw the same weather, in their axes as they are: what their compasses say would set them 127 degrees apart.
  const auto wind = run({"info", path("s.mcap"), "--json"}).json()["wind"];
  const double a_deg = wind["/A/wind"]["unit_vector_mean_direction_deg"];
  const double b_deg = wind["/B/wind"]["unit_vector_mean_direction_deg"];
  EXPECT_LT(std::abs(std::remainder(a_deg - b_deg, 360)), 30) << a_deg << " " << b_deg;
}

TEST_F(ImportTest, TrackersOfTheLaboratory) {
  ROSEAU_REQUIRE_DATA(matrices, "data/em_polhemus_fastrak/user1_cup0.traj");
  ROSEAU_REQUIRE_DATA(liberty, "data/em_polhemus_liberty/Polhemus_90degY_2data.csv");
  const auto json = import_and_replay({"--tracker", "hand=" + matrices.string(), "--tracker", "knee=" + liberty.string()});
  EXPECT_EQ(json["streams"]["/hand/station1/pose"]["received"], 290);
  EXPECT_EQ(json["streams"]["/knee/station2/pose"]["received"], 2576);
}

}  // namespace
}  // namespace roseau::testing
