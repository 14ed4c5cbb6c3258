// Real recordings through the whole path. Skipped where they are absent.

#include <gmock/gmock.h>

#include <ostream>

#include "tests/support/data.h"
#include "tests/system/daemon/program.h"

namespace roseau::testing {
namespace {

class RealRecordingsTest : public ProgramTest {
 protected:
  nlohmann::json import_and_replay(std::vector<std::string> what) const {
    what.insert(what.begin(), {"import", "-o", path("s.mcap")});
    const auto imported = run(what);
    EXPECT_EQ(imported.status, 0) << imported.err;
    const auto replayed = run({"replay", path("s.mcap"), "--max", "--headless", "--json"});
    EXPECT_EQ(replayed.status, 0) << replayed.err;
    return replayed.json();
  }
  void expect_frames(const std::string& video, int frames) const {
    const auto json = import_and_replay({"--video", video});
    EXPECT_EQ(json["streams"]["/camera0/image"]["received"], frames);
    EXPECT_EQ(json["streams"]["/camera0/image"]["dropped"], 0);
    EXPECT_EQ(json["streams"]["/camera0/motion"]["received"], frames);
  }
};

TEST_F(RealRecordingsTest, ShrubWhoseHeaderLies) {
  ROSEAU_REQUIRE_DATA(video, "data/video_tree_opencv/tree.avi");
  expect_frames(video.string(), 68);
}

TEST_F(RealRecordingsTest, SameShrubFromDebian) {
  const std::filesystem::path video = "/usr/share/doc/opencv-doc/examples/data/tree.avi";
  if (!std::filesystem::exists(video)) GTEST_SKIP() << "Debian's opencv-doc is not installed";
  expect_frames(video.string(), 68);
}

TEST_F(RealRecordingsTest, PotPlant) {
  ROSEAU_REQUIRE_DATA(video, "data/video_plants/plants.avi");
  expect_frames(video.string(), 150);
}

TEST_F(RealRecordingsTest, HohesHolzSonicAsEddyProHasIt) {
  ROSEAU_REQUIRE_DATA(sonic, "data/sonic_dehoh_rflux/DE-HoH_EC_201907301200_v01.csv");
  const auto json = import_and_replay({"--sonic", sonic.string(), "--sonic-rate", "20", "--north-offset", "235"});
  EXPECT_EQ(json["streams"]["/sonic/wind"]["received"], 36000);
  EXPECT_EQ(json["streams"]["/sonic/wind"]["dropped"], 0);
  const auto wind = run({"info", path("s.mcap"), "--json"}).json()["wind"]["/sonic/wind"];
  EXPECT_NEAR(wind["unit_vector_mean_direction_deg"], 292.276, 0.0005);
  EXPECT_NEAR(wind["vector_mean_speed_mps"], 3.337, 0.0005);
  EXPECT_NEAR(wind["scalar_mean_speed_3d_mps"], 3.850, 0.0005);
  EXPECT_NEAR(wind["scalar_mean_speed_horizontal_mps"], 3.678, 0.0005);
  const auto text = run({"info", path("s.mcap")}).out;
  EXPECT_THAT(text, ::testing::HasSubstr("292.276 deg"));
  EXPECT_THAT(text, ::testing::HasSubstr("3.337 m/s"));
}

struct Decay {
  const char* file;
  double low_hz;  // of the spectral peaks stated with the data
  double high_hz;
};
// Names the test's parameter, where GoogleTest would print bytes.
void PrintTo(const Decay& decay, std::ostream* out) { *out << decay.file; }

class PullAndReleaseTest : public RealRecordingsTest, public ::testing::WithParamInterface<Decay> {};

TEST_P(PullAndReleaseTest, NaturalFrequencyAgreesWithTheStatedPeak) {
  ROSEAU_REQUIRE_DATA(file, std::string("data/tree_pull_release/") + GetParam().file);
  const auto imported =
      run({"import", "-o", path("s.mcap"), "--displacement", "tree=" + file.string(), "--rate", "4", "--unit", "strain"});
  ASSERT_EQ(imported.status, 0) << imported.err;
  const auto ran = run({"estimate", path("s.mcap"), "--free-decay", "--band", "0.12:0.4", "--json"});
  ASSERT_EQ(ran.status, 0) << ran.err;
  const auto tree = ran.json()["targets"]["tree"];
  const double found_hz = tree["natural_frequency_hz"];
  const double resolution_hz = tree["resolution_hz"];
  EXPECT_GT(found_hz, GetParam().low_hz - resolution_hz);
  EXPECT_LT(found_hz, GetParam().high_hz + resolution_hz);
  EXPECT_NEAR(found_hz, tree["spectral_peak_hz"].get<double>(), resolution_hz);
  EXPECT_GT(tree["natural_frequency_sd_hz"].get<double>(), 0);
  EXPECT_GT(tree["damping_ratio"].get<double>(), 0.005);
  EXPECT_LT(tree["damping_ratio"].get<double>(), 0.15);
  EXPECT_GT(tree["damping_ratio_sd"].get<double>(), 0);
}

INSTANTIATE_TEST_SUITE_P(All, PullAndReleaseTest,
                         ::testing::Values(Decay{"T14_P1_winter.txt", 0.241, 0.241}, Decay{"T14_P2_winter.txt", 0.241, 0.241},
                                           Decay{"T14_P3_winter.txt", 0.202, 0.202}, Decay{"T14_P4_winter.txt", 0.202, 0.202},
                                           Decay{"T14_P1_summer.txt", 0.16, 0.19}, Decay{"T14_P2_summer.txt", 0.16, 0.19},
                                           Decay{"T14_P3_summer.txt", 0.16, 0.19}, Decay{"T16_P1_winter.txt", 0.28, 0.32},
                                           Decay{"T16_P2_winter.txt", 0.28, 0.32}, Decay{"T16_P1_summer.txt", 0.23, 0.26},
                                           Decay{"T16_P2_summer.txt", 0.23, 0.26}, Decay{"T16_P3_summer.txt", 0.23, 0.26}));

}  // namespace
}  // namespace roseau::testing
