#include "daemon/config.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <ostream>

#include "tests/support/temporary_folder.h"

namespace roseau::daemon {
namespace {

using ::testing::Each;
using ::testing::HasSubstr;
using ::testing::StartsWith;

const std::filesystem::path kConfigs = std::filesystem::path(ROSEAU_SOURCE_DIR) / "config";

Result<Config> parse(const std::string& text) { return parse_config(text, "field.toml", ROSEAU_SOURCE_DIR); }

TEST(Config, EveryExampleReads) {
  for (const char* name : {"reference.toml", "field.toml", "demo.toml", "unattended.toml"}) {
    const auto config = load_config(kConfigs / name);
    EXPECT_TRUE(config) << (config ? "" : config.error().message);
  }
}

TEST(Config, ReferenceNamesEveryKey) {
  std::vector<std::string> absent;
  const auto text = testing::read_text_file(kConfigs / "reference.toml");
  ASSERT_TRUE(parse_config(text, "reference.toml", kConfigs, &absent));
  // The simulation stands in place of devices: the file can only mention it.
  EXPECT_THAT(absent, Each(StartsWith("simulation")));
  EXPECT_THAT(text, HasSubstr("# scene ="));
  EXPECT_THAT(text, HasSubstr("# seed ="));
}

TEST(Config, ReferenceStatesTheDefaultsItClaims) {
  const auto reference = load_config(kConfigs / "reference.toml");
  ASSERT_TRUE(reference);
  const Config defaults;
  EXPECT_EQ(reference->window, defaults.window);
  EXPECT_EQ(reference->skip_after_frames, defaults.skip_after_frames);
  EXPECT_EQ(reference->tracking.options.feature_count, defaults.tracking.options.feature_count);
  EXPECT_EQ(reference->tracking.options.window_px, defaults.tracking.options.window_px);
  EXPECT_EQ(reference->tracking.options.search_radius_px, defaults.tracking.options.search_radius_px);
  EXPECT_EQ(reference->estimation.window_s, defaults.estimation.window_s);
  EXPECT_EQ(reference->estimation.first_window_s, defaults.estimation.first_window_s);
  EXPECT_EQ(reference->estimation.identification.force_slope, defaults.estimation.identification.force_slope);
  EXPECT_EQ(reference->estimation.calibration.low_pass_hz, defaults.estimation.calibration.low_pass_hz);
  EXPECT_EQ(reference->display.port, defaults.display.port);
  const magnetic_tracker::MagneticTrackerOptions tracker;
  ASSERT_EQ(reference->magnetic_trackers.size(), 1U);
  EXPECT_EQ(reference->magnetic_trackers[0].options.tracker.stations, tracker.tracker.stations);
  EXPECT_EQ(reference->magnetic_trackers[0].options.tracker.layout.text(), tracker.tracker.layout.text());
  EXPECT_EQ(reference->magnetic_trackers[0].options.tracker.is_binary, tracker.tracker.is_binary);
  EXPECT_EQ(reference->magnetic_trackers[0].options.tracker.unit, tracker.tracker.unit);
  EXPECT_EQ(reference->magnetic_trackers[0].options.tracker.delay_s, tracker.tracker.delay_s);
  EXPECT_EQ(reference->magnetic_trackers[0].options.sets_up, tracker.sets_up);
  ASSERT_EQ(reference->led_boards.size(), 1U);
  EXPECT_EQ(reference->led_boards[0].options.board.tick_us, led_sync::LedBoardOptions{}.board.tick_us);
}

TEST(Config, UnknownKeyNamesFileLineAndWhatWouldBeRight) {
  const auto config = parse("[recording]\nat_strat = true\n");
  ASSERT_FALSE(config);
  EXPECT_THAT(config.error().message, HasSubstr("field.toml:2: unknown key 'at_strat'"));
  EXPECT_THAT(config.error().message, HasSubstr("at_start"));
}

struct BadConfig {
  const char* text;
  const char* message;
};
void PrintTo(const BadConfig& bad, std::ostream* out) { *out << bad.message; }

class BadConfigTest : public ::testing::TestWithParam<BadConfig> {};

TEST_P(BadConfigTest, IsRefusedWithItsLine) {
  const auto config = parse(GetParam().text);
  ASSERT_FALSE(config) << GetParam().text;
  EXPECT_THAT(config.error().message, HasSubstr(GetParam().message));
}

INSTANTIATE_TEST_SUITE_P(
    All, BadConfigTest,
    ::testing::Values(
        BadConfig{"[[camera]]\nname='c'\ndriver='vidoe'\npath='x'", "field.toml:3: 'camera.driver' must be"},
        BadConfig{"[[camera]]\ndriver='video_file'\npath='x'", "'camera.name' is missing"},
        BadConfig{"[[camera]]\nname='a/b'\ndriver='video_file'\npath='x'", "must be letters"},
        BadConfig{
            "[[camera]]\nname='s'\ndriver='video_file'\npath='x'\n[[sonic]]\nname='s'\nmodel='gill_windmaster'\nport='pty:'",
            "is taken by another device"},
        BadConfig{"[[sonic]]\nname='s'\nmodel='gill_windmastr'\nport='pty:'", "field.toml:3: 'sonic.model'"},
        BadConfig{"[[sonic]]\nname='s'\nmodel='gill_windmaster'\nport='serail:/dev/ttyS0'", "field.toml:4: 'sonic.port'"},
        BadConfig{"[[magnetic_tracker]]\nname='t'\nmodel='liberty'\nport='pty:'", "field.toml:3: 'magnetic_tracker.model'"},
        BadConfig{"[[magnetic_tracker]]\nname='t'\nmodel='polhemus_fastrak'\nport='pty:'\nstations=[1, 5]",
                  "field.toml:5: 'magnetic_tracker.stations' must be numbers from 1 to 4"},
        BadConfig{"[[magnetic_tracker]]\nname='t'\nmodel='polhemus_fastrak'\nport='pty:'\nstations=[2, 2]", "each once"},
        BadConfig{"[[magnetic_tracker]]\nname='t'\nmodel='polhemus_fastrak'\nport='pty:'\nitems='4,1'", "has no position"},
        BadConfig{"[[magnetic_tracker]]\nname='t'\nmodel='polhemus_fastrak'\nport='pty:'\nunit='m'", "'m' is not one of"},
        BadConfig{"[[led_board]]\nname='b'\nport='nowhere'", "field.toml:3: 'led_board.port'"},
        BadConfig{"[[led_board]]\nname='b'\nport='pty:'\ntick_us=1", "must be from 50 to 100000"},
        BadConfig{"[sync]\nwindow_ms = -1", "must be from 0 to 10000"},
        BadConfig{"[estimation]\nband_hz = [4, 0.3]", "0 < low < high"},
        BadConfig{"[[tracking.target]]\ncamera='c'\nname='t'\nregion_px=[1,2,3]", "'tracking.target.region_px' must be"},
        BadConfig{"[[tracking.target]]\ncamera='c'\nname='t'\nregion_px=[1,2,3,4]", "at least 15 x 15 px"},
        BadConfig{"[[tracking.target]]\ncamera='c'\nname='t'\nregion_px=[1,2,30,40]\n"
                  "[[tracking.target]]\ncamera='c'\nname='t'\nregion_px=[1,2,30,40]",
                  "given twice"},
        BadConfig{"[display]\nport = 70000", "must be from 0 to 65535"},
        BadConfig{"[simulation]\n[[sonic]]\nname='s'\nmodel='gill_windmaster'\nport='pty:'", "replaces devices"},
        BadConfig{"site = 'nowhere.toml'", "site sheet"}, BadConfig{"a = [", "field.toml:1"}));

TEST(Config, SiteSheetTravelsAsItIs) {
  const testing::TemporaryFolder folder;
  folder.write("site.toml", "place = 'meadow'  # by the brook\n");
  const auto config = parse_config("site = 'site.toml'", "field.toml", folder.path());
  ASSERT_TRUE(config);
  EXPECT_EQ(config->site_text, "place = 'meadow'  # by the brook\n");
}

TEST(Config, RecordedConfigurationNeedsNoneOfItsFiles) {
  EXPECT_TRUE(parse_recorded_config("site = 'gone.toml'\n[simulation]\nscene = 'gone.toml'\n", "session"));
}

TEST(Config, MissingFileIsNamed) {
  const auto config = load_config("/nowhere/field.toml");
  ASSERT_FALSE(config);
  EXPECT_THAT(config.error().message, HasSubstr("/nowhere/field.toml"));
}

}  // namespace
}  // namespace roseau::daemon
